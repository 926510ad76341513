"""The clock that every part is given instead of reading the machine's own.

Stamps are wall-clock nanoseconds since the epoch (they cross machines); durations are measured on `monotonic_s`.
`SimulatedClock` moves only when told, so a test or a simulated lab runs as fast as its work allows.
"""

import asyncio
import heapq
import itertools
import time
from typing import Protocol


class Clock(Protocol):
    """What the domain packages may know of time."""

    def now_ns(self) -> int:
        """Wall-clock nanoseconds since the epoch."""
        ...

    def monotonic_s(self) -> float:
        """Seconds that never step back, for durations and deadlines."""
        ...

    def wait(self, seconds: float) -> None:
        """Blocks the calling thread."""
        ...

    async def sleep(self, seconds: float) -> None:
        """Suspends the calling task."""
        ...


class SystemClock:
    """The machine's clocks."""

    def now_ns(self) -> int:
        return time.time_ns()

    def monotonic_s(self) -> float:
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        time.sleep(max(0.0, seconds))

    async def sleep(self, seconds: float) -> None:
        await asyncio.sleep(max(0.0, seconds))


class SimulatedClock:
    """A clock that its owner advances; sleeping tasks wake in the order of their deadlines."""

    def __init__(self, start_ns: int = 1_700_000_000_000_000_000) -> None:
        self._start_ns = start_ns
        self._elapsed_ns = 0
        self._order = itertools.count()
        self._sleepers: list[tuple[int, int, asyncio.Future[None]]] = []

    def now_ns(self) -> int:
        return self._start_ns + self._elapsed_ns

    def monotonic_s(self) -> float:
        return self._elapsed_ns / 1e9

    def wait(self, seconds: float) -> None:
        """Nobody else could advance the clock while a thread blocks, so waiting advances it."""
        self._elapsed_ns += max(0, round(seconds * 1e9))

    async def sleep(self, seconds: float) -> None:
        if seconds <= 0:
            await asyncio.sleep(0)
            return
        future = asyncio.get_running_loop().create_future()
        heapq.heappush(self._sleepers, (self._elapsed_ns + round(seconds * 1e9), next(self._order), future))
        await future

    async def advance(self, seconds: float) -> None:
        """Moves on by `seconds`, waking every sleeper on the way at its own time and letting it run until it sleeps again."""
        target_ns = self._elapsed_ns + round(seconds * 1e9)
        await _let_others_run()
        while self._sleepers and self._sleepers[0][0] <= target_ns:
            self._elapsed_ns, _, future = heapq.heappop(self._sleepers)
            if not future.done():
                future.set_result(None)
            await _let_others_run()
        self._elapsed_ns = target_ns


async def _let_others_run(rounds: int = 20) -> None:
    """Yields often enough that tasks chained by a few awaits come to rest."""
    for _ in range(rounds):
        await asyncio.sleep(0)
