"""Documents in Redis hashes, and transactions over them: what they read cannot change before what they write lands.

Every write of a document announces its hash on `CHANGED`, in the same MULTI, so that whoever shows or obeys documents
need not poll; events are written in it too: nothing changes without a line of history.
"""

import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, cast

import redis.asyncio
from pydantic import BaseModel
from redis.asyncio.client import Pipeline
from redis.exceptions import WatchError

from protocol import keys
from protocol.channels import EVENTS, LAB_INSTANCE, Channel
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages import Event
from server.errors import UnavailableError

M = TypeVar("M", bound=BaseModel)
T = TypeVar("T")
_logger = logging.getLogger(__name__)

CHANGED = f"{keys.PREFIX}:changed"
"""Pub/sub topic: the key of each hash of documents, and of the history's stream, as it changes."""
_ATTEMPTS = 50
_STREAM_LENGTH = 10_000


@dataclass(frozen=True, slots=True)
class Documents(Generic[M]):
    """A hash of documents of one kind by id."""

    key: str
    kind: type[M]


def documents_of(channel: Channel[M]) -> Documents[M]:
    """The newest messages of a LATEST channel, to be read and written within a transaction."""
    return Documents(keys.live(channel.name), channel.message)


class Transaction:
    """Reads see Redis as it is; writes are held back until the work is done and then land together or not at all."""

    def __init__(self, pipeline: Pipeline) -> None:
        self._pipeline = pipeline
        self._writes: list[Callable[[], Any]] = []
        self._changed: set[str] = set()

    async def get(self, documents: Documents[M], name: str) -> M | None:
        """The document of that id, None when there is none. DecodeError, naming it, when it is damaged."""
        raw = cast("bytes | None", await self._pipeline.hget(documents.key, name))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
        return _decoded(documents, name, raw)

    async def find(self, documents: Documents[M], name: str) -> M | None:
        """As `get`, for what is about to be replaced: a damaged document, which is logged, counts as none."""
        try:
            return await self.get(documents, name)
        except DecodeError as error:
            _logger.warning("counts as absent: %s", error)
            return None

    async def exists(self, documents: Documents[Any], name: str) -> bool:
        """Whether there is a document of that id, damaged or not."""
        return bool(await self._pipeline.hexists(documents.key, name))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients

    async def all(self, documents: Documents[M]) -> dict[str, M]:
        """All documents by id; damaged ones are left out and logged."""
        raw = cast("dict[bytes, bytes]", await self._pipeline.hgetall(documents.key))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
        return decode_all(documents, raw)

    def put(self, documents: Documents[M], name: str, document: M) -> None:
        """Writes the document at the end."""
        data = encode(document)
        self._writes.append(lambda: self._pipeline.hset(documents.key, name, data))
        self._changed.add(documents.key)

    def delete(self, documents: Documents[Any], name: str) -> None:
        """Removes the document at the end."""
        self._writes.append(lambda: self._pipeline.hdel(documents.key, name))
        self._changed.add(documents.key)

    def publish(self, channel: Channel[M], instance: str, message: M) -> None:
        """Makes the message the newest of its channel and tells the subscribers, at the end."""
        data = encode(message)
        self._writes.append(lambda: self._pipeline.hset(keys.live(channel.name), instance, data))
        self._writes.append(lambda: self._pipeline.publish(keys.topic(channel.name, instance), data))

    def record(self, event: Event) -> None:
        """Adds a line to the history at the end."""
        fields: dict[Any, Any] = {"i": LAB_INSTANCE, "m": encode(event)}
        stream = keys.stream(EVENTS.name)
        self._changed.add(stream)
        self._writes.append(lambda: self._pipeline.xadd(stream, fields, maxlen=_STREAM_LENGTH, approximate=True))

    async def commit(self) -> None:
        """WatchError when something watched has changed; nothing was written then."""
        self._pipeline.multi()
        for write in self._writes:
            write()
        for key in sorted(self._changed):
            self._pipeline.publish(CHANGED, key)
        await self._pipeline.execute()


class Store:
    """Where the repositories keep their documents."""

    def __init__(self, client: redis.asyncio.Redis) -> None:
        self.redis = client

    async def get(self, documents: Documents[M], name: str) -> M | None:
        """The document of that id, None when there is none. DecodeError, naming it, when it is damaged."""
        raw = cast("bytes | None", await self.redis.hget(documents.key, name))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
        return _decoded(documents, name, raw)

    async def all(self, documents: Documents[M]) -> dict[str, M]:
        """All documents by id; damaged ones are left out and logged."""
        raw = cast("dict[bytes, bytes]", await self.redis.hgetall(documents.key))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
        return decode_all(documents, raw)

    async def transaction(self, watched: tuple[Documents[Any], ...], work: Callable[[Transaction], Awaitable[T]]) -> T:
        """Runs `work`, again when another process changed a watched hash meanwhile, and writes what it left behind.
        An exception from `work` leaves everything as it was."""
        async with self.redis.pipeline(transaction=True) as pipeline:
            for _ in range(_ATTEMPTS):
                try:
                    await pipeline.watch(*(documents.key for documents in watched))
                    transaction = Transaction(pipeline)
                    result = await work(transaction)
                    await transaction.commit()
                    return result
                except WatchError:
                    continue
                finally:
                    await pipeline.reset()
        raise UnavailableError(f"{watched[0].key} changes too fast to be written; try again")


def decode_all(documents: Documents[M], raw: dict[bytes, bytes]) -> dict[str, M]:
    """Decodes a whole hash; one damaged document must not hide the others."""
    decoded: dict[str, M] = {}
    for name, data in sorted(raw.items()):
        try:
            decoded[name.decode()] = decode(documents.kind, data)
        except (DecodeError, UnicodeDecodeError) as error:
            _logger.warning("%s: %s is damaged: %s", documents.key, name.decode(errors="replace"), error)
    return decoded


def _decoded(documents: Documents[M], name: str, raw: bytes | None) -> M | None:
    try:
        return None if raw is None else decode(documents.kind, raw)
    except DecodeError as error:
        raise DecodeError(f"the record {name} in {documents.key} is damaged: {error}") from error
