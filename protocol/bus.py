"""Redis as the bus: publish to channels, read the newest, subscribe; asynchronous and blocking versions.

A LATEST message that Redis does not take is dropped and counted (the next one supersedes it); an EVERY message raises
BusUnavailableError. Subscriptions survive a restart of Redis: they reconnect with backoff and begin again with what is
current (snapshot first, then the stream), so a subscriber need not know that anything happened.
"""

import logging
from collections.abc import AsyncGenerator, Iterable, Mapping
from contextlib import aclosing
from dataclasses import dataclass
from typing import Any, Generic, Self, TypeVar, cast

import msgspec
import redis
import redis.asyncio
from msgspec import Struct
from pydantic import BaseModel
from redis.asyncio.retry import Retry as AsyncRetry
from redis.backoff import NoBackoff
from redis.retry import Retry

from protocol import keys
from protocol.channels import Channel, Delivery
from protocol.clock import Clock, SystemClock
from protocol.codec import decode, encode
from protocol.errors import BusUnavailableError, DecodeError
from protocol.redis_connection import PatientPool

M = TypeVar("M", bound=BaseModel | Struct)
_logger = logging.getLogger(__name__)

UNAVAILABLE = (redis.ConnectionError, redis.TimeoutError, ConnectionError)
"""What redis-py raises when the server is out of reach (BusyLoadingError, while it reads its file, is a ConnectionError)."""
_TIMEOUT_S = 2.0
_RETRIED = (redis.ConnectionError,)
"""A connection that Redis closed is opened again at once. A timeout is not tried again: it has cost enough time, and what
timed out may have been done (an event would appear twice)."""
_READ_BYTES = 262_144
"""At once: a fleet's messages come in batches."""
_STREAM_LENGTH = 10_000
_FIRST_RETRY_S, _LAST_RETRY_S = 0.05, 1.0
_BATCHES = msgspec.json.Decoder(dict[str, msgspec.Raw])


@dataclass(frozen=True, slots=True)
class Received(Generic[M]):
    """A message with the channel's instance that it is of."""

    channel: Channel[M]
    instance: str
    message: M


@dataclass(frozen=True, slots=True)
class ReceivedRaw:
    """Messages of a channel that arrived together, by instance, still encoded."""

    channel: Channel[Any]
    messages: Mapping[str, bytes]


class SyncBus:
    """The bus for loops that block, such as a camera's."""

    def __init__(self, client: redis.Redis) -> None:
        self.redis = client
        self.dropped = 0

    @classmethod
    def connect(cls, url: str) -> Self:
        """Connects lazily: nothing fails before the first call."""
        return cls(
            redis.Redis.from_url(
                url, socket_timeout=_TIMEOUT_S, socket_connect_timeout=_TIMEOUT_S, retry=Retry(NoBackoff(), 1, _RETRIED)
            )
        )

    def publish(self, channel: Channel[M], instance: str, message: M) -> bool:
        """Whether Redis took the message; see the module on what happens when it did not."""
        data = encode(message)
        try:
            if channel.delivery is Delivery.EVERY:
                self.redis.xadd(
                    keys.stream(channel.name), {"i": instance, "m": data}, maxlen=_STREAM_LENGTH, approximate=True
                )
                return True
            pipeline = self.redis.pipeline(transaction=False)
            pipeline.hset(keys.live(channel.name), instance, data)
            pipeline.publish(keys.topic(channel.name, instance), data)
            pipeline.execute()
        except UNAVAILABLE as error:
            if channel.delivery is Delivery.EVERY:
                raise BusUnavailableError(f"{channel.name} of {instance} not delivered: {error}") from error
            self.dropped += 1
            return False
        return True

    def latest_all(self, channel: Channel[M]) -> dict[str, M]:
        """The newest message of every instance; empty while Redis is out of reach."""
        try:
            raw = cast("dict[bytes, bytes]", self.redis.hgetall(keys.live(channel.name)))
        except UNAVAILABLE:
            return {}
        return _decoded(channel, _named(channel, raw))

    def close(self) -> None:
        _tell_dropped(self.dropped)
        self.redis.close()


class Bus:
    """The bus for asyncio."""

    def __init__(self, client: redis.asyncio.Redis, clock: Clock | None = None) -> None:
        self.redis = client
        self.dropped = 0
        self._clock = clock or SystemClock()

    @classmethod
    def connect(cls, url: str, clock: Clock | None = None) -> Self:
        """Connects lazily: nothing fails before the first call."""
        pool = PatientPool.from_url(
            url,
            socket_timeout=_TIMEOUT_S,
            socket_connect_timeout=_TIMEOUT_S,
            socket_read_size=_READ_BYTES,
            retry=AsyncRetry(NoBackoff(), 1, _RETRIED),
        )
        return cls(redis.asyncio.Redis.from_pool(pool), clock)

    async def publish(self, channel: Channel[M], instance: str, message: M) -> bool:
        """Whether Redis took the message; see the module on what happens when it did not."""
        return await self.publish_all(channel, {instance: message})

    async def publish_all(self, channel: Channel[M], messages: Mapping[str, M]) -> bool:
        """One round trip for many instances of a channel."""
        return await self.publish_raw(channel, {instance: encode(message) for instance, message in messages.items()})

    async def publish_raw(self, channel: Channel[Any], messages: Mapping[str, bytes]) -> bool:
        """The same for messages that are encoded already. On a LATEST channel several make one publication: what it costs
        everybody else then does not grow with the fleet."""
        if not messages:
            return True
        pipeline = self.redis.pipeline(transaction=False)
        if channel.delivery is Delivery.EVERY:
            for instance, data in messages.items():
                pipeline.xadd(
                    keys.stream(channel.name), {"i": instance, "m": data}, maxlen=_STREAM_LENGTH, approximate=True
                )
        else:
            pipeline.hset(keys.live(channel.name), mapping={**messages})  # pyright: ignore[reportUnusedCoroutine]  # queued
            topic, data = publication(channel, messages)
            pipeline.publish(topic, data)
        try:
            await pipeline.execute()
        except UNAVAILABLE as error:
            if channel.delivery is Delivery.EVERY:
                raise BusUnavailableError(f"{channel.name} of {', '.join(messages)} not delivered: {error}") from error
            self.dropped += len(messages)
            return False
        return True

    async def latest(self, channel: Channel[M], instance: str) -> M | None:
        """The newest message of one instance, None when there is none. BusUnavailableError while Redis is out of reach."""
        try:
            raw = cast("bytes | None", await self.redis.hget(keys.live(channel.name), instance))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
        except UNAVAILABLE as error:
            raise BusUnavailableError(f"cannot read {channel.name}: {error}") from error
        return None if raw is None else decode(channel.message, raw)

    async def latest_all(self, channel: Channel[M]) -> dict[str, M]:
        """The newest message of every instance. BusUnavailableError while Redis is out of reach."""
        return _decoded(channel, await self.latest_raw(channel))

    async def latest_raw(self, channel: Channel[Any]) -> dict[str, bytes]:
        """The same, still encoded."""
        try:
            raw = cast("dict[bytes, bytes]", await self.redis.hgetall(keys.live(channel.name)))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
        except UNAVAILABLE as error:
            raise BusUnavailableError(f"cannot read {channel.name}: {error}") from error
        return _named(channel, raw)

    async def history(self, channel: Channel[M], count: int = 100) -> list[Received[M]]:
        """The newest `count` messages of an EVERY channel, oldest first. BusUnavailableError while Redis is out of reach."""
        try:
            entries = await self.redis.xrevrange(keys.stream(channel.name), count=count)
        except UNAVAILABLE as error:
            raise BusUnavailableError(f"cannot read {channel.name}: {error}") from error
        received = (_from_entry(channel, fields) for _, fields in reversed(cast("list[Any]", entries)))
        return [item for item in received if item is not None]

    async def subscribe(self, *channels: Channel[Any], instance: str | None = None) -> AsyncGenerator[Received[Any]]:
        """What is current on the LATEST channels, then everything new, for ever; of one instance or of all.

        What is current is read only when Redis has confirmed the subscription, so that nothing falls between the two.
        Cancel the task or close the generator to end it.
        """
        async with aclosing(self.subscribe_raw(*channels, instance=instance)) as said:
            async for together in said:
                for name, data in together.messages.items():
                    received = _received(together.channel, name, data)
                    if received is not None:
                        yield received

    async def subscribe_raw(self, *channels: Channel[Any], instance: str | None = None) -> AsyncGenerator[ReceivedRaw]:
        """As `subscribe`, without decoding: for who passes messages on, or needs few of many."""
        by_name = {channel.name: channel for channel in channels}
        topics = [keys.topic(channel.name, instance or "*") for channel in channels]
        topics += [keys.batch(channel.name) for channel in channels]
        delay_s = _FIRST_RETRY_S
        while True:
            try:
                async with self.redis.pubsub(push_handler_func=_as_it_is) as pubsub:
                    await pubsub.psubscribe(*topics)
                    confirmed: set[bytes] = set()
                    while True:
                        item = cast("dict[str, Any] | None", await pubsub.get_message(timeout=_TIMEOUT_S / 2))
                        if item is None:
                            await pubsub.ping()  # pyright: ignore[reportGeneralTypeIssues]  # notices a dead connection
                        elif item["type"] == "psubscribe":
                            confirmed.add(cast("bytes", item["channel"]))
                            if len(confirmed) < len(topics):
                                continue
                            # Also after a reconnection that redis-py made by itself: what was said meanwhile is lost.
                            confirmed.clear()
                            for channel in channels:
                                current = await self.latest_raw(channel)
                                yield ReceivedRaw(channel, _only(instance, current))
                            delay_s = _FIRST_RETRY_S
                        elif item["type"] == "pmessage":
                            _, _, name, *source = cast("bytes", item["channel"]).split(b":", 3)
                            channel, data = by_name[name.decode()], cast("bytes", item["data"])
                            said = _named(channel, {source[0]: data}) if source else _unbatched(channel, data)
                            yield ReceivedRaw(channel, _only(instance, said))
            except (*UNAVAILABLE, BusUnavailableError) as error:
                _logger.warning("Redis is out of reach, retrying in %.2f s: %s", delay_s, error)
                await self._clock.sleep(delay_s)
                delay_s = min(_LAST_RETRY_S, delay_s * 2)

    async def close(self) -> None:
        _tell_dropped(self.dropped)
        await self.redis.aclose()


async def _as_it_is(response: object) -> object:
    """Instead of redis-py's (8.1) own, which makes a text of every message for a log that nobody reads: of a large fleet's
    messages that takes as long as all else that is done to read them."""
    return response


def _tell_dropped(count: int) -> None:
    if count:
        _logger.info("%d messages were dropped while Redis was out of reach", count)


def publication(channel: Channel[Any], messages: Mapping[str, bytes]) -> tuple[str, bytes]:
    """The topic, and what to publish on it, for encoded messages of a LATEST channel by instance, at least one."""
    if len(messages) == 1:
        ((instance, data),) = messages.items()
        return keys.topic(channel.name, instance), data
    entries = b",".join(b"%s:%s" % (msgspec.json.encode(instance), data) for instance, data in messages.items())
    return keys.batch(channel.name), b"{%s}" % entries


def _unbatched(channel: Channel[Any], data: bytes) -> dict[str, bytes]:
    """The messages of a batch; none, and a line in the log, when it is damaged."""
    try:
        return {name: bytes(message) for name, message in _BATCHES.decode(data).items()}
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        _logger.warning("ignored a batch on %s: %s", channel.name, error)
        return {}


def _named(channel: Channel[Any], raw: Mapping[bytes, bytes]) -> dict[str, bytes]:
    """By the instances' names; what has a name that is none is left out with a line in the log."""
    found: dict[str, bytes] = {}
    for name, data in raw.items():
        try:
            found[name.decode()] = data
        except UnicodeDecodeError as error:
            _logger.warning("ignored a message on %s of %r: %s", channel.name, name, error)
    return found


def _received(channel: Channel[M], instance: str, data: bytes) -> Received[M] | None:
    """None, and a line in the log, for what does not decode: one bad producer must not end a subscriber."""
    try:
        return Received(channel, instance, decode(channel.message, data))
    except DecodeError as error:
        _logger.warning("ignored a message on %s of %s: %s", channel.name, instance, error)
        return None


def _decoded(channel: Channel[M], raw: Mapping[str, bytes]) -> dict[str, M]:
    received: Iterable[Received[M] | None] = (_received(channel, name, data) for name, data in raw.items())
    return {item.instance: item.message for item in received if item is not None}


def _from_entry(channel: Channel[M], fields: dict[bytes, bytes]) -> Received[M] | None:
    named = _named(channel, {fields.get(b"i", b""): fields.get(b"m", b"")})
    return next((_received(channel, name, data) for name, data in named.items()), None)


def _only(instance: str | None, messages: dict[str, bytes]) -> dict[str, bytes]:
    return messages if instance is None else {name: data for name, data in messages.items() if name == instance}
