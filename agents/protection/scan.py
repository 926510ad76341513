"""One turn of a laser scanner as the robot sees it, whichever driver it comes from, and which of its echoes are things."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from geometry import SE2

Floats = NDArray[np.float64]
_SIDE_BY_SIDE_M = 0.15
"""Echoes of neighbouring beams that are this near to one another are of one thing."""
_SAME_PLACE_M = 0.15
"""An echo this near to one of the turn before is of the same thing, whatever robot and thing did in the meantime."""


@dataclass(frozen=True, slots=True, eq=False)
class RangeScan:
    """The echoes of one turn: `points` (N, 2) in the robot's frame (m, x forward, y left), in the order of the beams, whose
    numbers are `beams` (N,)."""

    stamp_ns: int
    points: Floats
    beams: NDArray[np.int64]

    @classmethod
    def polar(
        cls,
        stamp_ns: int,
        ranges_m: Floats,
        *,
        angle_min: float,
        angle_increment: float,
        range_min_m: float,
        range_max_m: float,
        T_robot_scanner: SE2,
    ) -> Self:
        """From the range of every beam. What is nearer than the scanner can measure (REP 117: minus infinity; some tell their
        guess) is an echo as near as it can: whoever steps right up to the scanner has not gone. 0, infinity, what is no number
        and what is beyond the scanner's reach say nothing."""
        nearer = (ranges_m == -np.inf) | ((ranges_m > 0.0) & (ranges_m < range_min_m))
        measured = np.where(nearer, range_min_m, ranges_m)
        beams = np.flatnonzero(nearer | ((measured > 0.0) & (measured >= range_min_m) & (measured <= range_max_m)))
        bearings, ranges = angle_min + angle_increment * beams, measured[beams]
        points = np.column_stack((ranges * np.cos(bearings), ranges * np.sin(bearings)))
        return cls(stamp_ns, T_robot_scanner.apply(points), beams)


class EchoFilter:
    """Tells things from single false echoes (dust, glints): `neighbours` beams with echoes side by side are a thing at once,
    fewer are one when the turn before had an echo in the same place. A beam without an echo between two is passed over."""

    def __init__(self, neighbours: int) -> None:
        self._neighbours = neighbours
        self._before = np.empty((0, 2))

    def solid(self, scan: RangeScan) -> Floats:
        """The points (M, 2) of things."""
        points = scan.points
        if not len(points):
            self._before = points
            return points
        solid = self._side_by_side(scan)
        lonely = np.flatnonzero(~solid)
        if len(lonely) and len(self._before):
            away = points[lonely, None, :] - self._before[None, :, :]
            solid[lonely] = np.min(np.sum(away**2, axis=2), axis=1) <= _SAME_PLACE_M**2
        self._before = points
        return points[solid]

    def _side_by_side(self, scan: RangeScan) -> NDArray[np.bool_]:
        """Which echoes belong to a run of so many neighbours."""
        step = np.hypot(*np.diff(scan.points, axis=0).T) <= _SIDE_BY_SIDE_M
        joined = step & (np.diff(scan.beams) <= 2)
        run = np.concatenate(([0], np.cumsum(~joined)))
        return np.bincount(run)[run] >= self._neighbours
