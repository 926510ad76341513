"""Path following in the Frenet frame of the line to drive on, under the name `frenet` (spec gpss, "Better than the report").

The robot is compared with the nearest place on the line (Samson 1993; de Wit 1996): its offset to the left and its heading
error. Both go to nought over a settling length while the line's own curvature is fed forward. The speed is what curves ahead,
braking to the line's end and the vehicle's yaw rate allow, as in regulated pursuit: corners are rounded slowly instead of
cut. At the end the robot stands within millimetres of its estimate, looks again once it stands, and moves up if need be.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

from agents.control.controller import Goal, Point, Steering
from agents.control.docking import Dock, DockConfig
from agents.control.smooth_path import SmoothPath, sections
from agents.control.speed_profile import SpeedProfile, braking_speed, curve_caps
from agents.control.turning import Turn, TurningConstants
from agents.motion import STOP, Twist, clip
from geometry import SE2, angle_difference
from protocol.lab import Limits

_SAME_POINT_M = 0.01
_BEHIND_M = 0.65
"""A corner that was turned at is remembered while the line begins no further before it: guidance tells 0.3 m behind the robot,
and a robot that drives back along a sharp corner is itself behind it."""
_SEEK_M, _ASIDE_M = 1.0, 0.5
"""The robot is sought on the first metre of a line that came anew; further on only if it is not near that."""
_BACK_M, _FORTH_M = 0.1, 0.25
"""From one round to the next its place on the line moves at most so far."""
_SLOWEST_MPS = 0.03
_TURN_SHARE = 0.85
"""Of the vehicle's yaw rate, for following curves; the rest is for feedback."""
_YAW_STEP_S = 0.08
"""Where the curvature jumps the yaw rate does too; by no more than what the vehicle makes up for in this time."""
_LEAST_STRETCH = 0.3
_AT_CORNER_M, _NEAR_CORNER_M, _STANDS_MPS = 0.012, 0.05, 0.01
_FACES_RAD = 0.1
"""A turn before driving need not be finished to be driven on from."""
_ANOTHER_RAD = 0.3


@dataclass(frozen=True, slots=True)
class FrenetConfig:
    """How lines are followed.

    - `corner_cut_m`: by how much a corner may be cut where it is rounded.
    - `pivot_above_rad`: at sharper corners the robot halts and turns on the spot.
    - `turn_above_rad`: so far off the line's heading the robot turns on the spot before it drives.
    - `settle_m`, `settle_s`: offsets go to nought over this length, or the way of this time if that is more.
    - `lead_s`: until a set-point is what the wheels do (control period, network, motors); the robot is steered from where
      it will then be.
    - `braking_mps2`, `lateral_mps2`: accelerations that the speed is planned with.
    - `approach_per_s`: at the end of the line the speed falls with the way that is left, by this factor.
    - `tolerance_m`: how near its goal a robot that stands is content.
    - `swivel_s`: see `TurningConstants`.
    """

    corner_cut_m: float = 0.02
    pivot_above_rad: float = 1.9
    turn_above_rad: float = math.radians(65.0)
    settle_m: float = 0.2
    settle_s: float = 0.5
    lead_s: float = 0.1
    braking_mps2: float = 0.5
    lateral_mps2: float = 0.5
    approach_per_s: float = 3.0
    tolerance_m: float = 0.01
    swivel_s: float = 0.0


class FrenetController:
    """One robot's. Where it is on the line is remembered as a place on the floor, for the line comes anew with each command."""

    def __init__(self, limits: Limits, config: FrenetConfig | None = None) -> None:
        self._limits = limits
        self._config = config or FrenetConfig()
        self._turning = TurningConstants(
            tolerance_rad=_FACES_RAD, looks_s=0.0, lead_s=self._config.lead_s, swivel_s=self._config.swivel_s
        )
        self.reset()

    def reset(self) -> None:
        self._turn: Turn | None = None
        self._dock: Dock | None = None
        self._goal: Point | None = None
        self._anchor: Point | None = None
        self._foot: Point | None = None
        self._way_m: float | None = None
        self._turned_at: Point | None = None
        self._points: tuple[Point, ...] = ()
        self._path: SmoothPath | None = None
        self._profile: SpeedProfile | None = None
        self._sections: list[list[Point]] = [[]]
        self._number = 0

    def steer(self, pose: SE2, twist: Twist, goal: Goal, now_s: float) -> Steering:
        distance_m = math.hypot(goal.x - pose.x, goal.y - pose.y)
        self._meet(pose, goal)
        if self._dock is not None:
            docked, rests = self._dock.step(pose, twist, now_s)
            return Steering(docked, distance_m, 0.0, rests, rests)
        path, profile = self._path, self._profile
        if path is None or profile is None:  # the goal is where the robot stands
            return self._stop(goal, distance_m, 0.0)
        soon = pose @ SE2.exp(self._config.lead_s * twist.linear_mps, 0.0, self._config.lead_s * twist.angular_radps)
        way_m = self._progress(path, soon)
        at = path.at(way_m)
        error_rad = angle_difference(soon.yaw, at.heading_rad)
        if self._turn is not None:
            if abs(angle_difference(self._turn.target_rad, at.heading_rad)) > _ANOTHER_RAD:
                self._turn = None  # the line is another one
            else:
                wanted, done = self._turn.step(pose.yaw, twist, now_s)
                if not done:
                    return Steering(wanted, distance_m, error_rad, False)
                self._turn = None
        left_m = path.length_m - way_m if self._halts(goal) else math.inf
        if not self._is_last and left_m < _AT_CORNER_M:
            end = path.at(path.length_m)
            if math.hypot(end.x - pose.x, end.y - pose.y) < _NEAR_CORNER_M or abs(twist.linear_mps) < _STANDS_MPS:
                self._turned_at = (end.x, end.y)
                self._lay(self._number + 1)
            return Steering(STOP, distance_m, error_rad, False)
        if goal.final and self._is_last and left_m <= self._config.tolerance_m / 3.0:
            return self._stop(goal, distance_m, error_rad)
        if abs(error_rad) > self._config.turn_above_rad:
            self._turn = Turn(at.heading_rad, self._limits, self._turning)
            return Steering(STOP, distance_m, error_rad, False)
        return Steering(self._follow(soon, twist, goal, way_m, left_m), distance_m, error_rad, False)

    def _follow(self, soon: SE2, twist: Twist, goal: Goal, way_m: float, left_m: float) -> Twist:
        """The law: offset and heading error at the place on the line where the robot will be."""
        assert self._path is not None and self._profile is not None
        config, limits, at = self._config, self._limits, self._path.at(way_m)
        offset_m = -math.sin(at.heading_rad) * (soon.x - at.x) + math.cos(at.heading_rad) * (soon.y - at.y)
        error_rad = angle_difference(soon.yaw, at.heading_rad)
        ahead_m = max(0.0, twist.linear_mps) * config.lead_s
        allowed = min(goal.speed_mps, limits.speed_mps, self._profile.speed_mps(way_m + ahead_m))
        if math.isfinite(left_m):
            allowed = min(allowed, braking_speed(max(0.0, left_m), config.braking_mps2, config.approach_per_s))
        gained = limits.acceleration_mps2 * config.lead_s
        speed = clip(allowed, twist.linear_mps - gained, twist.linear_mps + gained)
        settle_m = max(config.settle_m, config.settle_s * speed)
        towards_rad = -math.atan(offset_m / (2.0 * settle_m))
        gain_per_s = max(2.0 * speed / settle_m, 1.0)
        stretch = max(_LEAST_STRETCH, 1.0 - at.curvature * offset_m)
        rate = speed * at.curvature * math.cos(error_rad) / stretch + gain_per_s * (towards_rad - error_rad)
        if abs(rate) > limits.yaw_rate_radps:
            allowed *= max(0.2, limits.yaw_rate_radps / abs(rate))
        allowed *= max(0.0, math.cos(error_rad - towards_rad)) ** 2
        return Twist(max(0.0, allowed), rate).clipped(limits)

    def _stop(self, goal: Goal, distance_m: float, error_rad: float) -> Steering:
        """At the end: of the journey, or of a line whose goal goes on."""
        if goal.final:
            config = self._config
            dock = DockConfig(config.tolerance_m, config.approach_per_s, config.lead_s)
            self._dock = Dock((goal.x, goal.y), self._limits, dock, self._turning)
        return Steering(STOP, distance_m, error_rad, False)

    def _halts(self, goal: Goal) -> bool:
        """Whether the robot is to be able to stop at the end of the line it is on: not at a carrot, which moves on."""
        return bool(goal.path) or goal.final or not self._is_last

    def _meet(self, pose: SE2, goal: Goal) -> None:
        """Takes the line of this moment."""
        place = (goal.x, goal.y)
        if goal.final and self._goal != place:
            self._anchor = (pose.x, pose.y)
            self._dock = None
        self._goal = place if goal.final else None
        points = goal.path
        if len(points) < 2:
            start = self._anchor if goal.final and self._anchor is not None else (pose.x, pose.y)
            points = (start, place)
        if points != self._points:
            self._points = points
            self._sections = sections(points, self._config.pivot_above_rad)
            self._lay(self._number_of_section())

    def _lay(self, number: int) -> None:
        """Rounds one section of the line and plans its speeds."""
        self._number, self._way_m = number, None
        self._path = self._profile = None
        section = self._sections[number]
        if len(section) > 1:
            most_radps = _TURN_SHARE * self._limits.yaw_rate_radps
            self._path = SmoothPath.through(section, self._config.corner_cut_m)
            caps = curve_caps(
                self._path,
                most_radps,
                _YAW_STEP_S * self._limits.yaw_acceleration_radps2,
                self._config.lateral_mps2,
                _SLOWEST_MPS,
            )
            self._profile = SpeedProfile(self._path, caps, self._config.braking_mps2)

    def _number_of_section(self) -> int:
        """The one after the corner that was turned at last, if the line still begins a little before it; or else the first."""
        cut = self._sections
        if self._turned_at is not None and len(cut) > 1:
            behind_m = sum(math.dist(a, b) for a, b in pairwise(cut[0]))
            if behind_m < _BEHIND_M and math.dist(cut[1][0], self._turned_at) < _SAME_POINT_M:
                return 1
        self._turned_at = None
        return 0

    @property
    def _is_last(self) -> bool:
        return self._number == len(self._sections) - 1

    def _progress(self, path: SmoothPath, soon: SE2) -> float:
        """The way to the place nearest to the robot, from where it was last. On a line that came anew that place is sought
        at its beginning first."""
        if self._way_m is None:
            around = (soon.x, soon.y) if self._foot is None else self._foot
            self._way_m = path.nearest(*around, 0.0, _SEEK_M)
            found = path.at(self._way_m)
            if math.dist(around, (found.x, found.y)) > _ASIDE_M:
                self._way_m = path.nearest(*around, 0.0)
        self._way_m = path.nearest(soon.x, soon.y, self._way_m - _BACK_M, self._way_m + _FORTH_M)
        at = path.at(self._way_m)
        self._foot = (at.x, at.y)
        return self._way_m
