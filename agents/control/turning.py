"""Turning on the spot to a heading (movement `Rotate`, the heading to end with, and corners that are too sharp to drive). The
report wishes for it and gives no constants; these are ours."""

import math
from dataclasses import dataclass

from agents.control.speed_profile import braking_speed
from agents.motion import STOP, Twist, clip
from geometry import angle_difference
from protocol.lab import Limits


@dataclass(frozen=True, slots=True)
class TurningConstants:
    """The rate falls with the error as far as `braking_share` of the vehicle's yaw acceleration allows, and in proportion to it
    at the very end, by `gain_per_s`; `min_rate_radps` is the least rate that moves a robot, `tolerance_rad` the error at which
    it is done. `looks_s`: for how long the robot then stands before its heading counts, for it may have turned on; 0: it is not
    to stand. `lead_s`: until a set-point is what the wheels do; the robot is taken for where it will then be.

    `swivel_s`: how long a base with a steered wheel needs to turn that wheel across. Meanwhile it is told the least rate
    only, for a wheel that drives while it turns pushes the robot off its place.
    """

    gain_per_s: float = 4.0
    braking_share: float = 0.4
    min_rate_radps: float = 0.05
    tolerance_rad: float = math.radians(1.5)
    looks_s: float = 0.2
    lead_s: float = 0.1
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
        return STOP, True
    braking = constants.braking_share * limits.yaw_acceleration_radps2
    rate = braking_speed(abs(error_rad), braking, constants.gain_per_s)
    rate = clip(rate, constants.min_rate_radps, limits.yaw_rate_radps)
    return Twist(0.0, math.copysign(rate, error_rad)).clipped(limits), False


class Turn:
    """One turn on the spot, from standstill to the heading. The way round is chosen once, so that a turn by half a circle
    does not change its mind."""

    _STANDS_MPS, _STANDS_RADPS = 0.03, 0.05
    _COMMITTED_RAD = 2.5
    _MOST_LOOKS = 4

    def __init__(self, target_rad: float, limits: Limits, constants: TurningConstants) -> None:
        self.target_rad = target_rad
        self._limits = limits
        self._constants = constants
        self._began_s: float | None = None
        self._sign = 0.0
        self._stands_since_s: float | None = None
        self._looks = 0

    def step(self, yaw_rad: float, twist: Twist, now_s: float) -> tuple[Twist, bool]:
        """The twist for this moment, and whether the heading is reached. `twist` is what the robot does."""
        soon_rad = yaw_rad + twist.angular_radps * self._constants.lead_s
        error_rad = angle_difference(self.target_rad, soon_rad)
        if self._began_s is None:
            if abs(twist.linear_mps) > self._STANDS_MPS:
                return STOP, False
            self._began_s, self._sign = now_s, math.copysign(1.0, error_rad)
        wanted, there = turn_to(soon_rad, self.target_rad, self._limits, self._constants)
        if there:
            return wanted, self._stands(twist, now_s)
        if self._stands_since_s is not None:
            self._stands_since_s = None
            self._looks += 1
            if self._looks >= self._MOST_LOOKS:  # as near as it gets: no hunting
                return STOP, True
        rate = abs(wanted.angular_radps)
        if now_s - self._began_s < self._constants.swivel_s:
            rate = min(rate, self._constants.min_rate_radps)
        sign = self._sign if abs(error_rad) > self._COMMITTED_RAD else math.copysign(1.0, error_rad)
        return Twist(0.0, sign * rate), False

    def _stands(self, twist: Twist, now_s: float) -> bool:
        """Whether the robot has stood there for long enough."""
        if self._constants.looks_s == 0.0:
            return True
        if abs(twist.angular_radps) > self._STANDS_RADPS:
            return False
        if self._stands_since_s is None:
            self._stands_since_s = now_s
        return now_s - self._stands_since_s >= self._constants.looks_s
