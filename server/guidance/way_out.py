"""Ways out for a robot that is blocked: around what stands on its route and back onto it, or aside, out of another robot's way.

The search is `server.planning`'s; this module says where to search from, where to, and over which floor.

At the bends of a detour robots turn on the spot, and the outline of a long one sweeps more floor then than the clearance
beside its way. So every bend of such a robot's way is looked at; where one has no room, the search is repeated with room for
the whole turning circle beside the way, and if that finds nothing either, the robot stays.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from geometry import SE2, angle_difference
from mapping.grid import CELL_M, FloorGrid
from protocol.lab import VehicleSpec
from server.guidance.blockage import RobotShapes, nearest_blockage
from server.guidance.box import Body, Box, footprint_at
from server.guidance.following import Detour, RouteFollower
from server.guidance.line import Line
from server.guidance.line_driving import PASSED_M
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point, bearing
from server.guidance.route_plan import RoutePlan
from server.guidance.turning import LITTLE_RAD, swept_by_turning
from server.planning import FreeSpace, Needs, ShortestWays, straightened

_SAMPLE_M = 0.05
_FARTHEST_M = 30.0
"""Beyond what is looked at, however long a leg is."""
_CLEAR_AFTER_M = 0.3
"""How far the route must have room beyond the place where a detour comes back to it."""
_HORIZON_M = 6.0
_ROOM_M = 4.0
"""How far along the route, and beside it, floor is looked at."""
_MOST_LEGS = 3
_TURN_BESIDE_M = 0.2
"""What stays free around the floor that a long robot sweeps at a bend. It turns there slowly, up to `PASSED_M` from the bend."""
_OFF_ROUTE = 1.5
"""What a metre off the route costs, one on it costing 1: so a way comes back soon, not only at the leg's end."""

_INNER, _RIM = (0.0, 0.3, 0.6), (0.9,)
"""Shares of a waypoint's radius at which a detour may end."""


class NoWay(Enum):
    """Why there is none: no floor that is wide enough, or none where the robot could turn at the bends."""

    ROOM = "wide"
    TURNING = "turning"


@dataclass(frozen=True, slots=True)
class Blocked:
    """A robot that is blocked on a leg of its route by something at `place` (None: it only wants back onto its route). It wants
    `room_m` of floor free on either side of its rotation centre."""

    spec: VehicleSpec
    pose: SE2
    plan: RoutePlan
    leg: int
    follower: RouteFollower
    place: Point | None
    why: str
    room_m: float
    unknown: bool

    @property
    def here(self) -> Point:
        return self.pose.x, self.pose.y


@dataclass(frozen=True, slots=True)
class Floor:
    """Where ways may lead: the obstacle grid, the lab's ground, the floor that other robots cover, and the lanes that they are
    about to drive along, widened so that the robot's centre is to stay out."""

    grid: FloorGrid
    ground: BaseGeometry
    robots: RobotShapes
    lanes: Sequence[BaseGeometry] = ()


def lane_of(path: Sequence[Point], length_m: float, room_m: float, beside: VehicleSpec) -> BaseGeometry | None:
    """The floor from which a robot's centre must stay away, so that another has `room_m` on either side of its path; None for
    one that goes nowhere."""
    line = Line(path) if path else None
    if line is None or line.length_m < _SAMPLE_M:
        return None
    radius = max(math.hypot(x, y) for x, y in beside.footprint)
    return LineString(line.part(0.0, length_m)).buffer(room_m + radius)


def way_around(blocked: Blocked, floor: Floor, parameters: GuidanceParameters) -> dict[int, Detour] | NoWay:
    """Detours for the present leg and, if need be, the next ones, that lead past what blocks the route, with room to turn at
    every bend; or why there are none."""
    detours = _detours(blocked, floor, parameters)
    if detours is None:
        return NoWay.ROOM
    circle_m = max(math.hypot(x, y) for x, y in blocked.spec.footprint)
    if circle_m + _TURN_BESIDE_M <= blocked.room_m or _may_turn(blocked, detours, floor, parameters):
        return detours
    wider = replace(blocked, room_m=max(blocked.room_m, circle_m + PASSED_M + CELL_M))
    detours = _detours(wider, floor, parameters)
    if detours is not None and _may_turn(wider, detours, floor, parameters):
        return detours
    return NoWay.TURNING


def _detours(blocked: Blocked, floor: Floor, parameters: GuidanceParameters) -> dict[int, Detour] | None:
    """The same without a look at the bends; None when there is no way with room enough beside it."""
    legs = _legs_ahead(blocked)
    if blocked.place is not None and not any(_passes(line, blocked.place) for _, line in legs):
        return None  # it stands beyond the end of the route: there is nothing to come back to
    space = _space(blocked, floor, [point for _, line in legs for point in line.part(0.0, _HORIZON_M)], parameters)
    if space is None:
        return None
    detours: dict[int, Detour] = {}
    here = blocked.here
    for leg, line in legs:
        ways = ShortestWays(space, here)
        waypoint = blocked.plan.stops[leg].point
        back_m = _back_on(line, blocked.place, space, ways)
        if back_m is not None:
            way = straightened(space, ways.way_to(line.at(back_m)))
            detour = Line([here, *way[1:-1], *line.part(back_m, line.length_m)])
            detours[leg] = Detour(detour, detour.length_m - (line.length_m - back_m), waypoint, blocked.why)
            if back_m < line.length_m - _SAMPLE_M or blocked.place is None or _passes(line, blocked.place):
                return detours
        else:
            end = _within(waypoint, blocked.follower.within_m(blocked.plan, leg), space, ways)
            if end is None:
                return None
            detour = Line([here, *straightened(space, ways.way_to(end))[1:-1], end])
            detours[leg] = Detour(detour, detour.length_m, waypoint, blocked.why)
        if blocked.plan.arrives_at(leg):
            return detours
        here = detour.end
    return detours


def way_aside(
    blocked: Blocked, floor: Floor, lanes: Sequence[BaseGeometry], parameters: GuidanceParameters
) -> Line | None:
    """The shortest way to a place that is out of the lanes of others, with room enough; None when there is none. The way itself
    may lead along the lanes: the others wait for as long as the robot is before them."""
    space = _space(blocked, floor, [blocked.here], parameters)
    if space is None or not lanes:
        return None
    ways = ShortestWays(space, blocked.here)
    costs = np.where(space.free & ~space.covered(shapely.union_all(lanes)), ways.all_costs, np.inf)
    best = int(np.argmin(costs))
    if not math.isfinite(float(costs.flat[best])):
        return None
    way = straightened(space, ways.way_to(space.centre(best)))
    line = Line([blocked.here, *way[1:]])
    return line if line.length_m > _SAMPLE_M else None


def _may_turn(blocked: Blocked, detours: dict[int, Detour], floor: Floor, parameters: GuidanceParameters) -> bool:
    """Whether nothing stands on the floor that the robot sweeps where it turns on the spot: before it starts, and at every
    bend with `_TURN_BESIDE_M` around it."""
    own = footprint_at(blocked.pose, blocked.spec).buffer(parameters.own_margin_m)
    front_m = Body.of(blocked.spec).front_m
    heading = blocked.pose.yaw
    for detour in detours.values():
        for start, end in pairwise(detour.line.points):
            turn_rad = angle_difference(bearing(start, end), heading)
            if abs(turn_rad) > LITTLE_RAD:
                sweep = swept_by_turning(SE2(*start, heading), turn_rad, blocked.spec)
                if start != blocked.here:
                    sweep = Box(sweep.area.buffer(_TURN_BESIDE_M), sweep.line)
                if nearest_blockage(blocked.spec.id, sweep, own, front_m, floor.grid, floor.robots) is not None:
                    return False
            heading = bearing(start, end)
    return True


def _legs_ahead(blocked: Blocked) -> list[tuple[int, Line]]:
    """The lines of the legs ahead as the operator drew them, the present one from abreast of the robot."""
    plan, leg = blocked.plan, blocked.leg
    legs = [(leg, blocked.follower.route_line(plan, leg, blocked.pose))]
    for following in plan.driven_after(leg)[: _MOST_LEGS - 1]:
        if plan.arrives_at(legs[-1][0]):
            break
        legs.append((following, Line([plan.stops[legs[-1][0]].point, plan.stops[following].point])))
    return legs


def _space(blocked: Blocked, floor: Floor, points: Sequence[Point], parameters: GuidanceParameters) -> FreeSpace | None:
    """The free floor around the robot and the points, None where the grid knows nothing."""
    spots = np.array([blocked.here, *points])
    low, high = spots.min(axis=0) - _ROOM_M, spots.max(axis=0) + _ROOM_M
    body = Body.of(blocked.spec)
    needs = Needs(
        start=blocked.here,
        half_width_m=body.half_width_m,
        clearance_m=max(0.0, blocked.room_m - body.half_width_m),
        own=footprint_at(blocked.pose, blocked.spec).buffer(parameters.own_margin_m),
        unknown=blocked.unknown,
    )
    others = [shape for name, shape in floor.robots.items() if name != blocked.spec.id]
    try:
        bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
        return FreeSpace.around(needs, floor.grid, floor.ground, bounds, others, floor.lanes)
    except ValueError:
        return None


def _back_on(line: Line, place: Point | None, space: FreeSpace, ways: ShortestWays) -> float | None:
    """Where along the leg the cheapest way comes back to it: beyond the place that blocks it, with room there and a little
    further; None where it does not on this leg."""
    marks = np.append(np.arange(0.0, min(line.length_m, _FARTHEST_M), _SAMPLE_M), line.length_m)
    points = [line.at(float(mark)) for mark in marks]
    roomy = space.roomy(points)
    further = int(_CLEAR_AFTER_M / _SAMPLE_M)
    lasting = np.array([roomy[index : index + further].all() for index in range(len(marks))])
    if place is not None and _passes(line, place):
        lasting &= marks > line.locate(place)
    elif place is not None:
        lasting[:-1] = False  # it blocks a later leg: this one is driven to its end
    costs = np.where(lasting, _OFF_ROUTE * ways.costs(points) + (line.length_m - marks), np.inf)
    best = int(np.argmin(costs))
    return float(marks[best]) if math.isfinite(float(costs[best])) else None


def _passes(line: Line, place: Point) -> bool:
    """Whether the line leads past the place, rather than ending before it."""
    return line.locate(place) < line.length_m - _SAMPLE_M


def _within(waypoint: Point, radius_m: float, space: FreeSpace, ways: ShortestWays) -> Point | None:
    """The place with room within a waypoint's radius to which the cheapest way leads, None when none does. On the rim only where
    nothing farther in has room: a robot that rounds the bend there would miss the waypoint."""
    for shares in (_INNER, _RIM):
        points = list(_rings(waypoint, radius_m, shares))
        costs = np.where(space.roomy(points), ways.costs(points), np.inf)
        best = int(np.argmin(costs))
        if math.isfinite(float(costs[best])):
            return points[best]
    return None


def _rings(centre: Point, radius_m: float, shares: Sequence[float]) -> Iterator[Point]:
    for share in shares:
        for step in range(16):
            angle = step * math.pi / 8
            yield centre[0] + share * radius_m * math.cos(angle), centre[1] + share * radius_m * math.sin(angle)
