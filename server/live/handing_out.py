"""Hands commands to robots' streams as fast as this process can: where it cannot keep up, each robot misses what is old and gets
what is newest."""

import asyncio
from collections.abc import Mapping
from itertools import islice

from protocol.clock import Clock
from server.live.feeds import CommandFeeds

_AT_ONCE = 100
"""So many go out before others on the loop have their turn, among them who reads newer commands."""


class HandingOut:
    """Commands by robot between the bus and the streams; `run` must be running."""

    def __init__(self, feeds: CommandFeeds, clock: Clock) -> None:
        self._feeds, self._clock = feeds, clock
        self._waiting: dict[str, bytes] = {}
        self._filled = asyncio.Event()

    def take(self, commands: Mapping[str, bytes]) -> None:
        """Each takes the place of one for its robot that has not gone out yet, also in the order of going out."""
        self._waiting.update(commands)
        self._filled.set()

    async def run(self) -> None:
        """Until cancelled."""
        while True:
            await self._filled.wait()
            for robot in list(islice(self._waiting, _AT_ONCE)):
                self._feeds.command(robot, self._waiting.pop(robot))
            if not self._waiting:
                self._filled.clear()
            await self._clock.sleep(0.0)
