"""The walls of the simulated room: lines that scanners see and that nobody passes."""

import math
from collections.abc import Sequence

import numpy as np
from shapely.geometry import MultiLineString
from shapely.geometry.base import BaseGeometry

from geometry import SE2
from lab.contacts import Body
from lab.scanning import line_segments

WALL = "(wall)"
"""Their name among the bodies that touch one another; no vehicle or object can be called so."""


class Walls:
    """All walls as one body, which reaches everywhere."""

    pose = SE2.identity()
    radius_m = math.inf

    def __init__(self, lines: Sequence[Sequence[tuple[float, float]]]) -> None:
        self.segments = line_segments(lines)
        self._lines = MultiLineString([list(line) for line in lines])
        self._along = self.segments[:, 2:] - self.segments[:, :2]
        self._squares = np.maximum(np.sum(self._along**2, axis=1), 1e-12)

    def footprint_at(self, pose: SE2) -> BaseGeometry:  # noqa: ARG002  # walls do not move
        """The lines on the map."""
        return self._lines

    def distance_m(self, x: float, y: float) -> float:
        """From a point to the nearest wall; infinite where there is none."""
        if not len(self.segments):
            return math.inf
        away = np.array((x, y)) - self.segments[:, :2]
        share = np.clip(np.sum(away * self._along, axis=1) / self._squares, 0.0, 1.0)
        return float(np.min(np.hypot(*(away - share[:, None] * self._along).T)))

    def block(self, body: Body, pose: SE2) -> bool:
        """Whether a wall keeps `body` from moving to `pose`: it would stand in one and not farther from it than now."""
        distance_m = self.distance_m(pose.x, pose.y)
        if distance_m >= body.radius_m or not body.footprint_at(pose).intersects(self._lines):
            return False
        leaving = distance_m > self.distance_m(body.pose.x, body.pose.y)
        return not (leaving and body.footprint_at(body.pose).intersects(self._lines))
