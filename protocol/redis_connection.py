"""Redis connections whose commands a cancelled task can leave, from a pool at which many tasks may wait.

redis-py sends each command through `asyncio.wait_for`, which before Python 3.12 drops a cancellation that arrives in the
same turn of the event loop as the end of what it waits for: a task that is told to stop goes on for ever. Here such a
command ends with the cancellation after all, and its connection is closed because nobody will read the answer.

redis-py's pool refuses whoever comes when all its connections are taken: when a server comes back, and hundreds of robots with
it, most would be told that Redis is out of reach. Here they wait their turn. (Its own pool that waits loses a connection when
the task that gives it back is cancelled at the wrong moment.)
"""

import asyncio
from collections import deque
from collections.abc import Iterable
from typing import Any

import redis.asyncio
from hiredis import pack_command
from redis.asyncio.connection import AbstractConnection
from redis.exceptions import MaxConnectionsError
from redis.exceptions import TimeoutError as RedisTimeoutError

MOST_CONNECTIONS = 64
"""Redis does one thing at a time: more of them only wait elsewhere."""


_LONG = 32
"""Arguments of a command."""


class _LeavableConnection(AbstractConnection):
    """To be mixed in before a connection class of redis-py."""

    async def send_packed_command(self, command: bytes | str | Iterable[bytes], check_health: bool = True) -> None:
        task = asyncio.current_task()
        before = task.cancelling() if task is not None else 0
        await super().send_packed_command(command, check_health)
        if task is not None and task.cancelling() > before:
            await self.disconnect(nowait=True)
            raise asyncio.CancelledError

    def pack_command(self, *args: Any) -> list[bytes]:
        """Long commands by hiredis, as redis-py's blocking connections have it. The usual way joins each argument to those
        before: of a large fleet's commands that takes longer than all else that is done to send them."""
        if len(args) < _LONG:
            return super().pack_command(*args)
        name = args[0].encode() if isinstance(args[0], str) else args[0]
        words: Any = (*name.split(), *args[1:])  # hiredis' stub speaks of one argument
        try:
            return [pack_command(words)]
        except TypeError:  # of a kind that only redis-py's own encoder can tell what to do with
            return super().pack_command(*args)


class PatientPool(redis.asyncio.ConnectionPool):
    """Its connections are leavable. Who gets none within `patience_s` is told by redis' TimeoutError."""

    def __init__(self, *, patience_s: float = 2.0, max_connections: int = MOST_CONNECTIONS, **settings: Any) -> None:
        super().__init__(max_connections=max_connections, **settings)
        plain: Any = self.connection_class
        self.connection_class = type(f"Leavable{plain.__name__}", (_LeavableConnection, plain), {})
        self._patience_s = patience_s
        self._waiting: deque[asyncio.Future[None]] = deque()

    async def get_connection(self, *_arguments: Any, **_options: Any) -> AbstractConnection:
        while True:
            if not self.can_get_connection():
                await self._wait_for_one()
            try:
                return await super().get_connection()
            except MaxConnectionsError:  # somebody was quicker
                continue

    async def release(self, connection: AbstractConnection) -> None:
        try:
            await super().release(connection)
        finally:
            self._wake()

    async def _wait_for_one(self) -> None:
        try:
            async with asyncio.timeout(self._patience_s):
                while not self.can_get_connection():
                    await self._turn()
        except TimeoutError as error:
            raise RedisTimeoutError(f"no connection to Redis became free in {self._patience_s:g} s") from error

    async def _turn(self) -> None:
        """Until a connection may be free."""
        woken: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.append(woken)
        try:
            await woken
        except BaseException:
            if woken.done() and not woken.cancelled():
                self._wake()  # the turn is somebody else's then
            raise

    def _wake(self) -> None:
        while self._waiting:
            first = self._waiting.popleft()
            if not first.done():
                first.set_result(None)
                return
