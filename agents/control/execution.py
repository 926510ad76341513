"""Carries out one command after the other: the movement's twist for this moment, and when its target is reached."""

import math
from dataclasses import dataclass

from agents.control.controller import Goal, PathController
from agents.control.shaping import TwistShaper
from agents.control.turning import Turn, TurningConstants
from agents.motion import STOP, Twist
from geometry import SE2, angle_difference
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

    A final target counts as reached once the controller says that it can gain no more, or the robot is within its
    tolerance *and* is not getting nearer any more: it rolls on to 0.10 m, or until it moves away or 2 s have passed. So it
    stands well inside 0.15 m instead of on the rim, where the next pose might put it outside again. Then it turns to the
    target's yaw, if any, and holds still; only being pushed more than 0.30 m away makes it start again.

    Movements keep the vehicle's limits of acceleration and jerk. To hold still is to brake at once, whatever the jerk; a
    twist from a hand is passed on as it is, for the hand to feel what it does.
    """

    def __init__(self, controller: PathController, limits: Limits, turning: TurningConstants | None = None) -> None:
        self._controller = controller
        self._limits = limits
        self._turning = turning or TurningConstants()
        self._shaper = TwistShaper(limits)
        self._task: tuple[Movement, bool, Target | None] | None = None
        self._turn: Turn | None = None
        self._inside_since_s: float | None = None
        self._nearest_m = math.inf
        self._arrived = False
        self._reached = False

    def reset(self) -> None:
        """The robot does not obey at the moment; it will start the task afresh."""
        self._task = None
        self._shaper.restart()

    def execute(self, command: Command, pose: SE2, twist: Twist, now_s: float) -> Execution:
        """`pose` is T_map_robot, `twist` what the robot does, `now_s` monotonic seconds."""
        task = task_of(command)
        if task != self._task:
            # A carrot that becomes a place to arrive at is still the same journey.
            self._begin(task, afresh=self._task is None or self._task[0] is not task[0])
        target = command.target
        match command.movement:
            case Movement.DRIVE:
                self._shaper.restart()
                return Execution(Twist(command.linear_mps, command.angular_radps).clipped(self._limits), False)
            case Movement.ROTATE if target is not None and target.yaw is not None:
                return self._shaped(self._rotate(pose, twist, target.yaw, now_s), twist, now_s)
            case Movement.MOVE_TO if target is not None:
                return self._shaped(self._move(command, target, pose, twist, now_s), twist, now_s)
            case _:
                self._shaper.restart()
                return Execution(STOP, False)

    def _begin(self, task: tuple[Movement, bool, Target | None], *, afresh: bool) -> None:
        if afresh:
            self._controller.reset()
        self._task = task
        self._turn = None
        self._inside_since_s, self._nearest_m = None, math.inf
        self._arrived, self._reached = False, False

    def _shaped(self, execution: Execution, twist: Twist, now_s: float) -> Execution:
        if execution.reached:
            self._shaper.restart()
            return execution
        return Execution(self._shaper.shaped(execution.twist, twist, now_s), False)

    def _move(self, command: Command, target: Target, pose: SE2, twist: Twist, now_s: float) -> Execution:
        speed_mps = min(command.speed_mps, self._limits.speed_mps)
        goal = Goal(target.x, target.y, speed_mps, command.final, command.path)
        if self._arrived and math.hypot(target.x - pose.x, target.y - pose.y) > _PUSHED_AWAY_M:
            self._begin(task_of(command), afresh=True)
        if not self._arrived:
            steering = self._controller.steer(pose, twist, goal, now_s)
            there = steering.reached and (steering.rests or self._settled(steering.distance_m, now_s))
            if not (command.final and there):
                return Execution(steering.twist, False)
            self._arrived = True
        return Execution(STOP, True) if target.yaw is None else self._rotate(pose, twist, target.yaw, now_s)

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

    def _rotate(self, pose: SE2, twist: Twist, yaw_rad: float, now_s: float) -> Execution:
        if self._reached:
            return Execution(STOP, True)
        if self._turn is None or abs(angle_difference(self._turn.target_rad, yaw_rad)) > 1e-9:
            self._turn = Turn(yaw_rad, self._limits, self._turning)
        wanted, self._reached = self._turn.step(pose.yaw, twist, now_s)
        return Execution(wanted, self._reached)
