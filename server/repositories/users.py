"""Users: durable, with argon2id hashes of their passwords."""

from pydantic import Field

from protocol import keys
from protocol.clock import Clock
from protocol.messages import Event, EventLevel
from protocol.messages.base import Message, StampNs
from server.errors import ConflictError, NotFoundError
from server.repositories.documents import Documents, Store, Transaction
from server.roles import Role


class UserRecord(Message):
    """A user as Redis keeps them. Sessions begun before `credentials_ns` (last change of password or role) are void."""

    name: str
    role: Role
    password_hash: str = Field(repr=False)
    created_ns: StampNs
    credentials_ns: StampNs


USERS = Documents(keys.USERS, UserRecord)


class UserRepository:
    """Users by name."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def all(self) -> dict[str, UserRecord]:
        return await self._store.all(USERS)

    async def get(self, name: str) -> UserRecord | None:
        return await self._store.get(USERS, name)

    async def create(self, name: str, role: Role, password_hash: str, actor: str, *, only_first: bool = False) -> bool:
        """ConflictError when the name is taken; False, with nothing done, when `only_first` and there are users."""

        async def work(transaction: Transaction) -> bool:
            users = await transaction.all(USERS)
            if only_first and users:
                return False
            if name in users:
                raise ConflictError(f"user {name!r} exists already")
            now_ns = self._clock.now_ns()
            record = UserRecord(
                name=name, role=role, password_hash=password_hash, created_ns=now_ns, credentials_ns=now_ns
            )
            transaction.put(USERS, name, record)
            transaction.record(self._event(actor, "user_created", f"{actor} created user {name} ({role})"))
            return True

        return await self._store.transaction((USERS,), work)

    async def change(self, name: str, actor: str, *, role: Role | None, password_hash: str | None) -> UserRecord:
        """Sets what is given; ends the user's sessions. NotFoundError; ConflictError for the last administrator's role."""

        async def work(transaction: Transaction) -> UserRecord:
            users = await transaction.all(USERS)
            user = _existing(users, name)
            if role is not None and role is not Role.ADMIN:
                _require_other_admin(users, name)
            changed = user.model_copy(
                update={
                    "role": role or user.role,
                    "password_hash": password_hash or user.password_hash,
                    "credentials_ns": max(self._clock.now_ns(), user.credentials_ns + 1),
                }
            )
            transaction.put(USERS, name, changed)
            what = " and ".join(w for w, given in (("role", role), ("password", password_hash)) if given) or "nothing"
            transaction.record(self._event(actor, "user_changed", f"{actor} changed {what} of user {name}"))
            return changed

        return await self._store.transaction((USERS,), work)

    async def delete(self, name: str, actor: str) -> None:
        """NotFoundError; ConflictError for the last administrator."""

        async def work(transaction: Transaction) -> None:
            users = await transaction.all(USERS)
            _existing(users, name)
            _require_other_admin(users, name)
            transaction.delete(USERS, name)
            transaction.record(self._event(actor, "user_deleted", f"{actor} deleted user {name}"))

        await self._store.transaction((USERS,), work)

    def _event(self, actor: str, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)


def _existing(users: dict[str, UserRecord], name: str) -> UserRecord:
    if name not in users:
        raise NotFoundError(f"there is no user {name!r}")
    return users[name]


def _require_other_admin(users: dict[str, UserRecord], name: str) -> None:
    admins = {user.name for user in users.values() if user.role is Role.ADMIN}
    if admins == {name}:
        raise ConflictError(f"{name!r} is the last administrator")
