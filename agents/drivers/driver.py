"""What the agent knows of a robot's base: the interface that every driver implements, and its errors.

A driver is one module with one config class and one line in `agents.drivers.registry`; the conformance suite in
tests/agents runs over every implementation. The base itself must stop when it hears no set-point for a while (0.3 s in the
simulated one): nothing on the robot's computer can stop wheels after that computer has hung.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from agents.motion import Twist
from agents.protection import RangeScan
from geometry import SE2


class DriverError(Exception):
    """Base of all errors of drivers; the text says what to look at."""


class DriverNotConnectedError(DriverError):
    """The base is out of reach, or `connect` was not called."""


class OdometryStaleError(DriverError):
    """The base has said nothing for longer than the caller accepts."""


class UnknownDriverError(DriverError):
    """The lab description names a driver that does not exist."""


@dataclass(frozen=True, slots=True)
class OdometryReading:
    """What the wheels say at `stamp_ns`.

    `pose` is T_odom_robot: the rotation centre in a frame that lies where the base was started, with all the drift of the
    wheels. A new `session` means that the base restarted and that the frame is another one. `front_range_m` is the
    distance to what is ahead (None: nothing near, or no sensor).
    """

    stamp_ns: int
    session: str
    pose: SE2
    twist: Twist
    front_range_m: float | None = None


class Driver(Protocol):
    """A base that takes twists and reports odometry. `send_twist`, `read_odometry` and the rest never wait."""

    @property
    def connected(self) -> bool:
        """Whether `connect` succeeded and nothing has broken since."""
        ...

    async def connect(self) -> None:
        """Opens the way to the base; does nothing when open. DriverNotConnectedError when that fails (try again later)."""
        ...

    async def close(self) -> None:
        """Commands zero, then lets go of the base; does nothing when closed."""
        ...

    def send_twist(self, twist: Twist) -> Twist:
        """Hands the set-point to the base and returns what was really sent, after clipping to the vehicle's limits.
        DriverNotConnectedError when it cannot be sent."""
        ...

    def read_odometry(self, max_age_s: float) -> OdometryReading:
        """The newest odometry. OdometryStaleError when it is older than `max_age_s` or there was none,
        DriverNotConnectedError before `connect`."""
        ...

    def watch_scans(self, heard: Callable[[RangeScan], None]) -> None:
        """Has `heard` told of every turn of the base's safety scanner, as soon as it is here, at the latest in `read_odometry`.
        Bases without a scanner never call it; those with one that has fallen silent say so among their faults."""
        ...

    def battery(self) -> float | None:
        """Share of a full charge, 0..1; None while unknown."""
        ...

    def faults(self) -> tuple[str, ...]:
        """What keeps the base from driving, in sentences; the robot stands still while there is any."""
        ...
