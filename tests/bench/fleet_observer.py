"""Watches the fleet state from outside while robots report: how old a status is when whoever follows the fleet's state in Redis
has it, and when an operator's console has it."""

from array import array
from collections.abc import Mapping
from contextlib import aclosing
from dataclasses import dataclass, field

from msgspec import Struct
from msgspec.json import Decoder
from websockets.asyncio.client import connect

from protocol.bus import Bus
from protocol.channels import STATUSES
from protocol.clock import Clock


class _Said(Struct):
    sequence: int
    stamp_ns: int


class _ShownStatus(Struct):
    stamp_ns: int


class _ShownRobot(Struct):
    status: _ShownStatus | None = None


class _Shown(Struct):
    robots: dict[str, _ShownRobot | None] = {}


_SAID, _SHOWN = Decoder(_Said), Decoder(_Shown)


@dataclass(slots=True)
class Ages:
    """Of statuses on arrival (ms), each once; `newest` by robot tells those that were there before."""

    ms: "array[float]" = field(default_factory=lambda: array("d"))
    newest: dict[str, int] = field(default_factory=dict[str, int])
    seen: int = 0

    def add(self, robot: str, number: int, stamp_ns: int, now_ns: int) -> None:
        """A robot's newest status, if `number` is greater than any before."""
        if number > self.newest.get(robot, -1):
            self.newest[robot] = number
            self.seen += 1
            self.ms.append((now_ns - stamp_ns) / 1e6)


async def follow_fleet(redis_url: str, ages: Ages, clock: Clock) -> None:
    """Of all statuses that get into the fleet state; until cancelled."""
    bus = Bus.connect(redis_url, clock)
    try:
        async with aclosing(bus.subscribe_raw(STATUSES)) as said:
            async for together in said:
                now_ns = clock.now_ns()
                for robot, data in together.messages.items():
                    status = _SAID.decode(data)
                    ages.add(robot, status.sequence, status.stamp_ns, now_ns)
    finally:
        await bus.close()


async def follow_console(url: str, token: str, ages: Ages, clock: Clock) -> None:
    """Of the statuses that a console is told of: the newest, twenty times a second at most; until cancelled."""
    address = f"{url.replace('http', 'ws', 1)}/api/live"
    headers = {"Authorization": f"Bearer {token}"}
    async with connect(address, additional_headers=headers, max_size=None, compression=None, proxy=None) as socket:
        async for message in socket:
            now_ns = clock.now_ns()
            for robot, stamp_ns in _stamps(message).items():
                ages.add(robot, stamp_ns, stamp_ns, now_ns)


def _stamps(message: str | bytes) -> Mapping[str, int]:
    robots = _SHOWN.decode(message).robots
    return {
        name: robot.status.stamp_ns for name, robot in robots.items() if robot is not None and robot.status is not None
    }
