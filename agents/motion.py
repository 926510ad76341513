"""The twist of a robot in the plane: what controllers ask for, drivers apply and odometry reports."""

import math
from dataclasses import dataclass

from protocol.lab import Limits


@dataclass(frozen=True, slots=True)
class Twist:
    """Velocities of the rotation centre in the robot's own frame: forward (m/s) and counter-clockwise (rad/s).

    ValueError unless both are finite: a number that is none must never reach a motor.
    """

    linear_mps: float
    angular_radps: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.linear_mps) and math.isfinite(self.angular_radps)):
            raise ValueError(f"a twist must be finite, got ({self.linear_mps}, {self.angular_radps})")

    def clipped(self, limits: Limits) -> "Twist":
        """The nearest twist that the vehicle can do: each part is clipped on its own, as in the report."""
        return Twist(
            clip(self.linear_mps, -limits.speed_mps, limits.speed_mps),
            clip(self.angular_radps, -limits.yaw_rate_radps, limits.yaw_rate_radps),
        )


STOP = Twist(0.0, 0.0)
"""The set-point that brakes and then holds still."""


def clip(value: float, low: float, high: float) -> float:
    """`value`, or the bound that it lies beyond."""
    return min(high, max(low, value))
