"""The bus against a real Redis: what is current, what is new, and what happens while Redis is away."""

import asyncio
import contextlib
import time
from collections.abc import AsyncGenerator, AsyncIterator
from typing import Any, cast

import pytest
from redis.asyncio.client import PubSub

from protocol import keys
from protocol.bus import Bus, Received, SyncBus
from protocol.channels import EVENTS, MANUAL, POSES, RASTERS, STATUSES, Channel
from protocol.errors import BusUnavailableError
from protocol.messages import Event, EventLevel, FloorRaster, ManualDrive, Status, TrackedPose
from tests.redis_fixture import RedisServer

Subscription = AsyncIterator[Received[Any]]


def pose(vehicle: str = "wifibot-14", x: float = 1.0, stamp_ns: int = 1) -> TrackedPose:
    return TrackedPose(vehicle, stamp_ns, x, 0.5, 0.1, 0.0, 0.0, 0.0, (1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4), ("cam0",))


def event(text: str) -> Event:
    return Event(stamp_ns=1, level=EventLevel.INFO, source="tests", kind="noted", text=text)


@pytest.fixture
async def bus(redis_url: str) -> AsyncIterator[Bus]:
    bus = Bus.connect(redis_url)
    yield bus
    await bus.close()


@contextlib.asynccontextmanager
async def subscribed(bus: Bus, *channels: Any, instance: str | None = None) -> AsyncGenerator[Subscription]:
    async with contextlib.aclosing(bus.subscribe(*channels, instance=instance)) as subscription:
        yield subscription


async def following(subscription: Subscription) -> Received[Any]:
    return await asyncio.wait_for(anext(subscription), 10)


async def test_the_newest_of_each_instance_is_kept(bus: Bus) -> None:
    assert await bus.latest(POSES, "wifibot-14") is None
    assert await bus.publish(POSES, "wifibot-14", pose(x=1.0))
    assert await bus.publish_all(POSES, {"wifibot-14": pose(x=2.0), "wifibot-15": pose("wifibot-15")})
    assert await bus.latest(POSES, "wifibot-14") == pose(x=2.0)
    assert await bus.latest_all(POSES) == {"wifibot-14": pose(x=2.0), "wifibot-15": pose("wifibot-15")}


async def test_a_subscriber_gets_what_is_current_and_then_what_is_new(bus: Bus) -> None:
    await bus.publish(POSES, "wifibot-14", pose(x=1.0))
    async with subscribed(bus, POSES, STATUSES) as subscription:
        first = await following(subscription)
        assert (first.channel, first.instance, first.message) == (POSES, "wifibot-14", pose(x=1.0))
        status = Status(robot="wifibot-15", sequence=1, stamp_ns=1, linear_mps=0.1, angular_radps=0)
        await bus.publish(STATUSES, "wifibot-15", status)
        second = await following(subscription)
        assert (second.channel, second.instance, second.message) == (STATUSES, "wifibot-15", status)


async def test_a_subscription_to_one_instance_hears_no_other(bus: Bus) -> None:
    await bus.publish(POSES, "wifibot-14", pose())
    async with subscribed(bus, POSES, instance="wifibot-15") as subscription:
        waiting = asyncio.ensure_future(following(subscription))
        async with asyncio.timeout(10):
            while not await bus.redis.pubsub_numpat():  # noqa: ASYNC110  # the condition is Redis', not ours
                await asyncio.sleep(0)
        await bus.publish(POSES, "wifibot-14", pose(x=2.0))
        await bus.publish(POSES, "wifibot-15", pose("wifibot-15"))
        assert (await waiting).instance == "wifibot-15"


async def test_what_does_not_decode_is_skipped(bus: Bus) -> None:
    await bus.redis.hset(keys.live(POSES.name), "broken", b"{}")  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
    await bus.publish(POSES, "wifibot-14", pose())
    assert await bus.latest_all(POSES) == {"wifibot-14": pose()}
    async with subscribed(bus, POSES) as subscription:
        assert (await following(subscription)).instance == "wifibot-14"
        await bus.redis.publish(keys.topic(POSES.name, "wifibot-15"), b"\xff not JSON")
        await bus.publish(POSES, "wifibot-15", pose("wifibot-15"))
        assert (await following(subscription)).message == pose("wifibot-15")


async def test_several_instances_at_once_reach_every_subscriber(bus: Bus) -> None:
    await bus.publish(POSES, "wifibot-14", pose(x=1.0))
    async with subscribed(bus, POSES) as all_of_them, subscribed(bus, POSES, instance="wifibot-14") as one:
        assert (await following(all_of_them)).message.x == (await following(one)).message.x == 1.0
        others = {name: pose(name) for name in ("wifibot-15", "wifibot-16")}
        await bus.publish_all(POSES, others)
        await bus.publish_all(POSES, {**others, "wifibot-14": pose(x=2.0)})
        found = [await following(all_of_them) for _ in range(5)]
        assert [item.instance for item in found] == [*others, *others, "wifibot-14"]
        assert [item.message for item in found[:2]] == list(others.values())
        assert (await following(one)).message.x == 2.0


async def test_messages_that_arrive_together_are_passed_on_together_and_as_they_are(bus: Bus) -> None:
    async with contextlib.aclosing(bus.subscribe_raw(POSES)) as subscription:
        assert (await anext(subscription)).messages == {}
        sent = {"wifibot-14": b'{"x": 1}', "wifibot-15": b"[]"}
        assert await bus.publish_raw(POSES, sent)
        assert (await anext(subscription)).messages == sent
        assert await bus.latest_raw(POSES) == sent
        assert await bus.publish_raw(POSES, {})


@pytest.mark.parametrize("batch", [b"", b"[]", b"{", b'{"wifibot-14": }', b"\xff", b'{"a": 1} x'])
async def test_a_damaged_batch_is_skipped(bus: Bus, batch: bytes) -> None:
    await bus.publish(POSES, "wifibot-14", pose())
    async with subscribed(bus, POSES) as subscription:
        await following(subscription)
        await bus.redis.publish(keys.batch(POSES.name), batch)
        await bus.redis.publish(keys.batch(POSES.name), b'{"wifibot-15": {}}')
        await bus.publish(POSES, "wifibot-15", pose("wifibot-15"))
        assert (await following(subscription)).message == pose("wifibot-15")


async def test_a_subscription_goes_on_after_redis_was_killed(bus: Bus, redis_server: RedisServer) -> None:
    await bus.publish(POSES, "wifibot-14", pose(x=1.0))
    async with subscribed(bus, POSES) as subscription:
        assert (await following(subscription)).message.x == 1.0
        redis_server.kill()
        waiting = asyncio.ensure_future(following(subscription))
        assert not await bus.publish(POSES, "wifibot-14", pose(x=2.0))
        redis_server.start()
        # What is current comes again first: the subscriber need not know that anything happened.
        assert (await waiting).message.x == 1.0
        await bus.publish(POSES, "wifibot-14", pose(x=3.0))
        assert (await following(subscription)).message.x == 3.0


class Racing(Bus):
    """Publishes at the worst moment: just after a subscriber has read what is current."""

    async def latest_raw(self, channel: Channel[Any]) -> dict[str, bytes]:
        current = await super().latest_raw(channel)
        if channel is POSES:
            await self.publish(POSES, "wifibot-14", pose(x=7.0))
        return current


async def test_nothing_falls_between_what_is_current_and_what_is_new(
    redis_server: RedisServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    bus = Racing.connect(redis_server.url)
    send = PubSub.execute_command

    async def slow_way(pubsub: PubSub, *arguments: Any) -> None:
        """The command leaves at once as far as its sender knows, and reaches Redis later."""
        await pubsub.connect()
        late.append(asyncio.ensure_future(later(pubsub, *arguments)))

    async def later(pubsub: PubSub, *arguments: Any) -> None:
        await asyncio.sleep(0.1)
        await send(pubsub, *arguments)

    late: list[asyncio.Future[None]] = []
    monkeypatch.setattr(PubSub, "execute_command", slow_way)
    async with subscribed(bus, POSES, STATUSES) as subscription:
        assert (await following(subscription)).message == pose(x=7.0)
        await asyncio.gather(*late)
    await bus.close()


async def test_what_was_said_while_a_connection_was_made_anew_is_not_lost(bus: Bus) -> None:
    await bus.publish(POSES, "wifibot-14", pose(x=1.0))
    async with subscribed(bus, POSES, STATUSES) as subscription:
        assert (await following(subscription)).message.x == 1.0
        await bus.redis.client_kill_filter(_type="pubsub")
        await bus.publish(POSES, "wifibot-14", pose(x=2.0))
        assert (await following(subscription)).message.x == 2.0


async def test_a_subscription_begun_without_redis_waits_for_it(redis_server: RedisServer) -> None:
    redis_server.kill()
    bus = Bus.connect(redis_server.url)
    async with subscribed(bus, POSES) as subscription:
        waiting = asyncio.ensure_future(following(subscription))
        await asyncio.sleep(0)
        redis_server.start()
        await bus.publish(POSES, "wifibot-14", pose())
        assert (await waiting).message == pose()
    await bus.close()


async def test_latest_messages_are_dropped_and_counted_while_redis_is_away(bus: Bus, redis_server: RedisServer) -> None:
    redis_server.kill()
    assert not await bus.publish(POSES, "wifibot-14", pose())
    assert not await bus.publish_all(POSES, {"wifibot-14": pose(), "wifibot-15": pose("wifibot-15")})
    assert bus.dropped == 3
    with pytest.raises(BusUnavailableError, match="poses"):
        await bus.latest(POSES, "wifibot-14")
    with pytest.raises(BusUnavailableError, match="poses"):
        await bus.latest_all(POSES)


async def test_a_message_that_must_arrive_raises_while_redis_is_away(bus: Bus, redis_server: RedisServer) -> None:
    await bus.publish(EVENTS, "lab", event("before"))
    redis_server.kill()
    with pytest.raises(BusUnavailableError, match="events of lab"):
        await bus.publish(EVENTS, "lab", event("lost"))
    with pytest.raises(BusUnavailableError, match="events"):
        await bus.history(EVENTS)
    redis_server.start()
    await bus.publish(EVENTS, "lab", event("after"))
    assert [item.message.text for item in await bus.history(EVENTS)] == ["before", "after"]
    assert bus.dropped == 0


async def test_history_is_oldest_first_and_ends_with_the_newest(bus: Bus) -> None:
    for number in range(7):
        await bus.publish(EVENTS, f"source-{number}", event(str(number)))
    received = await bus.history(EVENTS, count=3)
    assert [(item.instance, item.message.text) for item in received] == [
        ("source-4", "4"),
        ("source-5", "5"),
        ("source-6", "6"),
    ]


async def test_a_frozen_redis_holds_nobody_up_for_long(bus: Bus, redis_server: RedisServer) -> None:
    await bus.publish(POSES, "wifibot-14", pose())
    redis_server.pause()
    try:
        began = time.monotonic()
        assert not await bus.publish(POSES, "wifibot-14", pose())
        assert time.monotonic() - began < 4
    finally:
        redis_server.resume()


async def test_channels_of_bytes_and_of_models_travel(bus: Bus) -> None:
    raster = FloorRaster("cam0", 1, 0.0, 0.0, 0.05, 9, 1, b"\x80\x00", b"\xff\x80")
    await bus.publish(RASTERS, "cam0", raster)
    assert await bus.latest(RASTERS, "cam0") == raster
    hand = ManualDrive(
        robot="wifibot-14", linear_mps=0.2, angular_radps=-0.1, holder="session-1", by="anna", expires_ns=5
    )
    await bus.publish(MANUAL, "wifibot-14", hand)
    assert await bus.latest(MANUAL, "wifibot-14") == hand


def test_the_blocking_bus_publishes_and_reads(redis_server: RedisServer) -> None:
    bus = SyncBus.connect(redis_server.url)
    assert bus.latest_all(POSES) == {}
    assert bus.publish(POSES, "wifibot-14", pose())
    assert bus.latest_all(POSES) == {"wifibot-14": pose()}
    redis_server.kill()
    assert not bus.publish(POSES, "wifibot-14", pose(x=2.0))
    assert bus.dropped == 1
    assert bus.latest_all(POSES) == {}
    with pytest.raises(BusUnavailableError, match="events of lab"):
        bus.publish(EVENTS, "lab", event("lost"))
    redis_server.start()
    assert bus.publish(POSES, "wifibot-14", pose(x=3.0))
    assert bus.publish(EVENTS, "lab", event("kept"))
    assert bus.latest_all(POSES) == {"wifibot-14": pose(x=3.0)}
    bus.close()


async def test_both_buses_hear_each_other(bus: Bus, redis_url: str) -> None:
    blocking = SyncBus.connect(redis_url)
    blocking.publish(EVENTS, "lab", event("from a thread"))
    assert [item.message.text for item in await bus.history(EVENTS)] == ["from a thread"]
    await bus.publish(POSES, "wifibot-14", pose())
    assert blocking.latest_all(POSES) == {"wifibot-14": pose()}
    blocking.close()
