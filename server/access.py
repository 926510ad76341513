"""Who may do what: identities from the session cookie or a bearer token, and the roles that routes demand.

A request that changes something and is authorized by the cookie alone must carry the header `X-Lilliput: 1`, which a
foreign page cannot send; WebSockets must come from this host's own pages.
"""

import asyncio
from typing import Annotated
from urllib.parse import urlsplit

from fastapi import Depends, HTTPException, Path, Request, Security
from fastapi.security import APIKeyCookie, HTTPAuthorizationCredentials, HTTPBearer
from redis.exceptions import RedisError
from starlette.requests import HTTPConnection

from server.context import Context, Ctx
from server.repositories.tokens import digest
from server.roles import Identity, Role

COOKIE = "lilliput_session"
_HEADER = "x-lilliput"
_PATIENCE_S = 0.3
"""How long Redis may take before a stop is authorized by what was known of its sender last."""
_SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
_cookie_scheme = APIKeyCookie(
    name=COOKIE,
    scheme_name="session",
    description="A browser session. Changes also need the header `X-Lilliput: 1`.",
    auto_error=False,
)
_bearer_scheme = HTTPBearer(
    scheme_name="token", description="An API token: `Authorization: Bearer TOKEN`.", auto_error=False
)

RobotId = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$", examples=["wifibot-14"])]


async def _somebody(
    request: Request,
    context: Ctx,
    cookie: Annotated[str | None, Security(_cookie_scheme)],
    bearer: Annotated[HTTPAuthorizationCredentials | None, Security(_bearer_scheme)],
) -> Identity:
    """401 unless a token or a session proves who it is; 403 when a session's change lacks the header."""
    if "authorization" in request.headers:
        identity = await _by_token(context, bearer.credentials) if bearer is not None else None
        if identity is None:
            raise _unauthorized("this token is not valid")
        return identity
    identity = await _by_cookie(context, cookie)
    if identity is None:
        raise _unauthorized("log in, or send an API token as `Authorization: Bearer TOKEN`")
    if request.method not in _SAFE_METHODS and request.headers.get(_HEADER) != "1":
        raise HTTPException(403, "a change by session cookie needs the header X-Lilliput: 1")
    return identity


Somebody = Annotated[Identity, Depends(_somebody)]


async def _whoever_stops(
    request: Request,
    context: Ctx,
    cookie: Annotated[str | None, Security(_cookie_scheme)],
    bearer: Annotated[HTTPAuthorizationCredentials | None, Security(_bearer_scheme)],
) -> Identity:
    """As `_somebody`; while Redis does not answer, whoever has proven it to this server lately."""
    asking = asyncio.ensure_future(_somebody(request, context, cookie, bearer))
    await asyncio.wait({asking}, timeout=_PATIENCE_S)
    if asking.done() and not isinstance(asking.exception(), RedisError | OSError):
        return _operator_or_robot(asking.result())
    known = identify_by_memory(request, context)
    if known is None or ("authorization" not in request.headers and request.headers.get(_HEADER) != "1"):
        return _operator_or_robot(await asking)
    asking.add_done_callback(lambda done: done.cancelled() or done.exception())  # heard, so that it is not warned of
    return _operator_or_robot(known)


# Not plain functions: FastAPI would send each to a thread and back.
async def _viewer(identity: Somebody) -> Identity:
    return _require(identity, Role.VIEWER)


async def _operator(identity: Somebody) -> Identity:
    return _require(identity, Role.OPERATOR)


async def _admin(identity: Somebody) -> Identity:
    return _require(identity, Role.ADMIN)


def _operator_or_robot(identity: Identity) -> Identity:
    return identity if identity.role is Role.ROBOT else _require(identity, Role.OPERATOR)


async def _this_robot(identity: Somebody, robot_id: RobotId) -> Identity:
    if not identity.is_robot(robot_id):
        raise HTTPException(403, f"this needs a token of role robot for {robot_id}")
    return identity


async def _this_robot_or_operator(identity: Somebody, robot_id: RobotId) -> Identity:
    return identity if identity.is_robot(robot_id) else _require(identity, Role.OPERATOR)


Viewer = Annotated[Identity, Depends(_viewer)]
Operator = Annotated[Identity, Depends(_operator)]
Admin = Annotated[Identity, Depends(_admin)]
WhoeverStops = Annotated[Identity, Depends(_whoever_stops)]
ThisRobot = Annotated[Identity, Depends(_this_robot)]
ThisRobotOrOperator = Annotated[Identity, Depends(_this_robot_or_operator)]


async def identify(connection: HTTPConnection, context: Context) -> Identity | None:
    """Who is at the other end of a WebSocket or page request, by token or cookie; None when they have not proven it."""
    if "authorization" in connection.headers:
        token = _bearer(connection)
        return await _by_token(context, token) if token else None
    return await _by_cookie(context, connection.cookies.get(COOKIE))


async def still_stands(connection: HTTPConnection, context: Context) -> bool:
    """Whether who was identified on this connection still is somebody: as `identify`, at less cost and up to two seconds late
    where it is a token."""
    token = _bearer(connection)
    return await context.tokens.stands(token) if token else await identify(connection, context) is not None


def identify_by_memory(connection: HTTPConnection, context: Context) -> Identity | None:
    """As `identify` answered lately, without Redis."""
    secret = _bearer(connection) if "authorization" in connection.headers else connection.cookies.get(COOKIE)
    return context.known.find(secret) if secret else None


def same_origin(connection: HTTPConnection) -> bool:
    """Whether a WebSocket comes from this host's own pages; programs, which send no Origin, count as such."""
    origin = connection.headers.get("origin")
    if origin is None:
        return True
    try:
        return urlsplit(origin).netloc.lower() == connection.headers.get("host", "").lower()
    except ValueError:
        return False


def _bearer(connection: HTTPConnection) -> str | None:
    scheme, _, token = connection.headers.get("authorization", "").partition(" ")
    return token if scheme.lower() == "bearer" else None


async def _by_token(context: Context, token: str) -> Identity | None:
    record = await context.tokens.find(token)
    if record is None:
        return context.known.note(token, None)
    return context.known.note(token, Identity(record.name, record.role, f"token:{record.id}", record.robot))


async def _by_cookie(context: Context, cookie: str | None) -> Identity | None:
    if not cookie:
        return None
    session = await context.sessions.find(cookie)
    user = await context.users.get(session.user) if session is not None else None
    if session is None or user is None or user.credentials_ns != session.credentials_ns:
        return context.known.note(cookie, None)
    return context.known.note(cookie, Identity(user.name, user.role, f"session:{digest(cookie)[:12]}"))


def _require(identity: Identity, needed: Role) -> Identity:
    if not identity.has(needed):
        raise HTTPException(403, f"this needs the role {needed}, {identity.name} has {identity.role}")
    return identity


def _unauthorized(detail: str) -> HTTPException:
    return HTTPException(401, detail, headers={"WWW-Authenticate": "Bearer"})
