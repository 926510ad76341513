"""Redis connections whose commands a cancelled task can leave.

redis-py sends each command through `asyncio.wait_for`, which before Python 3.12 drops a cancellation that arrives in the
same turn of the event loop as the end of what it waits for: a task that is told to stop goes on for ever. Here such a
command ends with the cancellation after all, and its connection is closed because nobody will read the answer.
"""

import asyncio
from collections.abc import Iterable
from typing import Any

import redis.asyncio
from redis.asyncio.connection import AbstractConnection


class _LeavableConnection(AbstractConnection):
    """To be mixed in before a connection class of redis-py."""

    async def send_packed_command(self, command: bytes | str | Iterable[bytes], check_health: bool = True) -> None:
        task = asyncio.current_task()
        before = task.cancelling() if task is not None else 0
        await super().send_packed_command(command, check_health)
        if task is not None and task.cancelling() > before:
            await self.disconnect(nowait=True)
            raise asyncio.CancelledError


def make_leavable(client: redis.asyncio.Redis) -> None:
    """Makes the client's future connections end their commands when their task is cancelled."""
    pool = client.connection_pool
    plain: Any = pool.connection_class
    pool.connection_class = type(f"Leavable{plain.__name__}", (_LeavableConnection, plain), {})
