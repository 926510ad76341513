"""The WifiBots' controller under the name `go_to_goal` (spec manoeuvres, "Driving"): the route's points one after the other at
the set speed, each accepted within 0.2 m. How it steers towards a point is not published; a gain on the heading error is ours.
"""

import math
from dataclasses import dataclass

from agents.control.controller import Goal, Point, Steering
from agents.motion import STOP, Twist, clip
from geometry import SE2, angle_difference
from protocol.lab import Limits

_SAME_POINT_M = 0.01
_RECENT_POINTS = 3


@dataclass(frozen=True, slots=True)
class GoToGoalConfig:
    """A point counts as reached within `accept_m`. The yaw rate is `gain_per_s` times the heading error; with an error above
    `turn_above_rad` the robot turns on the spot."""

    accept_m: float = 0.2
    gain_per_s: float = 1.0
    turn_above_rad: float = math.radians(65.0)


class GoToGoalController:
    """Aims at the first point of the path that is still ahead; without a path, at the goal."""

    def __init__(self, limits: Limits, config: GoToGoalConfig | None = None) -> None:
        self._limits = limits
        self._config = config or GoToGoalConfig()
        self._accepted: Point | None = None

    def reset(self) -> None:
        self._accepted = None

    def steer(self, pose: SE2, twist: Twist, goal: Goal, now_s: float) -> Steering:  # noqa: ARG002  # a law of the pose alone
        distance_m = math.hypot(goal.x - pose.x, goal.y - pose.y)
        x, y = self._aim(pose, goal)
        error_rad = angle_difference(math.atan2(y - pose.y, x - pose.x), pose.yaw)
        reached = distance_m <= self._config.accept_m
        if reached:
            return Steering(STOP, distance_m, error_rad, True, rests=True)
        rate = clip(self._config.gain_per_s * error_rad, -self._limits.yaw_rate_radps, self._limits.yaw_rate_radps)
        turns = abs(error_rad) > self._config.turn_above_rad
        wanted = Twist(0.0 if turns else goal.speed_mps, rate)
        return Steering(wanted.clipped(self._limits), distance_m, error_rad, False)

    def _aim(self, pose: SE2, goal: Goal) -> Point:
        """Remembers the last point that was accepted, so that none is gone back to."""
        points = goal.path[1:]
        ahead = 0
        if self._accepted is not None:
            for index, point in enumerate(points[:_RECENT_POINTS]):
                if math.dist(point, self._accepted) < _SAME_POINT_M:
                    ahead = index + 1
        while ahead < len(points) and math.dist(points[ahead], (pose.x, pose.y)) <= self._config.accept_m:
            self._accepted = points[ahead]
            ahead += 1
        return points[ahead] if ahead < len(points) else (goal.x, goal.y)
