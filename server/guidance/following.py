"""Following a route (spec gpss, "The operator's side"): how far a robot has come, and the temporary waypoint it is given.

The temporary waypoint runs a look-ahead ahead of the robot along the leg. Near the leg's end it stays on the line through
the robot and the waypoint, at most a little *beyond* the waypoint, until the robot has been within the waypoint's radius:
the robot's controller stops steering within `CONTROLLER_LOCK_M` of a target, so that a target on the waypoint itself would
let it miss small radii. Where the robot arrives (the route's end, a waypoint with a heading) its target is the waypoint,
and final. A robot that rests short of it, out of the radius, is sent a little beyond.

A controller that follows a line instead of a point finds it in the command's path: the legs as the operator drew them, or
the detour. A detour is another line for a leg, one that ends where the leg does: everything else stays as it is.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from geometry import SE2, angle_difference
from protocol.messages import Target
from protocol.messages.fleet import MOST_PATH_POINTS
from server.guidance.box import PlannedPath
from server.guidance.line import Line
from server.guidance.line_driving import LineDriver
from server.guidance.parameters import CONTROLLER_LOCK_M, CONTROLLER_REACHED_M, GuidanceParameters
from server.guidance.path import (
    Point,
    bearing,
    closest_approach,
    distance,
    point_along,
    polyline_length,
    progress_along,
    without_repeats,
)
from server.guidance.route_plan import Progress, RoutePlan, Stop

_SLOWEST_SHARE = 0.3
_MOST_POINTS = 64
_SHORT_M = 0.05
_BESIDE_M = 0.5
"""A robot further than this from the way between two waypoints is not on it."""
_BEYOND_FINAL_M = 0.08
"""Robots that stop within a tolerance of their target come to rest 0.10 to 0.15 m before it."""
_PATH_BEHIND_M = 0.3
_PATH_AHEAD_M = 4.0
"""More than what any of the vehicles needs for stopping."""


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


@dataclass(frozen=True, slots=True)
class Detour:
    """Another line for one leg: from where the robot was to the leg's end; back on the route after `back_m` metres of it. It was
    planned for `waypoint` being where it is; `why` says what it is for."""

    line: Line
    back_m: float
    waypoint: Point
    why: str


class RouteFollower:
    """One robot on one assignment. Remembers what an assignment does not say: where the leg began, the detour it makes, whether
    the robot is turning at a waypoint that it has reached, and the final target that it was given."""

    def __init__(self, parameters: GuidanceParameters) -> None:
        self._parameters = parameters
        self._anchor: Point | None = None
        self._before_anchor: Point | None = None
        self._detour: Detour | None = None
        self._driver: LineDriver | None = None
        self._later_detours: dict[int, Detour] = {}
        self._previous: Point | None = None
        self._turning = False
        self._turn_to: float | None = None
        self._there_since_s: float | None = None
        self._final: Point | None = None
        self._at_rest_since_s: float | None = None

    def interrupt(self) -> None:
        """The robot is not following now: what it passes meanwhile does not count."""
        self._previous = None
        self._there_since_s = self._at_rest_since_s = None

    def advance(self, plan: RoutePlan, progress: Progress, seen: Sight) -> Progress:
        """The progress after the newest measured pose: at most one leg further, or staying at the end of this one. Between two
        poses the robot is taken to have driven straight, so that a waypoint passed between them counts; where it is to arrive
        it must come to rest."""
        here = (seen.pose.x, seen.pose.y)
        previous, self._previous = self._previous or here, here
        stop = plan.stops[progress.leg]
        if self._anchor is None:
            self._anchor = _leg_start(plan, progress, here)
        self._watch_detour(stop, here)
        if not self._turning:
            if not (stop.turns_only or self._reached(plan, progress.leg, previous, here, seen)):
                return progress
            self._turn_to = self._heading_at(stop, here)
            if self._turn_to is not None:
                self._turning, self._there_since_s = True, None
        if self._turning and self._turn_to is not None:
            turned = abs(angle_difference(self._turn_to, seen.pose.yaw)) <= self._parameters.yaw_tolerance_rad
            if not self._settled(turned, seen):
                return progress
        if stop.leg.stays:
            return Progress(progress.leg, progress.laps, staying=True)
        return self.depart(plan, progress)

    def depart(self, plan: RoutePlan, progress: Progress) -> Progress:
        """The progress of a robot that is done with its leg and with what it stayed for at its end."""
        stop = plan.stops[progress.leg]
        if not stop.turns_only:
            self._before_anchor, self._anchor = self._anchor, stop.point
        last = progress.leg + 1 == len(plan.stops)
        leg = 0 if last else progress.leg + 1
        self._make(self._later_detours.pop(leg, None))
        self._turning, self._final = False, None
        self._there_since_s = self._at_rest_since_s = None
        if not last:
            return Progress(leg, progress.laps)
        return Progress(0, progress.laps + 1) if plan.loop else Progress(progress.leg, progress.laps, done=True)

    def divert(self, detours: Mapping[int, Detour]) -> None:
        """From now on drives legs, by index and the present one first, along other lines."""
        self._later_detours = dict(detours)
        self._make(self._later_detours.pop(next(iter(detours))))
        self._final = None

    @property
    def detour(self) -> Detour | None:
        """The detour that the robot makes, until it is back on its route."""
        return self._detour

    def detour_ahead(self, pose: SE2) -> list[Point]:
        """What is left of the detour; empty on the route."""
        if self._detour is None or self._driver is None:
            return []
        along = self._driver.along((pose.x, pose.y))
        if along >= self._detour.back_m:
            return []
        return [(pose.x, pose.y), *self._detour.line.part(along, self._detour.back_m)[1:]]

    def route_line(self, plan: RoutePlan, leg: int, pose: SE2) -> Line:
        """The way of the leg as the operator drew it, from abreast of the robot to its end."""
        line = Line([self._anchor or (pose.x, pose.y), plan.stops[leg].point])
        return Line(line.part(line.locate((pose.x, pose.y)), line.length_m))

    def goal(self, plan: RoutePlan, leg: int, seen: Sight, speed_mps: float) -> Goal:
        """What to ask of a robot on `leg`, at no more than `speed_mps`; `seen.pose` is where it is now."""
        stop, here = plan.stops[leg], (seen.pose.x, seen.pose.y)
        point, yaw = self._end(plan, leg), self._turn_to if self._turning else None
        if stop.turns_only and yaw is None:
            yaw = self._heading_at(stop, here)
            yaw = seen.pose.yaw if yaw is None else yaw
        if yaw is not None:
            return Goal(Target(x=stop.point[0], y=stop.point[1], yaw=yaw), 0.0, True, yaw)
        carrot, final = self._carrot_on_leg(plan, leg, here), False
        turn = self._driver.turn_to(seen.pose) if self._driver is not None and carrot is not None else None
        if turn is not None:
            return Goal(Target(x=here[0], y=here[1], yaw=turn), 0.0, True, turn)
        if carrot is not None:
            self._final = None
        elif plan.arrives_at(leg):
            carrot, final = self._final_target(plan, leg, here, seen), True
        else:
            left = distance(here, point)
            beyond = min(self._parameters.pass_beyond_m, max(0.0, self._parameters.look_ahead_m - left))
            carrot = point_along(here, point, left + beyond)
        if self._detour is not None:
            speed_mps = min(speed_mps, self._parameters.detour_mps)
        speed = min(self._corner_speed(plan, leg, here, speed_mps), _aimed_speed(speed_mps, seen.pose, carrot))
        return Goal(Target(x=carrot[0], y=carrot[1]), speed, final)

    def planned_path(self, plan: RoutePlan, leg: int, pose: SE2) -> PlannedPath:
        """From the robot over the temporary waypoint and the waypoints ahead: to the route's end, or one lap."""
        here = (pose.x, pose.y)
        near = [here]
        if not plan.stops[leg].turns_only:
            carrot = self._carrot_on_leg(plan, leg, here)
            if self._driver is not None:
                near = self._driver.ahead(here)
            elif carrot is not None:
                near.append(carrot)
            near.append(self._end(plan, leg))
        to_waypoint = polyline_length(near)
        points = list(near)
        for index in plan.driven_after(leg):
            points += self._points_of(plan, index)
        return PlannedPath(without_repeats(points)[:_MOST_POINTS], to_waypoint)

    def path_ahead(self, plan: RoutePlan, leg: int, pose: SE2) -> tuple[Point, ...]:
        """The line to drive, from a little behind the robot to where it arrives next, or some metres ahead. Empty for a robot
        that is sent beyond its waypoint. A robot that drove past the leg's end out of its radius is led back to it."""
        here, end = (pose.x, pose.y), self._end(plan, leg)
        if self._final not in (None, end):
            return ()
        line = self._line(plan, leg, here)
        done = line.locate(here) if self._driver is None else self._driver.along(here)
        if done >= line.length_m and distance(here, end) > self.within_m(plan, leg):
            points = [here]
        elif done > _PATH_BEHIND_M or self._before_anchor is None or self._detour is not None:
            # A robot that has turned at a bend stands a little before it: led by the piece before, it would turn back.
            begun_m = 0.0 if self._driver is None else self._driver.begun_m
            points = line.part(max(begun_m, done - _PATH_BEHIND_M), line.length_m)[:-1]
        else:
            before, start = self._before_anchor, line.points[0]
            along = progress_along(here, before, start)
            points = [point_along(before, start, max(0.0, along - _PATH_BEHIND_M)), start]
        length = max(distance(here, end), line.length_m - done)
        points.append(end)
        for index in range(leg, leg + len(plan.stops)):
            if plan.arrives_at(index % len(plan.stops)) or length > _PATH_AHEAD_M:
                break
            following = self._points_of(plan, (index + 1) % len(plan.stops))
            length += polyline_length([points[-1], *following])
            points += following
        return tuple((round(x, 4), round(y, 4)) for x, y in without_repeats(points)[:MOST_PATH_POINTS])

    def _points_of(self, plan: RoutePlan, later_leg: int) -> list[Point]:
        """Where a later leg leads."""
        detour = self._later_detours.get(later_leg)
        return [plan.stops[later_leg].point] if detour is None else list(detour.line.points)

    def _watch_detour(self, stop: Stop, here: Point) -> None:
        """A detour is over where it is back on the route, when its waypoint was moved, and when the robot is far from it."""
        if self._detour is None or self._driver is None:
            return
        along = self._driver.move_on(here)
        astray = distance(here, self._detour.line.at(along)) > _BESIDE_M
        if astray or self._detour.waypoint != stop.point:
            self._anchor, self._before_anchor = here, None
        elif along < self._detour.back_m or self._driver.aligning:
            return
        self._make(None)

    def _make(self, detour: Detour | None) -> None:
        """Makes that detour, or none, from now on."""
        self._detour = detour
        self._driver = None if detour is None else LineDriver(detour.line, self._parameters)

    def _heading_at(self, stop: Stop, here: Point) -> float | None:
        """The heading (rad) to end the leg with, None when it does not matter."""
        if stop.yaw is None and stop.turns_only and distance(here, stop.point) > _SHORT_M:
            return bearing(here, stop.point)
        return stop.yaw

    def _end(self, plan: RoutePlan, leg: int) -> Point:
        """Where the leg ends: at its waypoint, or, on a detour, where the robot comes within its radius."""
        return plan.stops[leg].point if self._detour is None else self._detour.line.end

    def _line(self, plan: RoutePlan, leg: int, here: Point) -> Line:
        return Line([self._anchor or here, plan.stops[leg].point]) if self._detour is None else self._detour.line

    def _reached(self, plan: RoutePlan, leg: int, previous: Point, here: Point, seen: Sight) -> bool:
        """Whether the robot has been within the leg's waypoint, or rests within it where it arrives."""
        point, within = plan.stops[leg].point, self.within_m(plan, leg)
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

    def within_m(self, plan: RoutePlan, leg: int) -> float:
        """How near the waypoint counts: its radius less a margin; where the robot arrives, what the controller promises."""
        within = self._parameters.reached_within_m(plan.stops[leg].waypoint.radius_m)
        if plan.arrives_at(leg):
            return min(within, self._parameters.reached_within_m(CONTROLLER_REACHED_M))
        return within

    def _carrot_on_leg(self, plan: RoutePlan, leg: int, here: Point) -> Point | None:
        """The temporary waypoint while it lies before the leg's end, else None."""
        if plan.stops[leg].turns_only:
            return None
        if self._driver is not None:
            return self._driver.carrot(here)
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
            point = self._end(plan, leg)
            self._final = point_along(here, point, distance(here, point) + _BEYOND_FINAL_M) if rests else point
            self._at_rest_since_s = None
        return self._final

    def _corner_speed(self, plan: RoutePlan, leg: int, here: Point, speed_mps: float) -> float:
        """Slower before a corner: the speed from which braking gently still leaves v max(0.3, cos^2 of the turn) there."""
        line = self._line(plan, leg, here)
        if plan.arrives_at(leg) or line.last_bearing is None:
            return speed_mps  # the controller slows down by itself
        point, after = line.end, plan.stops[(leg + 1) % len(plan.stops)].point
        if line.length_m < _SHORT_M or distance(point, after) < _SHORT_M:
            return speed_mps
        slow = speed_mps * _share(angle_difference(bearing(point, after), line.last_bearing))
        left = max(0.0, distance(here, point) - self.within_m(plan, leg))
        return min(speed_mps, math.sqrt(slow**2 + 2 * self._parameters.corner_mps2 * left))


def _leg_start(plan: RoutePlan, progress: Progress, here: Point) -> Point:
    """Where a leg began of which nothing is remembered: at the waypoint before; where the robot is when it has only started, or
    is far from the way between them (it was sent to another leg, or pushed)."""
    if progress.leg == 0 and progress.laps == 0:
        return here
    before, end = plan.stops[progress.leg - 1], plan.stops[progress.leg]
    beside = closest_approach(before.point, end.point, here) <= _BESIDE_M
    return before.point if beside and not before.turns_only else here


def _aimed_speed(speed_mps: float, pose: SE2, target: Point) -> float:
    """Slower while the robot does not head for its target, so that it leaves its path less."""
    return speed_mps * _share(angle_difference(bearing((pose.x, pose.y), target), pose.yaw))


def _share(angle_rad: float) -> float:
    """The share of the speed that is left at an angle: max(0.3, cos^2), so 0.3 from 57 degrees on."""
    return max(_SLOWEST_SHARE, math.cos(angle_rad) ** 2 if abs(angle_rad) < math.pi / 2 else 0.0)
