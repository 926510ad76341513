"""Following a route (spec gpss, "The operator's side"): how far a robot has come, and the temporary waypoint it is given.

The temporary waypoint runs a look-ahead ahead of the robot along the leg. Near the leg's end it stays on the line through
the robot and the waypoint, at most a little *beyond* the waypoint, until the robot has been within the waypoint's radius:
the robot's controller stops `CONTROLLER_REACHED_M` before any target and stops steering before that, so a target on the
waypoint itself would leave it outside of small radii. At a place to arrive at (the route's end, a waypoint with a heading)
the target lies beyond by just so much that the controller's stopping point is well within the radius.
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

from geometry import SE2, angle_difference
from protocol.messages import Route, Target, Waypoint
from server.guidance.box import PlannedPath
from server.guidance.parameters import CONTROLLER_REACHED_M, GuidanceParameters
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


class RouteFollower:
    """One robot on one assignment. Remembers what an assignment does not say: where the first leg began, and whether the
    robot is turning at a waypoint that it has reached."""

    def __init__(self, parameters: GuidanceParameters) -> None:
        self._parameters = parameters
        self._anchor: Point | None = None
        self._turning: int | None = None
        self._previous: Point | None = None

    def interrupt(self) -> None:
        """The robot is not following now: what it passes meanwhile does not count."""
        self._previous = None

    def advance(self, plan: RoutePlan, progress: Progress, measured: SE2) -> Progress:
        """The progress after the newest measured pose: at most one leg further. Between two poses the robot is taken to
        have driven straight, so that a waypoint passed between them counts."""
        stop = plan.stops[progress.leg]
        here = (measured.x, measured.y)
        previous, self._previous = self._previous or here, here
        if self._anchor is None:
            began = progress.leg == 0 and progress.laps == 0
            self._anchor = here if began else plan.stops[progress.leg - 1].point
        if self._turning == progress.leg:
            yaw = stop.waypoint.yaw
            if yaw is not None and abs(angle_difference(yaw, measured.yaw)) > self._parameters.yaw_tolerance_rad:
                return progress
            self._turning = None
        else:
            self._turning = None
            if closest_approach(previous, here, stop.point) > self._within_m(plan, progress.leg):
                return progress
            if stop.waypoint.yaw is not None:
                self._turning = progress.leg
                return progress
        self._anchor = stop.point
        if progress.leg + 1 < len(plan.stops):
            return Progress(progress.leg + 1, progress.laps)
        return Progress(0, progress.laps + 1) if plan.loop else Progress(progress.leg, progress.laps, done=True)

    def goal(self, plan: RoutePlan, leg: int, pose: SE2, speed_mps: float) -> Goal:
        """What to ask of a robot at `pose` on `leg`, at no more than `speed_mps`."""
        stop = plan.stops[leg]
        here = (pose.x, pose.y)
        yaw = stop.waypoint.yaw
        if self._turning == leg and yaw is not None:
            return Goal(Target(x=stop.point[0], y=stop.point[1], yaw=yaw), 0.0, True, yaw)
        carrot = self._carrot_on_leg(plan, leg, here)
        if carrot is not None:
            return Goal(Target(x=carrot[0], y=carrot[1]), _regulated(speed_mps, pose, carrot), False)
        final = plan.arrives_at(leg)
        target = self._beyond(plan, leg, here)
        return Goal(
            Target(x=target[0], y=target[1], yaw=yaw if final else None), _regulated(speed_mps, pose, target), final
        )

    def planned_path(self, plan: RoutePlan, leg: int, pose: SE2) -> PlannedPath:
        """From the robot over the temporary waypoint and the waypoints ahead: to the route's end, or one lap."""
        here = (pose.x, pose.y)
        carrot = self._carrot_on_leg(plan, leg, here)
        near = [here, *([carrot] if carrot is not None else []), plan.stops[leg].point]
        to_waypoint = sum(distance(a, b) for a, b in itertools.pairwise(near))
        ahead = range(leg + 1, leg + len(plan.stops) if plan.loop else len(plan.stops))
        points = near + [plan.stops[index % len(plan.stops)].point for index in ahead]
        return PlannedPath(without_repeats(points)[:_MOST_POINTS], to_waypoint)

    def _within_m(self, plan: RoutePlan, leg: int) -> float:
        """How near the waypoint counts: its radius less a margin; where the robot arrives, as near as it gets."""
        within = self._parameters.reached_within_m(plan.stops[leg].waypoint.radius_m)
        if plan.arrives_at(leg):
            return min(within, self._parameters.reached_within_m(CONTROLLER_REACHED_M))
        return within

    def _carrot_on_leg(self, plan: RoutePlan, leg: int, here: Point) -> Point | None:
        """The temporary waypoint while it lies before the leg's end, else None."""
        start, end = self._anchor or here, plan.stops[leg].point
        ahead = progress_along(here, start, end) + self._parameters.look_ahead_m
        return point_along(start, end, ahead) if ahead < distance(start, end) else None

    def _beyond(self, plan: RoutePlan, leg: int, here: Point) -> Point:
        """The target near a leg's end, on the line from the robot through the waypoint; see the module."""
        point = plan.stops[leg].point
        left = distance(here, point)
        if plan.arrives_at(leg):
            beyond = max(0.0, CONTROLLER_REACHED_M - self._within_m(plan, leg) / 2)
        else:
            beyond = min(self._parameters.pass_beyond_m, max(0.0, self._parameters.look_ahead_m - left))
        return point_along(here, point, left + beyond)


def _regulated(speed_mps: float, pose: SE2, target: Point) -> float:
    """Slower while the robot does not head for its target, so that it leaves its path less: v max(0.3, cos^2 error)."""
    error = angle_difference(bearing((pose.x, pose.y), target), pose.yaw)
    share = math.cos(error) ** 2 if abs(error) < math.pi / 2 else 0.0
    return speed_mps * max(_SLOWEST_SHARE, share)
