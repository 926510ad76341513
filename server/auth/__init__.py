"""Accounts for programs beside the service, such as the launcher: every function takes an asyncio Redis client.

It imports neither the web framework nor anything that starts. Errors are those of `server.errors` (NotFoundError,
ConflictError) and ValueError for names and passwords that are not allowed.
"""

import re
from dataclasses import dataclass

import redis.asyncio

from protocol.clock import Clock, SystemClock
from server.auth.passwords import MAX_LENGTH, MIN_LENGTH, Passwords, readable_password
from server.repositories.documents import Store
from server.repositories.tokens import TokenRecord, TokenRepository
from server.repositories.users import UserRepository
from server.roles import Identity, Role

__all__ = [
    "Identity",
    "Role",
    "Token",
    "User",
    "bootstrap",
    "create_user",
    "delete_user",
    "issue_token",
    "list_tokens",
    "list_users",
    "revoke_token",
    "set_password",
]

FIRST_USER = "admin"
USER_NAME = r"^[a-zA-Z0-9][a-zA-Z0-9._@-]{0,63}$"
TOKEN_NAME = r"^[a-zA-Z0-9][a-zA-Z0-9 ._@-]{0,63}$"  # noqa: S105  # a pattern
_ACTOR = "launcher"


@dataclass(frozen=True, slots=True)
class User:
    """A user without the password."""

    name: str
    role: Role
    created_ns: int


@dataclass(frozen=True, slots=True)
class Token:
    """A token without its text. `last_used_ns` is exact to the minute."""

    id: str
    name: str
    role: Role
    robot: str | None
    created_ns: int
    created_by: str
    last_used_ns: int | None


async def bootstrap(client: redis.asyncio.Redis, clock: Clock | None = None) -> str | None:
    """Creates the administrator `admin` with a random password, which is returned this once, if there are no users yet."""
    users = _users(client, clock)
    if await users.all():
        return None
    password = readable_password()
    created = await users.create(FIRST_USER, Role.ADMIN, await Passwords().hash(password), _ACTOR, only_first=True)
    return password if created else None


async def issue_token(
    client: redis.asyncio.Redis,
    name: str,
    role: Role | str,
    robot: str | None = None,
    *,
    replace: bool = False,
    clock: Clock | None = None,
) -> str:
    """A new API token's text, shown nowhere else. With `replace` it takes the place of those of the same name, else
    ConflictError when there is one. A token of role `robot` needs its robot's id, the others take none."""
    if re.fullmatch(TOKEN_NAME, name) is None:
        raise ValueError(f"{name!r} is no name for a token: letters, digits, spaces and . _ @ -, at most 64")
    token, _ = await _tokens(client, clock).issue(name, Role(role), robot, _ACTOR, replace=replace)
    return token


async def list_tokens(client: redis.asyncio.Redis) -> list[Token]:
    """All tokens, oldest first."""
    return [token_of(record, used_ns) for record, used_ns in await _tokens(client, None).all()]


async def revoke_token(client: redis.asyncio.Redis, name_or_id: str, clock: Clock | None = None) -> None:
    """Makes the token of that id or name void. NotFoundError when there is none."""
    tokens = _tokens(client, clock)
    ids = [record.id for record, _ in await tokens.all() if name_or_id in (record.id, record.name)]
    for token_id in ids or [name_or_id]:
        await tokens.revoke(token_id, _ACTOR)


async def create_user(
    client: redis.asyncio.Redis, name: str, role: Role | str, password: str, clock: Clock | None = None
) -> None:
    """ConflictError when the name is taken."""
    if re.fullmatch(USER_NAME, name) is None:
        raise ValueError(f"{name!r} is no name for a user: letters, digits and . _ @ -, at most 64")
    role = Role(role)
    if role is Role.ROBOT:
        raise ValueError("robots have tokens, not passwords")
    await _users(client, clock).create(name, role, await Passwords().hash(_checked(password)), _ACTOR)


async def set_password(client: redis.asyncio.Redis, name: str, password: str, clock: Clock | None = None) -> None:
    """Sets it and ends the user's sessions. NotFoundError when there is no such user."""
    password_hash = await Passwords().hash(_checked(password))
    await _users(client, clock).change(name, _ACTOR, role=None, password_hash=password_hash)


async def delete_user(client: redis.asyncio.Redis, name: str, clock: Clock | None = None) -> None:
    """NotFoundError when there is no such user, ConflictError for the last administrator."""
    await _users(client, clock).delete(name, _ACTOR)


async def list_users(client: redis.asyncio.Redis) -> list[User]:
    """All users by name."""
    records = (await _users(client, None).all()).values()
    return [User(record.name, record.role, record.created_ns) for record in records]


def token_of(record: TokenRecord, last_used_ns: int | None) -> Token:
    """What may be shown of a token."""
    return Token(record.id, record.name, record.role, record.robot, record.created_ns, record.created_by, last_used_ns)


def _checked(password: str) -> str:
    if not MIN_LENGTH <= len(password) <= MAX_LENGTH:
        raise ValueError(f"a password has {MIN_LENGTH} to {MAX_LENGTH} characters")
    return password


def _users(client: redis.asyncio.Redis, clock: Clock | None) -> UserRepository:
    return UserRepository(Store(client), clock or SystemClock())


def _tokens(client: redis.asyncio.Redis, clock: Clock | None) -> TokenRepository:
    return TokenRepository(Store(client), clock or SystemClock())
