"""The stream of server-sent events to one robot (spec gpss): the emergency stop first, then commands.

Nothing is sent of commands before the state of the latch is known. While Redis is out of reach the stream stays open with
its comments: the robot hears no fresh command and stops by itself.
"""

import asyncio
import random
from collections.abc import AsyncGenerator, Awaitable, Callable
from typing import Self

from protocol.clock import Clock
from protocol.codec import encode
from server.direct_writes import Write
from server.live.feeds import CommandFeeds, command_event

KEEP_ALIVE_S = 0.5
_KEEP_ALIVE = b": keep-alive\n\n"
_CHECK_EVERY_S = 10.0


async def command_stream(
    feeds: CommandFeeds,
    robot: str,
    clock: Clock,
    may_listen: Callable[[], Awaitable[bool]],
    write: Write | None = None,
) -> AsyncGenerator[bytes, None]:
    """The stream's bytes until the service ends or `may_listen`, asked now and then, says no. Commands go by the short way
    `write`, if there is one, whenever all that was yielded has been sent."""
    told = False
    # Streams that were opened together, as after a restart of the server, are not checked together.
    checked_s = clock.monotonic_s() - random.uniform(0.0, 0.5) * _CHECK_EVERY_S

    def due() -> bool:
        return clock.monotonic_s() - checked_s > _CHECK_EVERY_S

    with feeds.open(robot) as feed, _Silence(KEEP_ALIVE_S, feed.woken, due) as silence:
        if write is not None:
            feed.write = silence.broken_by(write)
        while not feeds.closed:
            if due():
                checked_s = clock.monotonic_s()
                if not await may_listen():
                    return
            feed.idle = told
            await feed.woken.wait()
            feed.idle = False
            feed.woken.clear()
            stop, feed.emergency_stop = feed.emergency_stop, None
            if stop is not None:
                told = True
                silence.broken()
                yield b"event: emergency_stop\ndata: %b\n\n" % encode(stop)
            if told and feed.command is not None:
                command, feed.command = feed.command, None
                silence.broken()
                yield command_event(command)
            if silence.lasts:
                silence.broken()
                yield _KEEP_ALIVE


class _Silence:
    """Wakes a stream that has been silent for as long as it may, or when something else is `due`; for every event no more is done
    than to note the time."""

    def __init__(self, limit_s: float, woken: asyncio.Event, due: Callable[[], bool]) -> None:
        self._limit_s, self._woken, self._due, self._loop = limit_s, woken, due, asyncio.get_running_loop()
        self.broken()
        self._timer = self._loop.call_later(limit_s, self._look)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._timer.cancel()

    @property
    def lasts(self) -> bool:
        """Whether it is long enough that something has to be said."""
        return self._loop.time() - self._since_s >= self._limit_s

    def broken(self) -> None:
        """Something is said now."""
        self._since_s = self._loop.time()

    def broken_by(self, write: Write) -> Write:
        """The same way to write, noting that something is said."""

        def noted(piece: bytes) -> bool:
            taken = write(piece)
            if taken:
                self.broken()
            return taken

        return noted

    def _look(self) -> None:
        if self.lasts:
            self._woken.set()
            again_s = self._limit_s
        else:
            if self._due():
                self._woken.set()
            again_s = self._since_s + self._limit_s - self._loop.time()
        self._timer = self._loop.call_later(again_s, self._look)
