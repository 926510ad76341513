"""The report's P controller under the name `gpss` (spec gpss, "The robot's side"; GPSS report 3.1.2.3, 3.1.3.4, 4.1, 4.2).

`gpss_law` is the report's law with the report's constants. `GpssController` adds one thing that the report lacks: a goal
that was driven past is turned to and approached again. Inside the distance where the heading error is locked the law alone
never steers, so a robot that passes its goal too far to the side would circle around it for ever.
"""

import math
from dataclasses import dataclass

from agents.control.controller import Goal, Steering
from agents.motion import Twist, clip
from geometry import SE2, angle_difference
from protocol.lab import Limits


@dataclass(frozen=True, slots=True)
class GpssConstants:
    """The report's constants. `gain` is in rad/s per degree of heading error, as published."""

    turn_above_rad: float = math.radians(65.0)
    gain_radps_per_deg: float = 0.0095
    min_rate_radps: float = 0.01
    max_rate_radps: float = 1.0
    reached_m: float = 0.15
    lock_m: float = 0.35


@dataclass(frozen=True, slots=True)
class GpssConfig:
    """The report's constants, and ours for a second approach: a goal counts as passed when it is `passed_m` farther away
    than it was; the robot then turns towards it on the spot to within `face_rad` and drives without the lock."""

    law: GpssConstants = GpssConstants()
    passed_m: float = 0.03
    face_rad: float = math.radians(5.0)


def gpss_law(pose: SE2, goal: Goal, constants: GpssConstants = GpssConstants()) -> Steering:
    """The report's law.

    The heading error is that of the direction to the goal (`atan2` of the difference), counter-clockwise. Up to 65 degrees
    the robot drives and turns, above it turns on the spot at the maximum rate. The angular rate is gain times error
    (report, eq. 7 with the tuned gain), its amount clipped to 0.01 .. 1.0 rad/s; inside 0.35 m of the goal the error is
    locked to 0 and the robot drives straight on. The speed is the commanded one times the distance in metres, clipped to
    0 .. commanded (eq. 8).

    The report's carrots lay a metre or more ahead, where eq. 8 yields the commanded speed. Ours may be nearer, and how near
    is the guidance's choice and no reason to be slow: so for a goal that is not final the speed is the commanded one.
    Within 0.15 m the goal is reached, final or not; the twist goes on towards a final one (whoever executes the command
    decides when to stand), and is zero at a carrot that does not move on.
    """
    dx, dy = goal.x - pose.x, goal.y - pose.y
    distance_m = math.hypot(dx, dy)
    error_rad = angle_difference(math.atan2(dy, dx), pose.yaw)
    reached = distance_m <= constants.reached_m
    locked = distance_m <= constants.lock_m
    if reached and not goal.final:
        twist = Twist(0.0, 0.0)
    elif locked:
        twist = Twist(_speed(goal, distance_m), 0.0)
    elif abs(error_rad) > constants.turn_above_rad:
        twist = Twist(0.0, math.copysign(constants.max_rate_radps, error_rad))
    else:
        twist = Twist(_speed(goal, distance_m), _rate(error_rad, constants))
    return Steering(twist, distance_m, error_rad, reached)


def _speed(goal: Goal, distance_m: float) -> float:
    """m/s; eq. 8 for a final goal."""
    factor = distance_m / 1.0 if goal.final else 1.0  # per metre
    return clip(goal.speed_mps * factor, 0.0, goal.speed_mps)


def _rate(error_rad: float, constants: GpssConstants) -> float:
    """rad/s; zero for no error at all."""
    if error_rad == 0.0:
        return 0.0
    amount = constants.gain_radps_per_deg * math.degrees(abs(error_rad))
    return math.copysign(clip(amount, constants.min_rate_radps, constants.max_rate_radps), error_rad)


class GpssController:
    """`gpss_law`, with a second approach to a goal that was passed."""

    def __init__(self, limits: Limits, config: GpssConfig | None = None) -> None:
        self._limits = limits
        self._config = config or GpssConfig()
        self._goal: Goal | None = None
        self._nearest_m = math.inf
        self._again = False
        self._facing = False

    def reset(self) -> None:
        self._goal, self._nearest_m, self._again, self._facing = None, math.inf, False, False

    def steer(self, pose: SE2, twist: Twist, goal: Goal, now_s: float) -> Steering:  # noqa: ARG002  # a law of the pose alone
        if self._goal is None or (goal.x, goal.y) != (self._goal.x, self._goal.y):
            self.reset()
        self._goal = goal
        steering = gpss_law(pose, goal, self._config.law)
        self._nearest_m = min(self._nearest_m, steering.distance_m)
        if not steering.reached and steering.distance_m > self._nearest_m + self._config.passed_m:
            self._again = True
        if self._again and not (steering.reached and not goal.final):
            steering = self._approach_again(steering, goal)
        return Steering(
            steering.twist.clipped(self._limits), steering.distance_m, steering.heading_error_rad, steering.reached
        )

    def _approach_again(self, steering: Steering, goal: Goal) -> Steering:
        error_rad, law = steering.heading_error_rad, self._config.law
        limit_rad = law.turn_above_rad if self._facing else self._config.face_rad
        self._facing = abs(error_rad) <= limit_rad
        if self._facing:
            twist = Twist(_speed(goal, steering.distance_m), _rate(error_rad, law))
        else:
            twist = Twist(0.0, math.copysign(max(law.min_rate_radps, 2.0 * min(0.5, abs(error_rad))), error_rad))
        return Steering(twist, steering.distance_m, error_rad, steering.reached)
