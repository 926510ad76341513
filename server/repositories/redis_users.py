"""Redis users of robots that speak GPSS: durable records, of which Redis' own access list is made again whenever Redis forgot it.

Only the SHA-256 of each password is kept, as Redis does; the passwords are random, so nothing slower is needed.
"""

import secrets
from typing import Annotated

from pydantic import Field

from protocol import keys
from protocol.clock import Clock
from protocol.messages import Event, EventLevel
from protocol.messages.base import Identifier, Message, StampNs
from server.errors import ConflictError, NotFoundError
from server.repositories.documents import Documents, Store, Transaction
from server.repositories.tokens import digest


class RedisUserRecord(Message):
    """A robot's Redis user."""

    robot: Identifier
    password_sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    created_ns: StampNs
    created_by: str


REDIS_USERS = Documents(keys.REDIS_USERS, RedisUserRecord)


class RedisUserRepository:
    """The records by robot. Who changes them must also tell Redis (`server.gpss.access`)."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def all(self) -> dict[str, RedisUserRecord]:
        """Robot -> its user."""
        return await self._store.all(REDIS_USERS)

    async def issue(self, robot: str, actor: str, *, replace: bool = False) -> tuple[str, RedisUserRecord]:
        """A new password, which is kept nowhere, and its record. ConflictError when the robot has one already, unless it is to
        be replaced."""
        password = secrets.token_urlsafe(32)

        async def work(transaction: Transaction) -> RedisUserRecord:
            if not replace and await transaction.exists(REDIS_USERS, robot):
                raise ConflictError(f"{robot} has a Redis user already; --replace makes its password void")
            record = RedisUserRecord(
                robot=robot,
                password_sha256=digest(password),
                created_ns=self._clock.now_ns(),
                created_by=actor,
            )
            transaction.put(REDIS_USERS, robot, record)
            transaction.record(self._event(actor, "redis_user_issued", f"{actor} issued a Redis user for {robot}"))
            return record

        return password, await self._store.transaction((REDIS_USERS,), work)

    async def revoke(self, robot: str, actor: str) -> None:
        """NotFoundError when the robot has none."""

        async def work(transaction: Transaction) -> None:
            if not await transaction.exists(REDIS_USERS, robot):
                raise NotFoundError(f"{robot} has no Redis user")
            transaction.delete(REDIS_USERS, robot)
            transaction.record(self._event(actor, "redis_user_revoked", f"{actor} revoked the Redis user of {robot}"))

        await self._store.transaction((REDIS_USERS,), work)

    def _event(self, actor: str, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)
