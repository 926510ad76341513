"""Turning on the spot to a heading (movement `Rotate`, and the heading to end with). The report wishes for it and gives no
constants; these are ours."""

import math
from dataclasses import dataclass

from agents.motion import Twist, clip
from geometry import angle_difference
from protocol.lab import Limits


@dataclass(frozen=True, slots=True)
class TurningConstants:
    """P gain (rad/s per rad), the least rate that moves a robot (rad/s), and the error (rad) at which it is done.

    With a gain of 2 / s the rate falls by at most 2 rad/s^2 at 1 rad/s, less than what any of the bases can brake.
    """

    gain_per_s: float = 2.0
    min_rate_radps: float = 0.05
    tolerance_rad: float = math.radians(1.5)


def turn_to(
    yaw_rad: float,
    target_rad: float,
    limits: Limits,
    constants: TurningConstants = TurningConstants(),
) -> tuple[Twist, bool]:
    """The twist that turns the shorter way from `yaw_rad` to `target_rad`, and whether the heading is reached (then the
    twist is zero)."""
    error_rad = angle_difference(target_rad, yaw_rad)
    if abs(error_rad) <= constants.tolerance_rad:
        return Twist(0.0, 0.0), True
    rate = clip(constants.gain_per_s * abs(error_rad), constants.min_rate_radps, limits.yaw_rate_radps)
    return Twist(0.0, math.copysign(rate, error_rad)).clipped(limits), False
