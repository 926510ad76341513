"""What is left behind across a robot's route in the detours of the obstacles experiment, and whether there is a way past it.

The way is looked for in the truth, by exact geometry, apart from any grid: the floor on which the rotation centre may be is the
area without a margin of half the robot's width, less everything that stands on it widened by that and the clearance. A way leads
from one place to another when both are in the same piece of it.
"""

import math
from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Point as ShapelyPoint
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from geometry import SE2
from lab.objects import PlacedObject
from launcher.experiments.obstacle_scenes import Point, Scene
from protocol.lab import Lab, VehicleSpec
from protocol.messages import SimulatedObject

CLEARANCE_M = 0.3
_ALONE, _OPEN = 0.25, 0.3
"""The share of scenes with one pallet only, and of sides of a row that do not go on to the border after any pallet."""
_CLOSED_M, _GAP_M = (0.05, 0.6), (0.75, 1.4)
"""Between two pallets of a row: far too little, or about what a robot needs with its clearance (0.92 m)."""
_STEP_M = 0.01
_ASKEW_RAD = 0.3
_FROM_ROBOT_M = 0.1
"""How much more than its clearance nothing comes nearer to the robot's centre, so that it starts on free floor."""
_SEGMENTS = 16


def left_behind(scene: Scene, lab: Lab, here: SE2, speed_mps: float) -> list[SimulatedObject]:
    """The scene's pallet on the path of a robot that is `here` and, in most scenes, a row of more across it, from border to
    border or not, with gaps between them."""
    first, _, _ = scene.place(here, speed_mps)
    rng = np.random.default_rng([scene.seed, 77])
    if rng.random() < _ALONE:
        return [first]
    area = Polygon(lab.areas[0].outline)
    across = first.yaw - scene.yaw + math.pi / 2
    keep_m = half_width_m(scene.vehicle) + CLEARANCE_M + _FROM_ROBOT_M
    items = [first]
    for side in (1.0, -1.0):
        last, offset_m = first, 0.0
        while rng.random() >= _OPEN:
            gap_m = float(rng.uniform(*(_GAP_M if rng.random() < 0.5 else _CLOSED_M)))
            yaw = across + float(rng.uniform(-_ASKEW_RAD, _ASKEW_RAD))
            offset_m = _next_offset(first, last, across, side, offset_m, gap_m, yaw)
            last = _pallet(f"thing-{len(items)}", first, across, side * offset_m, yaw)
            outline = outline_of(last)
            if not area.intersects(outline):
                break
            if outline.distance(ShapelyPoint(here.x, here.y)) >= keep_m:
                items.append(last)
    return items


def way_exists(
    lab: Lab, vehicle: VehicleSpec, here: SE2, stops: Sequence[tuple[Point, float]], things: Sequence[Polygon]
) -> bool:
    """Whether there is a way with clearance from `here` over the stops (points with the radius, m, within which they count; the
    last one itself)."""
    half_m = half_width_m(vehicle)
    ground = shapely.union_all([Polygon(area.outline) for area in lab.areas]).buffer(-half_m, join_style="mitre")
    # Circles as polygons around them: no gap seems wider than it is.
    radius_m = (half_m + CLEARANCE_M) / math.cos(math.pi / (4 * _SEGMENTS))
    free: BaseGeometry = ground.difference(shapely.union_all([t.buffer(radius_m, quad_segs=_SEGMENTS) for t in things]))
    pieces = [piece for piece in shapely.get_parts(free) if piece.covers(ShapelyPoint(here.x, here.y))]
    if not pieces:
        return False
    *between, (goal, _) = stops
    there = pieces[0].covers(ShapelyPoint(goal))
    return there and all(pieces[0].distance(ShapelyPoint(point)) <= radius for point, radius in between)


def outline_of(item: SimulatedObject) -> Polygon:
    """Its outline on the map (m)."""
    placed = PlacedObject(item)
    return placed.footprint_at(placed.pose)


def half_width_m(vehicle: VehicleSpec) -> float:
    return max(abs(y) for _, y in vehicle.footprint)


def _next_offset(
    first: SimulatedObject, last: SimulatedObject, across: float, side: float, offset_m: float, gap_m: float, yaw: float
) -> float:
    """How far along the row from the first pallet the next one lies, so that the gap to the last one is that wide."""
    before = outline_of(last)
    while outline_of(_pallet("", first, across, side * offset_m, yaw)).distance(before) < gap_m:
        offset_m += _STEP_M
    return offset_m


def _pallet(name: str, first: SimulatedObject, across: float, offset_m: float, yaw: float) -> SimulatedObject:
    x, y = first.x + offset_m * math.cos(across), first.y + offset_m * math.sin(across)
    return SimulatedObject(id=name or "thing", kind="pallet", x=x, y=y, yaw=yaw)
