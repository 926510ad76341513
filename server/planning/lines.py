"""From a chain of cells to a line that a robot can drive: straight pieces between as few bends as the free floor allows."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from server.planning.free_space import FreeSpace

Point = tuple[float, float]


def straightened(space: FreeSpace, way: Sequence[Point]) -> list[Point]:
    """The way with every stretch pulled straight that keeps as much clearance as the stretch did (beyond what is required, no
    more is asked for): from its beginning, and once more from its end. The ends stay."""
    if len(way) < 3:
        return list(way)
    forth = _pulled(space, way)
    return _pulled(space, _dense(forth, space.cell_m)[::-1])[::-1]


def _pulled(space: FreeSpace, way: Sequence[Point]) -> list[Point]:
    clearance = space.clearance_at(way)
    enough = space.required_m + space.cell_m
    kept, at = [way[0]], 0
    while at < len(way) - 1:
        at = _farthest_straight(space, way, clearance, at, enough)
        kept.append(way[at])
    return kept


def _dense(way: Sequence[Point], step_m: float) -> list[Point]:
    """The way with points every so many metres."""
    points = [way[0]]
    for (ax, ay), (bx, by) in itertools.pairwise(way):
        steps = max(1, math.ceil(math.hypot(bx - ax, by - ay) / step_m))
        points += [(ax + (bx - ax) * i / steps, ay + (by - ay) * i / steps) for i in range(1, steps + 1)]
    return points


def _farthest_straight(
    space: FreeSpace, way: Sequence[Point], clearance: NDArray[np.float64], at: int, enough: float
) -> int:
    """The last point that the one at `at` may be joined to: probed ever farther, and then between the last two probes."""
    good, step = at + 1, 2
    while at + step < len(way) and _straight(space, way, clearance, at, at + step, enough):
        good, step = at + step, step * 2
    bad = min(at + step, len(way))
    while bad - good > 1:
        middle = (good + bad) // 2
        if _straight(space, way, clearance, at, middle, enough):
            good = middle
        else:
            bad = middle
    return good


def _straight(
    space: FreeSpace, way: Sequence[Point], clearance: NDArray[np.float64], first: int, last: int, enough: float
) -> bool:
    """Whether the straight line between two points of the way is allowed, and no tighter than the way between them."""
    a, b = np.array(way[first]), np.array(way[last])
    steps = max(2, int(np.ceil(np.hypot(*(b - a)) / (space.cell_m / 2))) + 1)
    points = a + np.linspace(0.0, 1.0, steps)[:, None] * (b - a)
    least = min(enough, float(clearance[first : last + 1].min()))
    return bool(space.allows(points).all() and (space.clearance_at(points) >= least - 1e-9).all())
