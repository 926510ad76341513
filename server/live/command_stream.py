"""The stream of server-sent events to one robot (spec gpss): the emergency stop first, then commands.

Nothing is sent of commands before the state of the latch is known. While Redis is out of reach the stream stays open with
its comments: the robot hears no fresh command and stops by itself.
"""

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable

from protocol.clock import Clock
from protocol.codec import encode
from protocol.messages import Command, EmergencyStop
from server.live.feeds import CommandFeeds

KEEP_ALIVE_S = 0.5
_KEEP_ALIVE = b": keep-alive\n\n"
_CHECK_EVERY_S = 10.0


async def command_stream(
    feeds: CommandFeeds, robot: str, clock: Clock, may_listen: Callable[[], Awaitable[bool]]
) -> AsyncGenerator[bytes, None]:
    """The stream's bytes until the service ends or `may_listen`, asked now and then, says no."""
    told = False
    checked_s = clock.monotonic_s()
    with feeds.open(robot) as feed:
        while not feeds.closed:
            if clock.monotonic_s() - checked_s > _CHECK_EVERY_S:
                checked_s = clock.monotonic_s()
                if not await may_listen():
                    return
            try:
                async with asyncio.timeout(KEEP_ALIVE_S):
                    await feed.woken.wait()
            except TimeoutError:
                yield _KEEP_ALIVE
                continue
            feed.woken.clear()
            stop, feed.emergency_stop = feed.emergency_stop, None
            if stop is not None:
                told = True
                yield _event("emergency_stop", stop)
            if told and feed.command is not None:
                command, feed.command = feed.command, None
                yield _event("command", command)


def _event(name: str, message: Command | EmergencyStop) -> bytes:
    return b"event: " + name.encode() + b"\ndata: " + encode(message) + b"\n\n"
