"""Angles in radians, wrapped to (-pi, pi] as REP-103 has them."""

import math
from collections.abc import Iterable


def wrap_angle(angle_rad: float) -> float:
    """The same direction within (-pi, pi]."""
    wrapped = math.remainder(angle_rad, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def angle_difference(a_rad: float, b_rad: float) -> float:
    """How far to turn from `b_rad` to reach `a_rad`, within (-pi, pi]."""
    return wrap_angle(a_rad - b_rad)


def mean_angle(angles_rad: Iterable[float]) -> float:
    """Circular mean: the direction of the summed unit vectors.

    Raises ValueError when there are no angles or their vectors cancel (no direction is then nearer than another).
    """
    angles = list(angles_rad)
    x = math.fsum(math.cos(angle) for angle in angles)
    y = math.fsum(math.sin(angle) for angle in angles)
    if math.hypot(x, y) < 1e-9 * max(1, len(angles)):
        raise ValueError(f"the mean direction of {len(angles)} angles is undefined")
    return math.atan2(y, x)
