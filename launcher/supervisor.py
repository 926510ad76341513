"""Owns all children of `./lilliput up`: none outlives it, and ending them all takes less than 5 s.

    async with Supervisor(logs, clock, tell, changed) as supervisor:
        supervisor.start(spec)
        await asked_to_stop.wait()

Leaving the block, for whatever reason, sends SIGTERM to everything, SIGKILL after `TERM_S`; those that end last
(Redis, which the others still write to) are asked when the others are gone.
"""

import asyncio
from collections.abc import Callable, Iterable
from pathlib import Path
from types import TracebackType
from typing import Self

from launcher.child import Child, ChildSpec
from launcher.log_file import CappedLog
from protocol.clock import Clock
from protocol.messages import ProcessState

TERM_S = 4.0
"""From the request to end until the ordinary children are killed."""
LAST_TERM_S = 4.6
"""From the request to end until the children that end last are killed."""


class Supervisor:
    """Starts children and keeps them running. `tell(name, line)` shows a line; `changed(state)` gets every new state."""

    def __init__(
        self,
        logs: Path,
        clock: Clock,
        tell: Callable[[str, str], None],
        changed: Callable[[ProcessState], None],
    ) -> None:
        self._logs = logs
        self._clock = clock
        self._tell = tell
        self._changed = changed
        self._group = asyncio.TaskGroup()
        self._tasks: dict[asyncio.Task[None], Child] = {}

    async def __aenter__(self) -> Self:
        await self._group.__aenter__()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            await self._end_all()
        finally:  # also when ending was interrupted
            self.kill_all()
            if (
                kind is not asyncio.CancelledError
            ):  # the group would wrap an ordinary error, which belongs to the caller
                kind = error = trace = None
            await self._group.__aexit__(kind, error, trace)

    def start(self, spec: ChildSpec) -> Child:
        """Starts a process and keeps it running until the block is left."""
        child = Child(
            spec,
            CappedLog(self._logs / f"{spec.name}.log"),
            self._clock,
            lambda line: self._tell(spec.name, line),
            self._changed,
        )
        self._tasks[self._group.create_task(child.keep_running(), name=spec.name)] = child
        return child

    def states(self) -> dict[str, ProcessState]:
        """Every child's present state by name, freshly stamped."""
        return {child.spec.name: child.refresh() for child in self._tasks.values()}

    def kill_all(self) -> None:
        """Ends everything at once, without asking."""
        for task, child in self._tasks.items():
            if not task.done():
                child.kill()

    async def _end_all(self) -> None:
        asked_s = self._clock.monotonic_s()
        for ends_last, limit_s in ((False, TERM_S), (True, LAST_TERM_S)):
            running = {t: c for t, c in self._tasks.items() if c.spec.ends_last == ends_last and not t.done()}
            for child in running.values():
                child.terminate()
            await self._wait_for(running, limit_s - (self._clock.monotonic_s() - asked_s))
            for task, child in running.items():
                if not task.done():
                    self._tell(child.spec.name, "did not end when asked; killed")
                    child.kill()
            if running:
                await asyncio.wait(running)

    async def _wait_for(self, tasks: Iterable[asyncio.Task[None]], seconds: float) -> None:
        limit = asyncio.create_task(self._clock.sleep(seconds))
        pending = set(tasks)
        try:
            while pending and not limit.done():
                await asyncio.wait({*pending, limit}, return_when=asyncio.FIRST_COMPLETED)
                pending = {task for task in pending if not task.done()}
        finally:
            limit.cancel()
