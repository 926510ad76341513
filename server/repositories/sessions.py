"""Browser sessions: a random cookie whose SHA-256 names a key that expires 12 hours after the last use."""

import secrets
from typing import cast

from protocol import keys
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages.base import Message, StampNs
from server.repositories.documents import Store
from server.repositories.tokens import digest

LIFETIME_S = 12 * 3600
_RENEW_BELOW_S = LIFETIME_S - 600


class SessionRecord(Message):
    """Whose session it is; void when the user's credentials changed after `credentials_ns`."""

    user: str
    credentials_ns: StampNs


class SessionRepository:
    """Sessions by the digest of their cookie."""

    def __init__(self, store: Store) -> None:
        self._redis = store.redis

    async def begin(self, record: SessionRecord) -> str:
        """The cookie's text, which is kept nowhere."""
        cookie = secrets.token_urlsafe(32)
        await self._redis.set(keys.session(digest(cookie)), encode(record), ex=LIFETIME_S)
        return cookie

    async def find(self, cookie: str) -> SessionRecord | None:
        """The session of a cookie, which lives on for its whole time; None when there is none."""
        key = keys.session(digest(cookie))
        pipeline = self._redis.pipeline(transaction=False)
        pipeline.get(key)
        pipeline.ttl(key)
        raw, left_s = cast("tuple[bytes | None, int]", await pipeline.execute())
        if raw is None:
            return None
        if left_s < _RENEW_BELOW_S:
            await self._redis.expire(key, LIFETIME_S)
        try:
            return decode(SessionRecord, raw)
        except DecodeError:
            return None

    async def end(self, cookie: str) -> None:
        await self._redis.delete(keys.session(digest(cookie)))
