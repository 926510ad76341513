"""The obstacle box (spec gpss, "The operator's side"): the floor that must be free for a robot to drive on.

It is a band of the operator's width, though never narrower than the robot, swept along the planned path. Its far end is

    reach = max(start + length, front + clearance + v t + v^2 / (2 a))

measured along the path from the robot's rotation centre: the operator's length is the least, and a robot with its front
`front` ahead of its centre that drives at the commanded speed v, notices an obstacle after the reaction time t and brakes
with a, stands still `clearance` before it. The *commanded* speed counts, not the present one: else the box would shrink
around a waiting robot and let it creep forward. Two more parts belong to it: between the robot and the start of the band
a corridor as wide as the robot's body, and straight ahead of a moving robot the floor that it cannot help covering before
it stands, as on the outside of a bend.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import substring, unary_union

from geometry import SE2, angle_difference
from protocol.lab import ObstacleBox, VehicleSpec
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point, bearing, distance, point_along, prolonged

_MOVING_MPS = 0.05
_SHORTEST_M = 0.01
_STRAIGHT_RAD = 1e-3
_ALIGNED_RAD = 0.05


@dataclass(frozen=True, slots=True)
class Body:
    """The robot's measures that the box depends on: how far its front and sides are from its rotation centre (m)."""

    front_m: float
    half_width_m: float

    @classmethod
    def of(cls, spec: VehicleSpec) -> "Body":
        return cls(max(x for x, _ in spec.footprint), max(abs(y) for _, y in spec.footprint))


@dataclass(frozen=True, slots=True)
class PlannedPath:
    """Where a robot is to drive: from its rotation centre over the waypoints ahead; `to_waypoint_m` is the way along it to
    the next waypoint."""

    points: Sequence[Point]
    to_waypoint_m: float


@dataclass(frozen=True, slots=True)
class Box:
    """The box as an area in the map frame, and the part of the planned path that it was swept along."""

    area: BaseGeometry
    line: LineString


def reach_m(size: ObstacleBox, spec: VehicleSpec, speed_mps: float, parameters: GuidanceParameters) -> float:
    """How far along the path from the rotation centre the box must reach; see the module for the formula."""
    stopping = speed_mps * parameters.reaction_s + speed_mps**2 / (2 * spec.limits.braking_mps2)
    return max(size.start_m + size.length_m, Body.of(spec).front_m + parameters.clearance_m + stopping)


@dataclass(frozen=True, slots=True)
class BoxRequest:
    """What an obstacle box follows from: the robot's pose, its path, the operator's measures, the set-point `commanded_mps` and
    the speed along its heading `present_mps`. Its area is a matter of polygons; where it lies at all, and what it looks like
    on a straight way, are not."""

    pose: SE2
    path: PlannedPath
    size: ObstacleBox
    spec: VehicleSpec
    commanded_mps: float
    present_mps: float
    parameters: GuidanceParameters

    @property
    def reach_m(self) -> float:
        return reach_m(self.size, self.spec, self.commanded_mps, self.parameters)

    def box(self) -> Box:
        """The box itself."""
        return obstacle_box(
            self.pose, self.path, self.size, self.spec, self.commanded_mps, self.present_mps, self.parameters
        )

    def bounds(self) -> tuple[float, float, float, float]:
        """A rectangle (min x, min y, max x, max y) that the box does not leave, whatever its shape."""
        body = Body.of(self.spec)
        half = max(body.half_width_m, self.size.width_m / 2)
        reach = self.reach_m + self.size.width_m
        points = self._ahead(reach)
        if self.present_mps > _MOVING_MPS:
            points.append(_straight_on(self.pose, body.front_m + self._stopping_m))
        xs, ys = [x for x, _ in points], [y for _, y in points]
        return min(xs) - half, min(ys) - half, max(xs) + half, max(ys) + half

    def outline(self) -> tuple[Point, ...]:
        """For drawing, rounded to millimetres. On a straight way the few centimetres that the floor straight ahead of a robot
        which is not quite aligned adds are left out."""
        points = self._ahead(self.reach_m)
        straight = len(points) == 2
        if not straight or abs(angle_difference(bearing(*points), self.pose.yaw)) > _ALIGNED_RAD:
            return outline(self.box().area)
        body = Body.of(self.spec)
        end = min(self.reach_m, self.path.to_waypoint_m) if self.size.stop_at_waypoint else self.reach_m
        start = min(self.size.start_m, end)
        near, far = body.half_width_m, max(body.half_width_m, self.size.width_m / 2)
        side = [(0.0, near), (start, near), (start, far), (end, far)]
        turn = SE2(*points[0], bearing(*points))
        corners = turn.apply([*((x, -y) for x, y in side), *reversed(side)])
        return tuple((round(float(x), 3), round(float(y), 3)) for x, y in corners)

    @property
    def _stopping_m(self) -> float:
        speed = self.present_mps
        return speed * self.parameters.reaction_s + speed**2 / (2 * self.spec.limits.braking_mps2)

    def _ahead(self, length_m: float) -> list[Point]:
        """The path as far as that, run on straight where it ends before."""
        points = prolonged(self.path.points, length_m, self.pose.yaw)
        ahead, left = [points[0]], length_m
        for a, b in itertools.pairwise(points):
            step = distance(a, b)
            if step >= left:
                ahead.append(point_along(a, b, left))
                break
            ahead.append(b)
            left -= step
        return _without_straight_points(ahead)


def obstacle_box(
    pose: SE2,
    path: PlannedPath,
    size: ObstacleBox,
    spec: VehicleSpec,
    commanded_mps: float,
    present_mps: float,
    parameters: GuidanceParameters,
) -> Box:
    """The box of a robot at `pose`; `present_mps` is the speed along its heading, `commanded_mps` the set-point."""
    body = Body.of(spec)
    reach = reach_m(size, spec, commanded_mps, parameters)
    end = min(reach, path.to_waypoint_m) if size.stop_at_waypoint else reach
    whole = LineString(prolonged(path.points, reach + size.width_m, pose.yaw))
    line = _part(whole, 0.0, reach + size.width_m)
    start = min(size.start_m, end)
    parts = [
        _swept(line, start, end, max(body.half_width_m, size.width_m / 2)),
        _swept(line, 0.0, start, body.half_width_m),
    ]
    if present_mps > _MOVING_MPS:
        stopping = present_mps * parameters.reaction_s + present_mps**2 / (2 * spec.limits.braking_mps2)
        tip = _straight_on(pose, body.front_m + stopping)
        parts.append(LineString([(pose.x, pose.y), tip]).buffer(body.half_width_m, cap_style="flat"))
    present = [part for part in parts if not part.is_empty]
    return Box(unary_union(present) if present else Polygon(), line)


def _straight_on(pose: SE2, metres: float) -> Point:
    return pose.x + metres * math.cos(pose.yaw), pose.y + metres * math.sin(pose.yaw)


def _without_straight_points(points: Sequence[Point]) -> list[Point]:
    """The line without points at which it does not bend."""
    kept = list(points[:1])
    for index in range(1, len(points) - 1):
        before, here, after = kept[-1], points[index], points[index + 1]
        if abs(angle_difference(bearing(here, after), bearing(before, here))) > _STRAIGHT_RAD:
            kept.append(here)
    return [*kept, *points[1:][-1:]]


def footprint_at(pose: SE2, spec: VehicleSpec) -> Polygon:
    """The robot's outline on the floor, map frame."""
    return Polygon(pose.apply(spec.footprint))


def outline(area: BaseGeometry) -> tuple[Point, ...]:
    """The outer border of the box for drawing; of its largest part should it have several. Rounded to millimetres."""
    polygons = [part for part in shapely.get_parts(area) if isinstance(part, Polygon) and not part.is_empty]
    if not polygons:
        return ()
    largest = max(polygons, key=lambda polygon: polygon.area)
    simple = largest.simplify(0.005)
    border = simple.exterior if isinstance(simple, Polygon) else largest.exterior
    return tuple((round(x, 3), round(y, 3)) for x, y in border.coords[:-1])


def _swept(line: LineString, start: float, end: float, half_width: float) -> BaseGeometry:
    """The band of twice `half_width` along the part of the line between two distances."""
    if end - start < _SHORTEST_M:
        return Polygon()
    return _part(line, start, end).buffer(half_width, cap_style="flat", join_style="round", quad_segs=4)


def _part(line: LineString, start: float, end: float) -> LineString:
    part = substring(line, start, end)
    assert isinstance(part, LineString)  # a Point only comes of start == end
    return part
