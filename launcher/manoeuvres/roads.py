"""The floors of the scenes: lanes of 0.5 m, right-hand traffic, in metres around the middle of each scene.

The reports show their roads in pictures without coordinates; these are laid out after their descriptions (docs/manoeuvres.md says
how), for vehicles 0.30 m long and 0.32 m wide.
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from protocol.lab import ZoneSpec

LANE_M = 0.5
ARM_M = 4.0
DETECTION_M = 3.0
Points: TypeAlias = tuple[tuple[float, float], ...]

ARMS = ("south", "east", "north", "west")
"""Counter-clockwise: from the south the right turn goes east, straight on north, the left turn west."""


def crossing_zone(middle: tuple[float, float] = (0.0, 0.0), name: str = "crossing") -> ZoneSpec:
    """Two roads of one lane each way: four sub-areas of a lane's width, named by the compass."""
    x, y = middle
    return ZoneSpec(
        id=name,
        detection_m=DETECTION_M,
        subareas={
            "sw": _box(x - LANE_M, y - LANE_M, x, y),
            "se": _box(x, y - LANE_M, x + LANE_M, y),
            "ne": _box(x, y, x + LANE_M, y + LANE_M),
            "nw": _box(x - LANE_M, y, x, y + LANE_M),
        },
    )


def crossing_way(arm: str, turn: str, lanes: int = 1, lane: int = 0) -> Points:
    """From an arm of the crossing in the middle, `right`, `straight` or `left`. `lane` counts from the road's middle."""
    inner_m = LANE_M * lanes
    offset_m = LANE_M * (lane + 0.5)
    start = (offset_m, -ARM_M)
    if turn == "straight":
        points: list[tuple[float, float]] = [start, (offset_m, ARM_M)]
    elif turn == "right":
        points = [start, *_arc((inner_m, -inner_m), inner_m - offset_m, math.pi, math.pi / 2), (ARM_M, -offset_m)]
    elif turn == "left":
        points = [start, *_arc((-inner_m, -inner_m), inner_m + offset_m, 0.0, math.pi / 2), (-ARM_M, offset_m)]
    else:
        raise ValueError(f"a vehicle turns right, left or goes straight, not {turn!r}")
    return _turned(points, ARMS.index(arm) * math.pi / 2)


def wide_crossing_zone() -> ZoneSpec:
    """Two roads of two lanes each way: sixteen sub-areas."""
    cells = {
        f"c{column}r{row}": _box((column - 2) * LANE_M, (row - 2) * LANE_M, (column - 1) * LANE_M, (row - 1) * LANE_M)
        for column in range(4)
        for row in range(4)
    }
    return ZoneSpec(id="wide-crossing", detection_m=DETECTION_M + LANE_M, subareas=cells)


MERGE_M = 1.5
"""Length of the merge's zone along the main road, which is the least distance it leaves between two vehicles (Gulliver 2025,
3.2); it begins where two bodies side by side on the two lanes would touch."""


def merge_zone() -> ZoneSpec:
    """Where the ramp comes onto the main road (which runs along y = 0 towards +x): its mouth."""
    return ZoneSpec(id="merge", detection_m=6.0, subareas={"mouth": _box(0.3 - MERGE_M, -LANE_M / 2, 0.3, LANE_M / 2)})


def main_way() -> Points:
    """The main road, from 7 m before the merge's middle to 5 m behind it."""
    return ((-7.0, 0.0), (5.0, 0.0))


def ramp_way() -> Points:
    """The ramp: comes at 30 degrees from the right, bends onto the main road in the merge."""
    angle = math.radians(30)
    radius = 1.2
    bend = radius * math.tan(angle / 2)
    start = (-7.0 * math.cos(angle), -7.0 * math.sin(angle))
    return (start, *_arc((bend, -radius), radius, math.pi / 2 + angle, math.pi / 2), (5.0, 0.0))


RING_M = 1.0
"""Radius of the roundabout's lane."""


_ARM_OFFSET_M, _ENTRY_RAD = 0.42, 0.6
"""Of a roundabout's arms: a lane's distance from the arm's middle, and where it meets the ring, from that middle."""


def roundabout_zones() -> tuple[ZoneSpec, ...]:
    """A ring with four arms; before each arm's entry the stretch of the ring where it comes in."""
    zones: list[ZoneSpec] = []
    for index, arm in enumerate(ARMS):
        angle = index * math.pi / 2 - math.pi / 2
        first, last = angle + 0.1, angle + 1.15
        inner, outer = RING_M - LANE_M / 2, RING_M + LANE_M / 2
        turns = np.linspace(first, last, 9)
        outline = [(inner * math.cos(a), inner * math.sin(a)) for a in turns]
        outline += [(outer * math.cos(a), outer * math.sin(a)) for a in turns[::-1]]
        zones.append(ZoneSpec(id=f"entry-{arm}", detection_m=DETECTION_M, subareas={"entry": tuple(outline)}))
    return tuple(zones)


def roundabout_way(arm: str, exits: int) -> Points:
    """In at an arm, counter-clockwise around the ring, out at the `exits`-th arm (1: the next to the right; 4: where it came
    from)."""
    if not 1 <= exits <= 4:
        raise ValueError(f"a roundabout of four arms has exits 1 to 4, not {exits}")
    offset = _ARM_OFFSET_M
    entry = _ENTRY_RAD
    radius = RING_M
    first = -math.pi / 2 + entry
    last = -math.pi / 2 + exits * math.pi / 2 - entry
    came = _blend((offset, -2.0), (0.0, 1.0), _on_ring(first), _along_ring(first))
    ring = [_on_ring(a, radius) for a in np.linspace(first, last, max(4, round((last - first) / 0.1)))]
    out_turn = exits * math.pi / 2
    leaving = _turned(((-offset, -2.0),), out_turn)[0]
    direction = _turned(((0.0, -1.0),), out_turn)[0]
    left = _blend(_on_ring(last), _along_ring(last), leaving, direction)
    end = (leaving[0] + 2 * direction[0], leaving[1] + 2 * direction[1])
    points = [(offset, -ARM_M), *came, *ring[1:-1], *left, end]
    return _turned(points, ARMS.index(arm) * math.pi / 2)


CHAIN_M = 3.0
"""Between the middles of the chain's crossings."""


def chain_zones() -> tuple[ZoneSpec, ...]:
    """Three crossings in a row along x."""
    return tuple(crossing_zone((x, 0.0), f"crossing-{i}") for i, x in enumerate((-CHAIN_M, 0.0, CHAIN_M)))


def chain_way(kind: str) -> Points:
    """`east` and `west`: along all three. `north-i`, `south-i`: across the i-th one. `zigzag`: comes from the south at the
    first, goes along to the second and leaves to the north at the third."""
    half, reach = LANE_M / 2, CHAIN_M + ARM_M
    if kind in ("east", "west"):
        return ((-reach, -half), (reach, -half)) if kind == "east" else ((reach, half), (-reach, half))
    if kind == "zigzag":
        right = _arc((-CHAIN_M + LANE_M, -LANE_M), half, math.pi, math.pi / 2)
        left = _arc((CHAIN_M - LANE_M, LANE_M), LANE_M + half, -math.pi / 2, 0.0)
        return ((-CHAIN_M + half, -ARM_M), *right, *left, (CHAIN_M + half, ARM_M))
    direction, _, index = kind.partition("-")
    x = (int(index) - 1) * CHAIN_M
    return ((x + half, -ARM_M), (x + half, ARM_M)) if direction == "north" else ((x - half, ARM_M), (x - half, -ARM_M))


def _box(left: float, low: float, right: float, high: float) -> Points:
    return ((left, low), (right, low), (right, high), (left, high))


def _arc(centre: tuple[float, float], radius: float, first: float, last: float) -> list[tuple[float, float]]:
    turns = np.linspace(first, last, max(3, round(abs(last - first) / 0.1)))
    return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in turns]


def _turned(points: Points | list[tuple[float, float]], angle: float) -> Points:
    cos, sin = math.cos(angle), math.sin(angle)
    return tuple((cos * x - sin * y, sin * x + cos * y) for x, y in points)


def _on_ring(angle: float, radius: float = RING_M) -> tuple[float, float]:
    return radius * math.cos(angle), radius * math.sin(angle)


def _along_ring(angle: float) -> tuple[float, float]:
    return -math.sin(angle), math.cos(angle)


def _blend(
    start: tuple[float, float],
    direction: tuple[float, float],
    end: tuple[float, float],
    end_direction: tuple[float, float],
) -> list[tuple[float, float]]:
    """A cubic Hermite curve from one point and direction to another."""
    p, q = np.array(start), np.array(end)
    reach = float(np.hypot(*(q - p)))
    m, n = np.array(direction) * reach, np.array(end_direction) * reach
    t: NDArray[np.float64] = np.linspace(0.0, 1.0, 12)[:, None]
    curve = (2 * t**3 - 3 * t**2 + 1) * p + (t**3 - 2 * t**2 + t) * m + (3 * t**2 - 2 * t**3) * q + (t**3 - t**2) * n
    return [(float(x), float(y)) for x, y in curve]
