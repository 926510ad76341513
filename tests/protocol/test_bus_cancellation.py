"""A task that uses the bus ends when it is cancelled, whatever it is doing at that moment."""

import asyncio

import pytest

from protocol.bus import Bus


@pytest.mark.parametrize("commands", [1, 3])
async def test_a_cancelled_task_ends_at_every_moment_of_a_command(redis_url: str, commands: int) -> None:
    bus = Bus.connect(redis_url)

    async def use_for_ever() -> None:
        while True:
            pipeline = bus.redis.pipeline(transaction=False)
            for number in range(commands):
                pipeline.set(f"key{number}", "value")
            await pipeline.execute()

    for turns in range(60):
        task = asyncio.create_task(use_for_ever())
        for _ in range(turns):
            await asyncio.sleep(0)
        task.cancel()
        await asyncio.wait({task}, timeout=2.0)
        assert task.cancelled(), f"cancelled after {turns} turns it goes on"
    assert await bus.redis.get("key0") == b"value", "and the client is of use afterwards"
    await bus.close()
