"""The pool of Redis connections: many wait their turn, nobody is refused, and who gives up is in nobody's way."""

import asyncio
import time
from typing import Any

import pytest
import redis.asyncio
from redis.exceptions import TimeoutError as RedisTimeoutError

from protocol.bus import Bus
from protocol.redis_connection import PatientPool
from tests.redis_fixture import RedisServer


async def test_many_more_tasks_than_connections_are_all_served(redis_url: str) -> None:
    bus = Bus.connect(redis_url)
    await asyncio.gather(*(bus.redis.incr("count") for _ in range(500)))
    assert await bus.redis.get("count") == b"500"
    assert int((await bus.redis.info("clients"))["connected_clients"]) <= 64
    await bus.close()


async def test_one_that_gives_up_leaves_its_turn_to_the_next(redis_url: str) -> None:
    client = redis.asyncio.Redis.from_pool(PatientPool.from_url(redis_url, max_connections=2))

    async def use() -> None:
        await client.incr("count")

    for turns in range(40):
        tasks = [asyncio.create_task(use()) for _ in range(12)]
        for _ in range(turns):
            await asyncio.sleep(0)
        for task in tasks[::3]:
            task.cancel()
        await asyncio.wait_for(asyncio.gather(*tasks, return_exceptions=True), 5)
    assert await client.get("count") is not None
    await client.aclose()


async def test_patience_has_an_end(redis_server: RedisServer) -> None:
    pool = PatientPool.from_url(redis_server.url, max_connections=1, patience_s=0.1)
    client = redis.asyncio.Redis.from_pool(pool)
    async with client.pubsub() as holding:
        await holding.subscribe("topic")
        began_s = time.monotonic()
        with pytest.raises(RedisTimeoutError, match="no connection to Redis became free"):
            await client.get("key")
        assert 0.1 <= time.monotonic() - began_s < 1.0
    assert await client.get("key") is None
    await client.aclose()


async def test_long_commands_arrive_as_short_ones_do(redis_url: str) -> None:
    client = redis.asyncio.Redis.from_pool(PatientPool.from_url(redis_url))
    entries: dict[Any, Any] = {
        f"name {number} ü": value for number, value in enumerate([b"\x00\r\n", "ü", 7, -0.5, b"x" * 20_000] * 10)
    }
    await client.hset("long", mapping=entries)  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
    for name, value in entries.items():
        await client.hset("short", name, value)  # pyright: ignore[reportGeneralTypeIssues, reportArgumentType]
    long, short = await client.hgetall("long"), await client.hgetall("short")  # pyright: ignore[reportGeneralTypeIssues]
    assert len(long) == len(entries)
    assert long == short
    await client.hset("views", mapping={str(number): memoryview(b"bytes") for number in range(40)})  # pyright: ignore[reportGeneralTypeIssues, reportArgumentType]
    assert set((await client.hgetall("views")).values()) == {b"bytes"}  # pyright: ignore[reportGeneralTypeIssues]
    await client.aclose()
