"""A driver in memory over a Plant, with knobs for what can break."""

from collections.abc import Callable

from agents.drivers import DriverNotConnectedError, OdometryReading, OdometryStaleError
from agents.motion import STOP, Twist
from agents.protection import RangeScan
from protocol.clock import Clock
from protocol.lab import Limits
from tests.agents.plant import Plant


class MemoryDriver:
    """`fault`, `unreachable` and `silent` are the knobs; `base_speaks` makes new odometry."""

    def __init__(self, clock: Clock, plant: Plant, limits: Limits) -> None:
        self.plant = plant
        self.fault: str | None = None
        self.unreachable = False
        self.silent = False
        self._clock = clock
        self._limits = limits
        self._open = False
        self._newest: tuple[OdometryReading, float] | None = None
        self.scanned: Callable[[RangeScan], None] | None = None

    @property
    def connected(self) -> bool:
        return self._open and not self.unreachable

    async def connect(self) -> None:
        if self.unreachable:
            raise DriverNotConnectedError("the cable is out")
        if not self._open:
            self._open, self._newest = True, None

    async def close(self) -> None:
        if self.connected:
            self.plant.setpoint = STOP
        self._open = False

    def send_twist(self, twist: Twist) -> Twist:
        if not self.connected:
            raise DriverNotConnectedError("the cable is out")
        self.plant.setpoint = twist.clipped(self._limits)
        return self.plant.setpoint

    def read_odometry(self, max_age_s: float) -> OdometryReading:
        if not self.connected:
            raise DriverNotConnectedError("the cable is out")
        if self._newest is None or self._clock.monotonic_s() - self._newest[1] > max_age_s:
            raise OdometryStaleError("the base is silent")
        return self._newest[0]

    def watch_scans(self, heard: Callable[[RangeScan], None]) -> None:
        self.scanned = heard

    def battery(self) -> float | None:
        return 0.5 if self._newest else None

    def faults(self) -> tuple[str, ...]:
        return () if self.fault is None else (self.fault,)

    def base_speaks(self) -> None:
        if not self.silent:
            self._newest = self.plant.reading(self._clock.now_ns()), self._clock.monotonic_s()
