"""Turning on the spot to a heading (movement `Rotate`, the heading to end with, and corners that are too sharp to drive). The
report wishes for it and gives no constants; these are ours."""

import math
from dataclasses import dataclass

from agents.motion import STOP, Twist, clip
from geometry import angle_difference
from protocol.lab import Limits


@dataclass(frozen=True, slots=True)
class TurningConstants:
    """P gain (rad/s per rad), the least rate that moves a robot (rad/s), and the error (rad) at which it is done.

    With a gain of 2 / s the rate falls by at most 2 rad/s^2 at 1 rad/s, less than what any of the bases can brake.

    `swivel_s`: how long a base with a steered wheel needs to turn that wheel across. Meanwhile it is told the least rate
    only, for a wheel that drives while it turns pushes the robot off its place.
    """

    gain_per_s: float = 2.0
    min_rate_radps: float = 0.05
    tolerance_rad: float = math.radians(1.5)
    swivel_s: float = 0.0


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


class Turn:
    """One turn on the spot, from standstill to the heading. The way round is chosen once, so that a turn by half a circle
    does not change its mind."""

    _STANDS_MPS = 0.03
    _COMMITTED_RAD = 2.5

    def __init__(self, target_rad: float, limits: Limits, constants: TurningConstants) -> None:
        self.target_rad = target_rad
        self._limits = limits
        self._constants = constants
        self._began_s: float | None = None
        self._sign = 0.0

    def step(self, yaw_rad: float, twist: Twist, now_s: float) -> tuple[Twist, bool]:
        """The twist for this moment, and whether the heading is reached. `twist` is what the robot does."""
        error_rad = angle_difference(self.target_rad, yaw_rad)
        if self._began_s is None:
            if abs(twist.linear_mps) > self._STANDS_MPS:
                return STOP, False
            self._began_s, self._sign = now_s, math.copysign(1.0, error_rad)
        wanted, reached = turn_to(yaw_rad, self.target_rad, self._limits, self._constants)
        if reached:
            return wanted, True
        rate = abs(wanted.angular_radps)
        if now_s - self._began_s < self._constants.swivel_s:
            rate = min(rate, self._constants.min_rate_radps)
        sign = self._sign if abs(error_rad) > self._COMMITTED_RAD else math.copysign(1.0, error_rad)
        return Twist(0.0, sign * rate), False
