"""Users and API tokens, for administrators."""

from typing import Annotated

from fastapi import APIRouter, Path
from pydantic import ConfigDict, Field, model_validator

from server import auth
from server.access import Admin
from server.auth.passwords import MAX_LENGTH, MIN_LENGTH, readable_password
from server.context import Ctx
from server.errors import InvalidError
from server.roles import Role
from server.routes.answers import refusals
from server.views.base import Body, View

router = APIRouter(tags=["users and tokens"])

_Password = Annotated[str, Field(min_length=MIN_LENGTH, max_length=MAX_LENGTH)]
_UserName = Annotated[str, Path(pattern=auth.USER_NAME, examples=["eva"])]
_TokenId = Annotated[str, Path(pattern=r"^[0-9a-f]{12}$")]


class UserView(View):
    """A user."""

    name: str
    role: Role
    created_ns: int


class NewUser(Body):
    """A user to create; without a password a random one is made."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "eva", "role": "operator"}]})

    name: Annotated[str, Field(pattern=auth.USER_NAME, examples=["eva"])]
    role: Role
    password: _Password | None = None


class NewUserView(UserView):
    """The user created, with the password that was made for them, shown this once (null: the one given)."""

    password: str | None


class UserChange(Body):
    """What to change of a user; their sessions end."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"role": "viewer"}]})

    role: Role | None = None
    password: _Password | None = None


class TokenView(View):
    """A token without its text; `last_used_ns` is exact to the minute."""

    id: str
    name: str
    role: Role
    robot: str | None
    created_ns: int
    created_by: str
    last_used_ns: int | None


class NewToken(Body):
    """A token to issue: role `robot` names its robot, the others do not."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "night shift script", "role": "operator"}]})

    name: Annotated[str, Field(pattern=auth.TOKEN_NAME, examples=["night shift script"])]
    role: Role
    robot: str | None = None

    @model_validator(mode="after")
    def _bound(self) -> "NewToken":
        if (self.role is Role.ROBOT) != (self.robot is not None):
            raise ValueError("a token of role robot names its robot, no other does")
        return self


class NewTokenView(View):
    """A new token with its text, shown this once."""

    id: str
    name: str
    role: Role
    robot: str | None
    token: str = Field(examples=["lilliput_Zm9yIGV4YW1wbGUgb25seSwgbm90IGEgcmVhbCB0b2tlbg"])


@router.get("/users", summary="All users", responses=refusals())
async def list_users(_identity: Admin, context: Ctx) -> list[UserView]:
    """By name."""
    records = (await context.users.all()).values()
    return [UserView(name=r.name, role=r.role, created_ns=r.created_ns) for r in records]


@router.post("/users", summary="Create a user", status_code=201, responses=refusals(409))
async def create_user(identity: Admin, user: NewUser, context: Ctx) -> NewUserView:
    """Refused when the name is taken."""
    _require_person(user.role)
    made = None if user.password is not None else readable_password()
    password_hash = await context.passwords.hash(user.password or made or "")
    created_ns = context.clock.now_ns()
    await context.users.create(user.name, user.role, password_hash, identity.name)
    return NewUserView(name=user.name, role=user.role, created_ns=created_ns, password=made)


@router.put("/users/{name}", summary="Change a user", responses=refusals(404, 409))
async def change_user(identity: Admin, name: _UserName, change: UserChange, context: Ctx) -> UserView:
    """Sets role or password, or both; the user's sessions end. The last administrator stays one."""
    if change.role is not None:
        _require_person(change.role)
    password_hash = None if change.password is None else await context.passwords.hash(change.password)
    record = await context.users.change(name, identity.name, role=change.role, password_hash=password_hash)
    return UserView(name=record.name, role=record.role, created_ns=record.created_ns)


@router.delete("/users/{name}", summary="Delete a user", status_code=204, responses=refusals(404, 409))
async def delete_user(identity: Admin, name: _UserName, context: Ctx) -> None:
    """Their sessions end. The last administrator stays."""
    await context.users.delete(name, identity.name)


@router.get("/tokens", summary="All API tokens", responses=refusals())
async def list_tokens(_identity: Admin, context: Ctx) -> list[TokenView]:
    """Oldest first, without their texts."""
    return [
        TokenView(**record.model_dump(), last_used_ns=last_used_ns)
        for record, last_used_ns in await context.tokens.all()
    ]


@router.post("/tokens", summary="Issue an API token", status_code=201, responses=refusals(409))
async def issue_token(identity: Admin, new: NewToken, context: Ctx) -> NewTokenView:
    """The answer is the only place where its text is ever shown. Refused when the name is taken."""
    if new.robot is not None and new.robot not in {vehicle.id for vehicle in context.lab.vehicles}:
        raise InvalidError(("body", "robot"), f"there is no robot {new.robot!r} in lab {context.lab.name!r}")
    token, record = await context.tokens.issue(new.name, new.role, new.robot, identity.name)
    return NewTokenView(id=record.id, name=record.name, role=record.role, robot=record.robot, token=token)


@router.delete("/tokens/{token_id}", summary="Revoke an API token", status_code=204, responses=refusals(404))
async def revoke_token(identity: Admin, token_id: _TokenId, context: Ctx) -> None:
    """It is void from now on."""
    await context.tokens.revoke(token_id, identity.name)


def _require_person(role: Role) -> None:
    if role is Role.ROBOT:
        raise InvalidError(("body", "role"), "robots have tokens, not passwords")
