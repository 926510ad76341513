"""The reports' rectangle (GulliView 2025, 4.2): from corner to corner in straight lines, a halt at each one. The driver steers
by the ground truth, so that localization alone is judged."""

import math
from dataclasses import dataclass

from geometry import SE2, angle_difference
from lab.world import World

LENGTH_M, WIDTH_M = 6.0, 2.5
SEGMENTS_M = (LENGTH_M, WIDTH_M, LENGTH_M, WIDTH_M)

_HALT_S = 1.0
_ARRIVED_M = 0.01
_TURN_GAIN = 3.0
_HEADING_GAIN = 3.0
_SLOWEST_MPS = 0.03
_TURN_IN_PLACE_RAD = 0.3
"""Off its course by more than this the vehicle turns before it drives on."""


def corners(start: SE2) -> list[tuple[float, float]]:
    """Of the rectangle, driven counter-clockwise from `start`, which comes again at the end: five points (m)."""
    x, y = start.x, start.y
    return [(x, y), (x + LENGTH_M, y), (x + LENGTH_M, y + WIDTH_M), (x, y + WIDTH_M), (x, y)]


@dataclass(slots=True)
class CornerDriver:
    """Drives one vehicle around; `halt` is the number of the corner that it stands at, for `halted_s` so far; None on its way."""

    world: World
    vehicle: str
    points: list[tuple[float, float]]
    halt: int | None = None
    halted_s: float = 0.0
    _target: int = 0

    @property
    def is_done(self) -> bool:
        """Whether the last halt is over."""
        return self._target >= len(self.points)

    def steer(self) -> None:
        """Sets the drive for the next step of the world."""
        if self.is_done:
            self.world.set_drive(self.vehicle, 0.0, 0.0)
            return
        pose = self.world.truth().vehicles[self.vehicle]
        x, y = self.points[self._target]
        distance = math.hypot(x - pose.x, y - pose.y)
        if self.halt is not None or distance < _ARRIVED_M:
            self._stand()
            return
        off = angle_difference(math.atan2(y - pose.y, x - pose.x), pose.yaw)
        limits = self.world.lab.vehicle(self.vehicle).limits
        turn = max(-limits.yaw_rate_radps, min(limits.yaw_rate_radps, _TURN_GAIN * off))
        if abs(off) > _TURN_IN_PLACE_RAD:
            self.world.set_drive(self.vehicle, 0.0, turn)
            return
        braking = math.sqrt(limits.acceleration_mps2 * distance)
        speed = max(_SLOWEST_MPS, min(0.9 * limits.speed_mps, braking))
        self.world.set_drive(self.vehicle, speed, _HEADING_GAIN * off if distance > 5 * _ARRIVED_M else 0.0)

    def _stand(self) -> None:
        self.world.set_drive(self.vehicle, 0.0, 0.0)
        still = abs(self.world.truth().vehicles[self.vehicle].linear_mps) < 1e-3
        if still:
            self.halt = self._target
            self.halted_s += self.world.step_s
        if self.halted_s >= _HALT_S:
            self.halt, self.halted_s = None, 0.0
            self._target += 1
