"""API tokens: durable; only the SHA-256 of each is kept."""

import asyncio
import secrets
from hashlib import sha256
from typing import cast

from protocol import keys
from protocol.clock import Clock
from protocol.messages import Event, EventLevel
from protocol.messages.base import Message, StampNs
from server.errors import ConflictError, NotFoundError
from server.repositories.documents import Documents, Store, Transaction
from server.roles import Role

_PREFIX = "lilliput_"
_USE_NOTED_EVERY_NS = 60_000_000_000
_LOOKED_UP_EVERY_S = 2.0


class TokenRecord(Message):
    """A token as Redis keeps it, under its digest."""

    id: str
    name: str
    role: Role
    robot: str | None
    created_ns: StampNs
    created_by: str


TOKENS = Documents(keys.TOKENS, TokenRecord)
USED = f"{keys.TOKENS}:used"
"""Hash: token id -> when it was last used (ns). Apart from the records, so that noting a use cannot bring a revoked token
back to life."""


class TokenRepository:
    """Tokens by the digest of their text."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock
        self._noted_ns: dict[str, int] = {}
        self._valid: tuple[float, frozenset[bytes]] = -_LOOKED_UP_EVERY_S, frozenset()
        self._looking_up = asyncio.Lock()

    async def all(self) -> list[tuple[TokenRecord, int | None]]:
        """Every token with the time of its last use (to the minute), oldest first."""
        records = await self._store.all(TOKENS)
        used = cast("dict[bytes, bytes]", await self._store.redis.hgetall(USED))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
        ordered = sorted(records.values(), key=lambda record: record.created_ns)
        return [(record, int(used[key]) if (key := record.id.encode()) in used else None) for record in ordered]

    async def find(self, token: str) -> TokenRecord | None:
        """The record of a token's text, noting its use; None when it is not valid."""
        record = await self._store.get(TOKENS, digest(token))
        if record is None:
            return None
        now_ns = self._clock.now_ns()
        if now_ns - self._noted_ns.get(record.id, 0) >= _USE_NOTED_EVERY_NS:
            await self._store.redis.hset(USED, record.id, str(now_ns))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
            self._noted_ns[record.id] = now_ns
        return record

    async def stands(self, token: str) -> bool:
        """Whether the token was valid two seconds ago or later: one look into Redis for all who ask again and again, as the
        streams of a thousand robots do. Its use is not noted."""
        async with self._looking_up:
            now_s = self._clock.monotonic_s()
            if now_s - self._valid[0] >= _LOOKED_UP_EVERY_S:
                digests = cast("list[bytes]", await self._store.redis.hkeys(TOKENS.key))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
                self._valid = now_s, frozenset(digests)
        return digest(token).encode() in self._valid[1]

    async def issue(
        self, name: str, role: Role, robot: str | None, actor: str, *, replace: bool = False
    ) -> tuple[str, TokenRecord]:
        """A new token's text, which is kept nowhere, and its record. With `replace` it takes the place of those of the
        same name, else ConflictError when there is one. ValueError unless exactly robots are bound to a robot."""
        if (role is Role.ROBOT) != (robot is not None):
            raise ValueError("a token of role robot names its robot, no other does")
        token = _PREFIX + secrets.token_urlsafe(32)

        async def work(transaction: Transaction) -> TokenRecord:
            for old_digest, old in (await transaction.all(TOKENS)).items():
                if old.name == name:
                    if not replace:
                        raise ConflictError(f"there is a token {name!r} already")
                    transaction.delete(TOKENS, old_digest)
            record = TokenRecord(
                id=secrets.token_hex(6),
                name=name,
                role=role,
                robot=robot,
                created_ns=self._clock.now_ns(),
                created_by=actor,
            )
            transaction.put(TOKENS, digest(token), record)
            transaction.record(self._event(actor, "token_issued", f"{actor} issued token {name} ({role})"))
            return record

        return token, await self._store.transaction((TOKENS,), work)

    async def revoke(self, token_id: str, actor: str) -> None:
        """NotFoundError when there is no token of that id."""

        async def work(transaction: Transaction) -> None:
            found = {key: record for key, record in (await transaction.all(TOKENS)).items() if record.id == token_id}
            if not found:
                raise NotFoundError(f"there is no token {token_id!r}")
            for key, record in found.items():
                transaction.delete(TOKENS, key)
                transaction.record(self._event(actor, "token_revoked", f"{actor} revoked token {record.name}"))

        await self._store.transaction((TOKENS,), work)
        await self._store.redis.hdel(USED, token_id)  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients

    def _event(self, actor: str, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)


def digest(secret: str) -> str:
    """SHA-256 in hexadecimal: the secrets are random, so nothing slower is needed."""
    return sha256(secret.encode(errors="surrogateescape")).hexdigest()
