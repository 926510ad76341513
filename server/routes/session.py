"""Log in, who am I, log out."""

from typing import Annotated

from fastapi import APIRouter, HTTPException, Request, Response
from pydantic import ConfigDict, Field

from server.access import COOKIE, Somebody
from server.auth.passwords import MAX_LENGTH
from server.context import Ctx
from server.repositories.sessions import LIFETIME_S, SessionRecord
from server.roles import Role
from server.routes.answers import open_refusals, refusals
from server.views.base import Body, View

router = APIRouter(prefix="/session", tags=["session"])


class Login(Body):
    """A user's name and password."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"user": "admin", "password": "kodu-fami-zelo-tiva-4821"}]}
    )

    user: Annotated[str, Field(max_length=64, examples=["admin"])]
    password: Annotated[str, Field(max_length=MAX_LENGTH, examples=["kodu-fami-zelo-tiva-4821"])]


class SessionView(View):
    """Who is logged in; `robot` is the one that a robot's token is bound to."""

    user: str = Field(examples=["admin"])
    role: Role
    robot: str | None = None


@router.post("", summary="Log in", responses=open_refusals(401, 429), status_code=200)
async def log_in(login: Login, request: Request, response: Response, context: Ctx) -> SessionView:
    """Begins a session: the cookie `lilliput_session` stays valid for 12 hours after its last use."""
    address = request.client.host if request.client else ""
    wait_s = context.throttle.wait_s(login.user, address)
    if wait_s > 0:
        seconds = str(int(wait_s) + 1)
        raise HTTPException(
            429, f"too many wrong passwords; try again in {seconds} s", headers={"Retry-After": seconds}
        )
    user = await context.users.get(login.user)
    # Noted before the slow check, so that many guesses at once do not slip through together.
    context.throttle.failed(login.user, address)
    if not await context.passwords.verify(user.password_hash if user else None, login.password) or user is None:
        raise HTTPException(401, "wrong user or password", headers={"WWW-Authenticate": "Bearer"})
    context.throttle.succeeded(login.user, address)
    cookie = await context.sessions.begin(SessionRecord(user=user.name, credentials_ns=user.credentials_ns))
    response.set_cookie(
        COOKIE,
        cookie,
        max_age=LIFETIME_S,
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
        path="/",
    )
    return SessionView(user=user.name, role=user.role)


@router.get("", summary="Who am I", responses=refusals())
async def who_am_i(identity: Somebody) -> SessionView:
    """The user or token that this request is authorized by."""
    return SessionView(user=identity.name, role=identity.role, robot=identity.robot)


@router.delete("", summary="Log out", status_code=204, responses=refusals())
async def log_out(_identity: Somebody, request: Request, response: Response, context: Ctx) -> None:
    """Ends the session; its cookie is void from now on."""
    if cookie := request.cookies.get(COOKIE):
        await context.sessions.end(cookie)
        context.known.note(cookie, None)
    response.delete_cookie(COOKIE, path="/", httponly=True, samesite="strict")
