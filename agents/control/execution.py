"""Carries out one command after the other: the movement's twist for this moment, and when its target is reached."""

import math
from dataclasses import dataclass

from agents.control.controller import Goal, PathController
from agents.control.turning import turn_to
from agents.motion import STOP, Twist
from geometry import SE2
from protocol.lab import Limits
from protocol.messages import Command, Movement, Target

_SETTLED_M = 0.10
_RECEDING_M = 0.01
_SETTLING_S = 2.0
_PUSHED_AWAY_M = 0.30


@dataclass(frozen=True, slots=True)
class Execution:
    """The twist to hold and whether the command's target is reached (only a final MoveTo or a Rotate has one to reach)."""

    twist: Twist
    reached: bool


def task_of(command: Command) -> tuple[Movement, bool, Target | None]:
    """What the robot is to achieve; commands of the same task are rewritings of one another. A carrot's place is not part
    of it: it moves with every command."""
    fixed = command.movement is Movement.ROTATE or (command.movement is Movement.MOVE_TO and command.final)
    return command.movement, command.final, command.target if fixed else None


class Executor:
    """Remembers how far the present task is.

    A final target counts as reached once the robot is within the controller's tolerance *and* is not getting nearer any
    more: it rolls on to 0.10 m, or until it moves away or 2 s have passed. So it stands well inside 0.15 m instead of on the
    rim, where the next pose might put it outside again. Then it turns to the target's yaw, if any, and holds still; only
    being pushed more than 0.30 m away makes it start again.
    """

    def __init__(self, controller: PathController, limits: Limits) -> None:
        self._controller = controller
        self._limits = limits
        self._task: tuple[Movement, bool, Target | None] | None = None
        self._inside_since_s: float | None = None
        self._nearest_m = math.inf
        self._arrived = False
        self._reached = False

    def reset(self) -> None:
        """The robot does not obey at the moment; it will start the task afresh."""
        self._task = None

    def execute(self, command: Command, pose: SE2, twist: Twist, now_s: float) -> Execution:
        """`pose` is T_map_robot, `twist` what the robot does, `now_s` monotonic seconds."""
        task = task_of(command)
        if task != self._task:
            self._begin(task)
        target = command.target
        match command.movement:
            case Movement.DRIVE:
                return Execution(Twist(command.linear_mps, command.angular_radps).clipped(self._limits), False)
            case Movement.ROTATE if target is not None and target.yaw is not None:
                return self._turn(pose, target.yaw)
            case Movement.MOVE_TO if target is not None:
                return self._move(command, target, pose, twist, now_s)
            case _:
                return Execution(STOP, False)

    def _begin(self, task: tuple[Movement, bool, Target | None]) -> None:
        self._controller.reset()
        self._task = task
        self._inside_since_s, self._nearest_m = None, math.inf
        self._arrived, self._reached = False, False

    def _move(self, command: Command, target: Target, pose: SE2, twist: Twist, now_s: float) -> Execution:
        goal = Goal(target.x, target.y, min(command.speed_mps, self._limits.speed_mps), command.final)
        if self._arrived and math.hypot(target.x - pose.x, target.y - pose.y) > _PUSHED_AWAY_M:
            self._begin(task_of(command))
        if not self._arrived:
            steering = self._controller.steer(pose, twist, goal)
            if not (command.final and steering.reached and self._settled(steering.distance_m, now_s)):
                return Execution(steering.twist, False)
            self._arrived = True
        return Execution(STOP, True) if target.yaw is None else self._turn(pose, target.yaw)

    def _settled(self, distance_m: float, now_s: float) -> bool:
        """Whether the robot, inside the tolerance, is as near as it is going to get."""
        if self._inside_since_s is None:
            self._inside_since_s = now_s
        self._nearest_m = min(self._nearest_m, distance_m)
        return (
            distance_m <= _SETTLED_M
            or distance_m > self._nearest_m + _RECEDING_M
            or now_s - self._inside_since_s > _SETTLING_S
        )

    def _turn(self, pose: SE2, yaw_rad: float) -> Execution:
        if self._reached:
            return Execution(STOP, True)
        twist, self._reached = turn_to(pose.yaw, yaw_rad, self._limits)
        return Execution(twist, self._reached)
