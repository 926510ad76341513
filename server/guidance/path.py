"""Plane geometry of paths: segments and polylines in metres, map frame. Pure functions over (x, y) pairs."""

import itertools
import math
from collections.abc import Sequence

Point = tuple[float, float]
_NEGLIGIBLE_M = 1e-6


def distance(a: Point, b: Point) -> float:
    """Metres between two points."""
    return math.hypot(b[0] - a[0], b[1] - a[1])


def bearing(a: Point, b: Point) -> float:
    """Direction from `a` to `b` (rad)."""
    return math.atan2(b[1] - a[1], b[0] - a[0])


def progress_along(point: Point, start: Point, end: Point) -> float:
    """Metres from `start` to the foot of `point` on the segment, within 0 .. length."""
    length = distance(start, end)
    if length < _NEGLIGIBLE_M:
        return 0.0
    dot = (point[0] - start[0]) * (end[0] - start[0]) + (point[1] - start[1]) * (end[1] - start[1])
    return min(length, max(0.0, dot / length))


def point_along(start: Point, end: Point, metres: float) -> Point:
    """The point `metres` from `start` towards `end`, also beyond it; `start` when the two coincide."""
    length = distance(start, end)
    if length < _NEGLIGIBLE_M:
        return start
    share = metres / length
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


def closest_approach(start: Point, end: Point, point: Point) -> float:
    """The least distance from `point` to the segment, in metres."""
    return distance(point, point_along(start, end, progress_along(point, start, end)))


def polyline_length(points: Sequence[Point]) -> float:
    """Metres along the points."""
    return sum(distance(a, b) for a, b in itertools.pairwise(points))


def without_repeats(points: Sequence[Point]) -> list[Point]:
    """The points without those that coincide with the one before."""
    kept: list[Point] = []
    for point in points:
        if not kept or distance(kept[-1], point) > _NEGLIGIBLE_M:
            kept.append(point)
    return kept


def prolonged(points: Sequence[Point], length: float, heading_rad: float) -> list[Point]:
    """The polyline, run on straight until it is at least `length` long; a single point runs on along `heading_rad`."""
    path = without_repeats(points)
    missing = length - polyline_length(path)
    if missing > _NEGLIGIBLE_M:
        if len(path) > 1:
            heading_rad = bearing(path[-2], path[-1])
        x, y = path[-1]
        path.append((x + missing * math.cos(heading_rad), y + missing * math.sin(heading_rad)))
    return path
