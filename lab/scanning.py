"""The simulated safety scanner: every beam against the outlines of what stands around, all at once.

A beam at bearing phi meets the segment from A to A + e (scanner's frame, d = (cos phi, sin phi)) at the range
r = (A x e) / (d x e) and the share t = (A x d) / (d x e) of the segment, if r >= 0 and 0 <= t <= 1. One turn is one instant.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from protocol.lab import ScannerSpec, SimulatedScanner

Floats = NDArray[np.float64]
_PARALLEL = 1e-12


def outline_segments(outline: Floats) -> Floats:
    """The edges (N, 4) as x, y of their start and x, y of their end of a closed outline (N, 2)."""
    return np.hstack((outline, np.roll(outline, -1, axis=0)))


def line_segments(lines: Iterable[Sequence[tuple[float, float]]]) -> Floats:
    """The segments (N, 4) of open lines of points, as in `outline_segments`."""
    pieces = [np.hstack((np.asarray(line[:-1], float), np.asarray(line[1:], float))) for line in lines]
    return np.vstack(pieces) if pieces else np.empty((0, 4))


class SimulatedScannerHead:
    """One vehicle's scanner; its chance is its own, so that scanning changes nothing else."""

    def __init__(self, spec: ScannerSpec, faults: SimulatedScanner, rng: np.random.Generator) -> None:
        self.spec = spec
        self._faults, self._rng = faults, rng
        self._T_vehicle_scanner = SE2(*spec.pose)
        bearings = spec.angle_min_rad + spec.angle_increment_rad * np.arange(spec.beams)
        self._cos, self._sin = np.cos(bearings), np.sin(bearings)

    def reach_m(self) -> float:
        """How far from the vehicle's rotation centre anything may be seen."""
        return self.spec.range_m + float(np.hypot(*self.spec.pose[:2]))

    def turn(self, pose: SE2, segments: Floats) -> bytes:
        """One turn of the scanner of a vehicle at `pose` among segments (N, 4) in the map frame (m): two bytes per beam, as in
        `Scan.ranges_mm`."""
        spec, faults = self.spec, self._faults
        ranges = self._ranges(pose @ self._T_vehicle_scanner, segments)
        ranges += faults.noise_m * self._rng.standard_normal(spec.beams)
        dice = self._rng.random((2, spec.beams))
        false = dice[1] < faults.false_echoes
        if false.any():
            ranges[false] = np.minimum(ranges[false], self._rng.uniform(0.0, spec.range_m, int(false.sum())))
        echo = (ranges >= spec.range_min_m) & (ranges <= spec.range_m) & (false | (dice[0] >= faults.missed))
        return np.where(echo, np.round(ranges * 1e3), 0.0).astype(">u2").tobytes()

    def _ranges(self, T_map_scanner: SE2, segments: Floats) -> Floats:
        """The true range of every beam (m), infinite where nothing is."""
        if not len(segments):
            return np.full(self.spec.beams, np.inf)
        inverse = T_map_scanner.inverse()
        start, end = inverse.apply(segments[:, :2]), inverse.apply(segments[:, 2:])
        ax, ay = start[:, 0, None], start[:, 1, None]
        ex, ey = end[:, 0, None] - ax, end[:, 1, None] - ay
        across = self._cos * ey - self._sin * ex
        parallel = np.abs(across) < _PARALLEL
        divisor = np.where(parallel, 1.0, across)
        share = (ax * self._sin - ay * self._cos) / divisor
        ranges = (ax * ey - ay * ex) / divisor
        hit = ~parallel & (share >= 0.0) & (share <= 1.0) & (ranges >= 0.0)
        return np.min(np.where(hit, ranges, np.inf), axis=0)
