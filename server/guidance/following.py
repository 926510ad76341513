"""Following a route (spec gpss, "The operator's side"): how far a robot has come, and the temporary waypoint it is given.

The temporary waypoint runs a look-ahead ahead of the robot along the leg. Near the leg's end it stays on the line through
the robot and the waypoint, at most a little *beyond* the waypoint, until the robot has been within the waypoint's radius:
the robot's controller stops steering within `CONTROLLER_LOCK_M` of a target, so that a target on the waypoint itself would
let it miss small radii. Where the robot arrives (the route's end, a waypoint with a heading) its target is the waypoint,
and final. A robot that rests short of it, out of the radius, is sent a little beyond.

A controller that follows a line instead of a point finds it in the command's path: the legs as the operator drew them.
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

from geometry import SE2, angle_difference
from protocol.messages import Route, Target, Waypoint
from protocol.messages.fleet import MOST_PATH_POINTS
from server.guidance.box import PlannedPath
from server.guidance.parameters import CONTROLLER_LOCK_M, CONTROLLER_REACHED_M, GuidanceParameters
from server.guidance.path import (
    Point,
    bearing,
    closest_approach,
    distance,
    point_along,
    progress_along,
    without_repeats,
)

_SLOWEST_SHARE = 0.3
_MOST_POINTS = 64
_SHORT_M = 0.05
_BEYOND_FINAL_M = 0.08
"""Robots that stop within a tolerance of their target come to rest 0.10 to 0.15 m before it."""
_PATH_BEHIND_M = 0.3
_PATH_AHEAD_M = 4.0
"""More than what any of the vehicles needs for stopping."""


@dataclass(frozen=True, slots=True)
class Stop:
    """A leg resolved: the waypoint it ends at and the speed set-point on the way there."""

    waypoint: Waypoint
    speed_mps: float

    @property
    def point(self) -> Point:
        return self.waypoint.x, self.waypoint.y


@dataclass(frozen=True, slots=True)
class RoutePlan:
    """A route with its waypoints looked up. A loop with a single waypoint is no loop: one arrives and stays."""

    stops: tuple[Stop, ...]
    loop: bool

    def arrives_at(self, leg: int) -> bool:
        """Whether the robot is to stop at the leg's end: the route ends there, or the robot turns there."""
        ends = not self.loop and leg == len(self.stops) - 1
        return ends or self.stops[leg].waypoint.yaw is not None


def resolve(route: Route, waypoints: Mapping[str, Waypoint]) -> RoutePlan | str:
    """The plan, or the id of the first waypoint that does not exist."""
    for leg in route.legs:
        if leg.waypoint not in waypoints:
            return leg.waypoint
    stops = tuple(Stop(waypoints[leg.waypoint], leg.speed_mps) for leg in route.legs)
    return RoutePlan(stops, route.loop and len({stop.point for stop in stops}) > 1)


@dataclass(frozen=True, slots=True)
class Progress:
    """How far along a route: the leg being driven, laps completed, and whether the route is over."""

    leg: int
    laps: int
    done: bool = False


@dataclass(frozen=True, slots=True)
class Goal:
    """What to ask of the robot next: `turn_to` (rad) on the spot, or else `target` at up to `speed_mps`; `final` when the
    target is a place to arrive at."""

    target: Target
    speed_mps: float
    final: bool
    turn_to: float | None = None


@dataclass(frozen=True, slots=True)
class Sight:
    """A robot as it is seen: its pose, whether it says that it neither drives nor turns, and when (monotonic seconds)."""

    pose: SE2
    at_rest: bool
    now_s: float


class RouteFollower:
    """One robot on one assignment. Remembers what an assignment does not say: where the leg began, whether the robot is
    turning at a waypoint that it has reached, and the final target that it was given."""

    def __init__(self, parameters: GuidanceParameters) -> None:
        self._parameters = parameters
        self._anchor: Point | None = None
        self._before_anchor: Point | None = None
        self._previous: Point | None = None
        self._turning = False
        self._there_since_s: float | None = None
        self._final: Point | None = None
        self._at_rest_since_s: float | None = None

    def interrupt(self) -> None:
        """The robot is not following now: what it passes meanwhile does not count."""
        self._previous = None
        self._there_since_s = self._at_rest_since_s = None

    def advance(self, plan: RoutePlan, progress: Progress, seen: Sight) -> Progress:
        """The progress after the newest measured pose: at most one leg further. Between two poses the robot is taken to
        have driven straight, so that a waypoint passed between them counts; where it is to arrive it must come to rest."""
        here = (seen.pose.x, seen.pose.y)
        previous, self._previous = self._previous or here, here
        if self._anchor is None:
            began = progress.leg == 0 and progress.laps == 0
            self._anchor = here if began else plan.stops[progress.leg - 1].point
        yaw = plan.stops[progress.leg].waypoint.yaw
        if not self._turning:
            if not self._reached(plan, progress.leg, previous, here, seen):
                return progress
            if yaw is not None:
                self._turning, self._there_since_s = True, None
        if self._turning and yaw is not None:
            turned = abs(angle_difference(yaw, seen.pose.yaw)) <= self._parameters.yaw_tolerance_rad
            if not self._settled(turned, seen):
                return progress
        self._before_anchor, self._anchor = self._anchor, plan.stops[progress.leg].point
        self._turning, self._final = False, None
        self._there_since_s = self._at_rest_since_s = None
        if progress.leg + 1 < len(plan.stops):
            return Progress(progress.leg + 1, progress.laps)
        return Progress(0, progress.laps + 1) if plan.loop else Progress(progress.leg, progress.laps, done=True)

    def goal(self, plan: RoutePlan, leg: int, seen: Sight, speed_mps: float) -> Goal:
        """What to ask of a robot on `leg`, at no more than `speed_mps`; `seen.pose` is where it is now."""
        point, yaw = plan.stops[leg].point, plan.stops[leg].waypoint.yaw
        here = (seen.pose.x, seen.pose.y)
        if self._turning and yaw is not None:
            return Goal(Target(x=point[0], y=point[1], yaw=yaw), 0.0, True, yaw)
        carrot, final = self._carrot_on_leg(plan, leg, here), False
        if carrot is not None:
            self._final = None
        elif plan.arrives_at(leg):
            carrot, final = self._final_target(plan, leg, here, seen), True
        else:
            left = distance(here, point)
            beyond = min(self._parameters.pass_beyond_m, max(0.0, self._parameters.look_ahead_m - left))
            carrot = point_along(here, point, left + beyond)
        speed = min(self._corner_speed(plan, leg, here, speed_mps), _aimed_speed(speed_mps, seen.pose, carrot))
        return Goal(Target(x=carrot[0], y=carrot[1]), speed, final)

    def planned_path(self, plan: RoutePlan, leg: int, pose: SE2) -> PlannedPath:
        """From the robot over the temporary waypoint and the waypoints ahead: to the route's end, or one lap."""
        here = (pose.x, pose.y)
        carrot = self._carrot_on_leg(plan, leg, here)
        near = [here, *([carrot] if carrot is not None else []), plan.stops[leg].point]
        to_waypoint = sum(distance(a, b) for a, b in itertools.pairwise(near))
        ahead = range(leg + 1, leg + len(plan.stops) if plan.loop else len(plan.stops))
        points = near + [plan.stops[index % len(plan.stops)].point for index in ahead]
        return PlannedPath(without_repeats(points)[:_MOST_POINTS], to_waypoint)

    def path_ahead(self, plan: RoutePlan, leg: int, pose: SE2) -> tuple[Point, ...]:
        """The drawn line from a little behind the robot to where it arrives next, or some metres ahead. Empty for a robot
        that is sent beyond its waypoint. A robot that drove past the leg's end out of its radius is led back to it."""
        here, end = (pose.x, pose.y), plan.stops[leg].point
        if self._final not in (None, end):
            return ()
        start = self._anchor or here
        done = progress_along(here, start, end)
        if done >= distance(start, end) and distance(here, end) > self._within_m(plan, leg):
            points = [here]
        elif done > _PATH_BEHIND_M or self._before_anchor is None:
            points = [point_along(start, end, max(0.0, done - _PATH_BEHIND_M))]
        else:
            before = self._before_anchor
            along = progress_along(here, before, start)
            points = [point_along(before, start, max(0.0, along - _PATH_BEHIND_M)), start]
        length = distance(here, end)
        points.append(end)
        for index in range(leg, leg + len(plan.stops)):
            if plan.arrives_at(index % len(plan.stops)) or length > _PATH_AHEAD_M:
                break
            points.append(plan.stops[(index + 1) % len(plan.stops)].point)
            length += distance(points[-2], points[-1])
        return tuple((round(x, 4), round(y, 4)) for x, y in without_repeats(points)[:MOST_PATH_POINTS])

    def _reached(self, plan: RoutePlan, leg: int, previous: Point, here: Point, seen: Sight) -> bool:
        """Whether the robot has been within the leg's waypoint, or rests within it where it arrives."""
        point, within = plan.stops[leg].point, self._within_m(plan, leg)
        if plan.arrives_at(leg):
            return self._settled(distance(here, point) <= within, seen)
        return closest_approach(previous, here, point) <= within

    def _settled(self, there: bool, seen: Sight) -> bool:
        """Whether the robot is there and at rest; one that never quite rests is given `settle_s`."""
        if not there:
            self._there_since_s = None
            return False
        since, self._there_since_s = self._there_since_s, self._there_since_s or seen.now_s
        return seen.at_rest or (since is not None and seen.now_s - since >= self._parameters.settle_s)

    def _within_m(self, plan: RoutePlan, leg: int) -> float:
        """How near the waypoint counts: its radius less a margin; where the robot arrives, what the controller promises."""
        within = self._parameters.reached_within_m(plan.stops[leg].waypoint.radius_m)
        if plan.arrives_at(leg):
            return min(within, self._parameters.reached_within_m(CONTROLLER_REACHED_M))
        return within

    def _carrot_on_leg(self, plan: RoutePlan, leg: int, here: Point) -> Point | None:
        """The temporary waypoint while it lies before the leg's end, else None."""
        start, end = self._anchor or here, plan.stops[leg].point
        ahead = progress_along(here, start, end) + self._parameters.look_ahead_m
        return point_along(start, end, ahead) if ahead < distance(start, end) else None

    def _final_target(self, plan: RoutePlan, leg: int, here: Point, seen: Sight) -> Point:
        """The waypoint; for a robot that came to rest near by, but out of the radius, a place a little beyond it. The same at
        every call, for a robot takes another target for another task."""
        if not seen.at_rest or distance(here, plan.stops[leg].point) > CONTROLLER_LOCK_M:
            self._at_rest_since_s = None
        elif self._at_rest_since_s is None:
            self._at_rest_since_s = seen.now_s
        rests = self._at_rest_since_s is not None and seen.now_s - self._at_rest_since_s >= self._parameters.settle_s
        if self._final is None or rests:
            point = plan.stops[leg].point
            self._final = point_along(here, point, distance(here, point) + _BEYOND_FINAL_M) if rests else point
            self._at_rest_since_s = None
        return self._final

    def _corner_speed(self, plan: RoutePlan, leg: int, here: Point, speed_mps: float) -> float:
        """Slower before a corner: the speed from which braking gently still leaves v max(0.3, cos^2 of the turn) there."""
        if plan.arrives_at(leg) or self._anchor is None:
            return speed_mps  # the controller slows down by itself
        point, after = plan.stops[leg].point, plan.stops[(leg + 1) % len(plan.stops)].point
        if distance(self._anchor, point) < _SHORT_M or distance(point, after) < _SHORT_M:
            return speed_mps
        slow = speed_mps * _share(angle_difference(bearing(point, after), bearing(self._anchor, point)))
        left = max(0.0, distance(here, point) - self._within_m(plan, leg))
        return min(speed_mps, math.sqrt(slow**2 + 2 * self._parameters.corner_mps2 * left))


def _aimed_speed(speed_mps: float, pose: SE2, target: Point) -> float:
    """Slower while the robot does not head for its target, so that it leaves its path less."""
    return speed_mps * _share(angle_difference(bearing((pose.x, pose.y), target), pose.yaw))


def _share(angle_rad: float) -> float:
    """The share of the speed that is left at an angle: max(0.3, cos^2), so 0.3 from 57 degrees on."""
    return max(_SLOWEST_SHARE, math.cos(angle_rad) ** 2 if abs(angle_rad) < math.pi / 2 else 0.0)
