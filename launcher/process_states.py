"""Tells everyone, through the bus, how the children of this launcher are: at once when something changes, else each second."""

import asyncio
from collections.abc import Callable
from contextlib import suppress

from redis.exceptions import RedisError

from protocol import keys
from protocol.bus import Bus
from protocol.channels import PROCESSES
from protocol.clock import Clock
from protocol.messages import ProcessState

TOGETHER_S = 0.05
"""Changes that come this soon after one another are published together."""


class ProcessStates:
    """Publishes to the channel `processes`. While Redis is away nothing is published; nobody waits for it."""

    def __init__(self, bus: Bus, clock: Clock, current: Callable[[], dict[str, ProcessState]]) -> None:
        self._bus = bus
        self._clock = clock
        self._current = current
        self._changed = asyncio.Event()

    def changed(self, _state: ProcessState) -> None:
        """Something is new; publish soon."""
        self._changed.set()

    async def forget_all(self) -> None:
        """Removes what an earlier run left, e.g. processes of cameras that the lab file no longer has."""
        with suppress(RedisError, OSError):
            await self._bus.redis.delete(keys.live(PROCESSES.name))

    async def publish_for_ever(self) -> None:
        """Until cancelled; then this launcher's processes are removed, since nobody looks after them any more."""
        try:
            while True:
                self._changed.clear()
                await self._publish()
                await self._wait(1.0 / PROCESSES.rate_hz)
                await self._clock.sleep(TOGETHER_S)
        finally:
            names = list(self._current())
            if names:
                with suppress(RedisError, OSError):
                    await self._bus.redis.hdel(keys.live(PROCESSES.name), *names)  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients

    async def _publish(self) -> None:
        states = self._current()
        if states:
            with suppress(RedisError, OSError):
                await self._bus.publish_all(PROCESSES, states)

    async def _wait(self, seconds: float) -> None:
        sleeping = asyncio.create_task(self._clock.sleep(seconds))
        changing = asyncio.create_task(self._changed.wait())
        try:
            await asyncio.wait({sleeping, changing}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            sleeping.cancel()
            changing.cancel()
