"""The last millimetres: a robot that has halted near its goal looks again once it stands, and moves up if it is too far off."""

import math
from dataclasses import dataclass

from agents.control.controller import Point
from agents.control.speed_profile import braking_speed
from agents.control.turning import Turn, TurningConstants
from agents.motion import STOP, Twist
from geometry import SE2
from protocol.lab import Limits

_STANDS_MPS = 0.01
_LOOKS_S = 0.4
"""A robot that stands is seen some times by the cameras before it judges its place."""
_MOST_MOVES = 3
_CREEP_MPS = 0.1
_CREEP_MPS2 = 0.2
_ASIDE_RAD = 0.2
"""The goal further aside than this: the robot turns before it moves up."""
_ARRIVES_M = 0.003


@dataclass(frozen=True, slots=True)
class DockConfig:
    """How near is near enough; the others are those of the controller."""

    tolerance_m: float
    approach_per_s: float
    lead_s: float


class Dock:
    """Stands, looks, moves up. After a few moves it is content with what it has: no hunting."""

    def __init__(self, goal: Point, limits: Limits, config: DockConfig, turning: TurningConstants) -> None:
        self._goal = goal
        self._limits = limits
        self._config = config
        self._turning = turning
        self._stands_since_s: float | None = None
        self._moves = 0
        self._turn: Turn | None = None
        self._direction = 0.0
        self._content = False

    def step(self, pose: SE2, twist: Twist, now_s: float) -> tuple[Twist, bool]:
        """The twist for this moment, and whether the robot stands for good."""
        if self._content:
            return STOP, True
        if self._turn is not None:
            wanted, done = self._turn.step(pose.yaw, twist, now_s)
            if not done:
                return wanted, False
            self._turn = None
        if self._direction != 0.0:
            return self._creep(pose, twist), False
        return STOP, self._look(pose, twist, now_s)

    def _look(self, pose: SE2, twist: Twist, now_s: float) -> bool:
        if abs(twist.linear_mps) > _STANDS_MPS:
            self._stands_since_s = None
            return False
        self._stands_since_s = now_s if self._stands_since_s is None else self._stands_since_s
        if now_s - self._stands_since_s < _LOOKS_S:
            return False
        ahead, aside = self._seen_from(pose)
        if math.hypot(ahead, aside) <= self._config.tolerance_m or self._moves >= _MOST_MOVES:
            self._content = True
            return True
        self._moves += 1
        self._stands_since_s = None
        self._direction = math.copysign(1.0, ahead)
        line_rad = math.atan2(aside * self._direction, ahead * self._direction)
        if abs(line_rad) > _ASIDE_RAD:
            self._turn = Turn(pose.yaw + line_rad, self._limits, self._turning)
        return False

    def _creep(self, pose: SE2, twist: Twist) -> Twist:
        """Forwards or backwards until the goal is abeam."""
        ahead, _ = self._seen_from(pose)
        left_m = self._direction * (ahead - twist.linear_mps * self._config.lead_s)
        if left_m <= _ARRIVES_M:
            self._direction = 0.0
            return STOP
        speed = min(_CREEP_MPS, braking_speed(left_m, _CREEP_MPS2, self._config.approach_per_s), self._limits.speed_mps)
        return Twist(self._direction * speed, 0.0)

    def _seen_from(self, pose: SE2) -> Point:
        """The goal from the robot: ahead, to the left (m)."""
        dx, dy = self._goal[0] - pose.x, self._goal[1] - pose.y
        return (
            math.cos(pose.yaw) * dx + math.sin(pose.yaw) * dy,
            -math.sin(pose.yaw) * dx + math.cos(pose.yaw) * dy,
        )
