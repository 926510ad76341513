"""Set-points that change no faster than the vehicle's limits of acceleration and jerk allow, whatever a controller asks for."""

import math

from agents.motion import Twist, clip
from protocol.lab import Limits

_LONGEST_S = 0.1
"""A round of the control loop that took longer changes the set-point no more than this does."""
_AHEAD_S = 0.5
"""A set-point runs ahead of what the robot does by at most what it gains in this time: something else holds the robot."""
_STANDS = 1e-4
"""m/s or rad/s: as good as nothing."""


class Ramp:
    """One velocity (m/s or rad/s) with limited first and second derivatives.

    Towards a target it gains as much acceleration as can still be taken back before the target is met, so that a target that
    stays is met without overshoot (but for what the last step cannot take back). A change of direction passes through standstill.
    """

    def __init__(self, gaining: float, losing: float, jerk: float) -> None:
        """Limits of the acceleration (per s^2) while the amount grows and while it shrinks, and of the jerk (per s^3)."""
        self.velocity = 0.0
        self.acceleration = 0.0
        self._gaining, self._losing, self._jerk = gaining, losing, jerk

    def restart(self, velocity: float) -> None:
        """Goes on from here without acceleration."""
        self.velocity, self.acceleration = velocity, 0.0

    def hold_near(self, measured: float) -> None:
        """Not further ahead of what is measured than the robot could follow."""
        lead = self._gaining * _AHEAD_S
        held = clip(self.velocity, measured - lead, measured + lead)
        if held != self.velocity and abs(held) < abs(self.velocity):
            self.restart(held)

    def step(self, target: float, step_s: float) -> float:
        """The velocity after `step_s`."""
        if step_s <= 0.0:
            return self.velocity
        if self.velocity * target < 0.0:
            target = 0.0
        missing = target - self.velocity
        loses = abs(target) < abs(self.velocity)
        limit = self._losing if loses else self._gaining
        change = self._jerk * step_s
        # With steps of `change` down to nothing, an acceleration of k changes gains change * step_s * k (k + 1) / 2.
        wanted = 0.5 * change * (math.sqrt(1.0 + 8.0 * abs(missing) / (change * step_s)) - 1.0)
        wanted = math.copysign(min(limit, wanted, abs(missing) / step_s), missing)
        self.acceleration = clip(wanted, self.acceleration - change, self.acceleration + change)
        before, self.velocity = self.velocity, self.velocity + self.acceleration * step_s
        if target == 0.0 and (before * self.velocity < 0.0 or abs(self.velocity) < _STANDS):
            self.restart(0.0)
        return self.velocity


class TwistShaper:
    """Both velocities of one robot's set-points."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._linear = Ramp(limits.acceleration_mps2, limits.braking_mps2, limits.jerk_mps3)
        yaw_acceleration = limits.yaw_acceleration_radps2
        self._angular = Ramp(yaw_acceleration, yaw_acceleration, limits.yaw_jerk_radps3)
        self._at_s: float | None = None

    def restart(self) -> None:
        """The next set-point follows on what the robot then does."""
        self._at_s = None

    def shaped(self, wanted: Twist, measured: Twist, now_s: float) -> Twist:
        """The set-point for this moment; `measured` is what the robot does, `now_s` monotonic seconds."""
        if self._at_s is None:
            self._linear.restart(measured.linear_mps)
            self._angular.restart(measured.angular_radps)
            step_s = _LONGEST_S / 2.0
        else:
            self._linear.hold_near(measured.linear_mps)
            self._angular.hold_near(measured.angular_radps)
            step_s = min(now_s - self._at_s, _LONGEST_S)
        self._at_s = now_s
        wanted = wanted.clipped(self._limits)
        return Twist(
            self._linear.step(wanted.linear_mps, step_s), self._angular.step(wanted.angular_radps, step_s)
        ).clipped(self._limits)
