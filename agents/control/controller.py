"""The interface of path controllers, which turn a pose and a goal into a twist; pure, no clock of their own."""

from dataclasses import dataclass
from typing import Protocol

from agents.motion import Twist
from geometry import SE2

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Goal:
    """Where to drive (m, map frame) and the speed set-point on the way there (m/s).

    `final`: the robot is to arrive and stand there. Otherwise the goal is a carrot on the route, which moves on before the
    robot gets to it. `path` is the line to drive on (m, map frame), from a little behind the robot to where it is to be able
    to stop, as in `Command.path`; empty where there is none. Controllers that chase the goal do not look at it.
    """

    x: float
    y: float
    speed_mps: float
    final: bool
    path: tuple[Point, ...] = ()


@dataclass(frozen=True, slots=True)
class Steering:
    """What to drive, with what led to it: the distance to the goal (m), the heading error (rad, counter-clockwise; before
    any locking), and whether the goal counts as reached. `rests`: the robot stands, and nothing more is to be gained."""

    twist: Twist
    distance_m: float
    heading_error_rad: float
    reached: bool
    rests: bool = False


class PathController(Protocol):
    """One controller per robot; it may remember the way towards the goal it has."""

    def reset(self) -> None:
        """Forgets everything: the robot stood still or obeyed something else meanwhile."""
        ...

    def steer(self, pose: SE2, twist: Twist, goal: Goal, now_s: float) -> Steering:
        """The twist for this moment. `pose` is T_map_robot now, `twist` what the robot does now, `now_s` monotonic seconds."""
        ...
