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

import math
from collections.abc import Sequence
from dataclasses import dataclass

import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import substring, unary_union

from geometry import SE2
from protocol.lab import ObstacleBox, VehicleSpec
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point, prolonged

_MOVING_MPS = 0.05
_SHORTEST_M = 0.01


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
        ahead = body.front_m + stopping
        tip = (pose.x + ahead * math.cos(pose.yaw), pose.y + ahead * math.sin(pose.yaw))
        parts.append(LineString([(pose.x, pose.y), tip]).buffer(body.half_width_m, cap_style="flat"))
    present = [part for part in parts if not part.is_empty]
    return Box(unary_union(present) if present else Polygon(), line)


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
