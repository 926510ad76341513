"""What stands in an obstacle box: taken cells of the merged obstacle raster, and other robots where the cameras see them."""

from collections.abc import Iterator, Mapping

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from mapping.grid import FloorGrid
from protocol.channels import POSES
from protocol.lab import VehicleSpec
from protocol.messages import Blockage
from server.guidance.box import Box
from server.guidance.floor_sums import Bounds
from server.guidance.parameters import GuidanceParameters
from server.guidance.snapshot import Snapshot, extrapolated, position_sigma_m


class RobotShapes(Mapping[str, BaseGeometry]):
    """The floor that each robot covers, and which of them are near a place without looking at all."""

    def __init__(self, shapes: Mapping[str, BaseGeometry]) -> None:
        self._shapes = dict(shapes)
        self._names = tuple(self._shapes)
        self._tree = shapely.STRtree(list(self._shapes.values()))

    def near(self, area: BaseGeometry) -> Iterator[tuple[str, BaseGeometry]]:
        """Those that the area touches, in the order of their names' being given."""
        for index in sorted(self._tree.query(area, predicate="intersects")):
            name = self._names[int(index)]
            yield name, self._shapes[name]

    def nobody_near(self, bounds: Bounds, robot: str) -> bool:
        """Whether the rectangle is away from the rectangles around all but one robot."""
        found = self._tree.query(shapely.box(*bounds))
        return all(self._names[int(index)] == robot for index in found)

    def __getitem__(self, name: str) -> BaseGeometry:
        return self._shapes[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._shapes)

    def __len__(self) -> int:
        return len(self._shapes)


def robot_shapes(
    vehicles: Mapping[str, VehicleSpec], snapshot: Snapshot, parameters: GuidanceParameters
) -> RobotShapes:
    """The floor that each robot covers from now until another could have reacted: its outline now and then, joined, and
    widened by three standard deviations of its position. A robot that has not been seen for a while stands where it was."""
    names, corners, owners, margins = list[str](), list[NDArray[np.float64]](), list[int](), list[float]()
    for name, pose in snapshot.poses.items():
        age_s = snapshot.age_s(pose.stamp_ns)
        spec = vehicles.get(name)
        if spec is None or age_s > parameters.forget_robot_s:
            continue
        fresh = age_s <= POSES.stale_after_s
        now = extrapolated(pose, age_s if fresh else 0.0)
        soon = extrapolated(pose, age_s + parameters.reaction_s) if fresh else now
        corners += [now.apply(spec.footprint), soon.apply(spec.footprint)]
        owners += [len(names)] * (2 * len(spec.footprint))
        margins.append(3 * position_sigma_m(pose) + 0.02)
        names.append(name)
    if not names:
        return RobotShapes({})
    hulls = shapely.convex_hull(shapely.multipoints(np.concatenate(corners), indices=np.array(owners)))
    return RobotShapes(dict(zip(names, shapely.buffer(hulls, margins, quad_segs=2), strict=True)))


def nearest_blockage(
    robot: str,
    box: Box,
    own: Polygon,
    front_m: float,
    grid: FloorGrid,
    robots: RobotShapes,
) -> Blockage | None:
    """The nearest thing in the box, by the way along the planned path from the robot's front, which is `front_m` ahead of
    its centre; None when it is clear. What lies within the robot's own (widened) outline `own` is the robot itself."""
    found = [*_on_floor(box, own, front_m, grid), *_robots(robot, box, own, front_m, robots)]
    return min(found, key=lambda blockage: blockage.distance_m, default=None)


def observed_share(area: BaseGeometry, grid: FloorGrid) -> float:
    """The share of an area that cameras see, 0 to 1; 1 of an area so small that hardly a cell's centre lies in it."""
    total = area.area
    if total < 8 * grid.cell_m**2:
        return 1.0
    return sum(grid.look(corners).observed_share * part.area for part, corners in _parts(area)) / total


def _on_floor(box: Box, own: Polygon, front_m: float, grid: FloorGrid) -> Iterator[Blockage]:
    # The grid counts a cell whose centre is inside; a cell that the box only touches is as much of an obstacle.
    widened = box.area.buffer(grid.cell_m / 2, join_style="mitre")
    for _, corners in _parts(widened):
        centres = grid.look(corners).occupied
        foreign = centres[~shapely.contains_xy(own, centres[:, 0], centres[:, 1])] if len(centres) else centres
        if len(foreign):
            yield _nearest(foreign, box.line, front_m, None)


def _robots(robot: str, box: Box, own: Polygon, front_m: float, robots: RobotShapes) -> Iterator[Blockage]:
    for name, shape in robots.near(box.area):
        if name == robot:
            continue
        overlap = box.area.intersection(shape).difference(own)
        if not overlap.is_empty:
            yield _nearest(shapely.get_coordinates(overlap), box.line, front_m, name)


def _nearest(points: NDArray[np.float64], line: LineString, front_m: float, robot: str | None) -> Blockage:
    where = shapely.points(points)
    along = np.asarray(shapely.line_locate_point(line, where))
    # Of what is about equally far ahead, what is nearest to the path is named.
    index = int(np.argmin(along + 0.1 * np.asarray(shapely.distance(line, where))))
    return Blockage(
        x=round(float(points[index, 0]), 3),
        y=round(float(points[index, 1]), 3),
        distance_m=round(max(0.0, float(along[index]) - front_m), 3),
        robot=robot,
    )


def _parts(area: BaseGeometry) -> Iterator[tuple[Polygon, NDArray[np.float64]]]:
    """The polygons of an area with their corners (N, 2)."""
    for part in shapely.get_parts(area):
        if isinstance(part, Polygon) and part.area > 0:
            yield part, np.asarray(part.exterior.coords[:-1], dtype=np.float64)
