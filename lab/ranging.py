"""The infrared sensor at a vehicle's front: one ray against the outlines of what stands around."""

import math
from collections.abc import Iterable

from shapely.geometry import LineString, Point, Polygon

from geometry import SE2

RANGE_MIN_M = 0.2
"""Nearer things read as this."""
RANGE_MAX_M = 1.5
"""Farther things are not seen."""
_RELATIVE_NOISE = 0.01


def front_range_m(pose: SE2, front_m: float, outlines: Iterable[Polygon], noise: float) -> float | None:
    """Distance (m) along the heading from the front of the vehicle, `front_m` ahead of its rotation centre, to the nearest
    outline; None when nothing stands within `RANGE_MAX_M`. `noise` is a standard normal draw."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    origin = Point(pose.x + front_m * c, pose.y + front_m * s)
    ray = LineString([origin, (origin.x + RANGE_MAX_M * c, origin.y + RANGE_MAX_M * s)])
    hits = [origin.distance(ray.intersection(outline)) for outline in outlines if ray.intersects(outline)]
    if not hits:
        return None
    measured = min(hits) * (1.0 + _RELATIVE_NOISE * noise)
    return min(max(measured, RANGE_MIN_M), RANGE_MAX_M)
