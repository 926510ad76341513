"""The line to drive on: a drawn polyline with its corners rounded, by the way along it. Pure; metres, map frame."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.control.controller import Point
from geometry import angle_difference

Array = NDArray[np.float64]

_LONGEST_BLEND_M = 0.3
"""A corner is rounded from at most so far before it: as much of the line behind the robot is told."""
_STRAIGHT_STEP_M = 0.1
_BEND_STEP_RAD = 0.08
_NEGLIGIBLE_M = 1e-4
_NEGLIGIBLE_RAD = 1e-3


@dataclass(frozen=True, slots=True)
class PathPoint:
    """A place on the line: x, y (m), heading of the tangent (rad) and curvature (1/m, positive to the left)."""

    x: float
    y: float
    heading_rad: float
    curvature: float


@dataclass(frozen=True, slots=True, eq=False)
class SmoothPath:
    """Samples by the way along the line: `ways` (N,) in m from its start, `points` (N, 2), unwrapped `headings` (N,) in rad,
    `curvatures` (N,) in 1/m."""

    ways: Array
    points: Array
    headings: Array
    curvatures: Array

    @classmethod
    def through(cls, points: Sequence[Point], corner_cut_m: float) -> "SmoothPath":
        """At least two different points. Every corner becomes a parabola that stays within `corner_cut_m` of it, and that
        begins and ends no further away than half-way to the next corner."""
        corners = np.array(without_repeats(points), dtype=np.float64)
        if len(corners) < 2:
            raise ValueError("a path needs two points that differ")
        legs = np.diff(corners, axis=0)
        lengths = np.hypot(legs[:, 0], legs[:, 1])
        directions = legs / lengths[:, None]
        samples: list[Array] = [np.array([[*corners[0], *_tangent(directions[0])]])]
        for corner in range(1, len(corners) - 1):
            into, out = directions[corner - 1], directions[corner]
            before = lengths[corner - 1] * (1.0 if corner == 1 else 0.5)
            after = lengths[corner] * (1.0 if corner == len(corners) - 2 else 0.5)
            bend = _bend(corners[corner], into, out, min(before, after), corner_cut_m)
            samples += [_straight(samples[-1][-1], bend[0]), bend]
        end = np.array([[*corners[-1], *_tangent(directions[-1])]])
        samples += [_straight(samples[-1][-1], end[0]), end]
        table = np.vstack(samples)
        steps = np.hypot(*np.diff(table[:, :2], axis=0).T)
        table = table[np.concatenate([[True], steps > 0.1 * _NEGLIGIBLE_M])]
        ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(table[:, :2], axis=0).T))])
        return cls(ways, table[:, :2], np.unwrap(table[:, 2]), table[:, 3])

    @property
    def length_m(self) -> float:
        return float(self.ways[-1])

    def at(self, way_m: float) -> PathPoint:
        """The place after `way_m`; before the start and past the end the line runs on straight."""
        within = min(max(way_m, 0.0), self.length_m)
        x = float(np.interp(within, self.ways, self.points[:, 0]))
        y = float(np.interp(within, self.ways, self.points[:, 1]))
        heading = float(np.interp(within, self.ways, self.headings))
        curvature = float(np.interp(within, self.ways, self.curvatures)) if within == way_m else 0.0
        beyond = way_m - within
        return PathPoint(x + beyond * math.cos(heading), y + beyond * math.sin(heading), heading, curvature)

    def nearest(self, x: float, y: float, since_m: float = -math.inf, until_m: float = math.inf) -> float:
        """The way (m) of the nearest place between two ways; past the end where the place lies beyond it."""
        first = max(0, int(np.searchsorted(self.ways, since_m, side="right")) - 1)
        last = min(len(self.ways) - 1, max(first + 1, int(np.searchsorted(self.ways, until_m, side="left"))))
        first = min(first, last - 1)
        starts, steps = self.points[first:last], np.diff(self.points[first : last + 1], axis=0)
        to = np.array([x, y]) - starts
        shares = np.einsum("ij,ij->i", to, steps) / np.einsum("ij,ij->i", steps, steps)
        inside = np.clip(shares, 0.0, 1.0)
        off = to - inside[:, None] * steps
        place = int(np.argmin(np.einsum("ij,ij->i", off, off)))
        share = float(inside[place])
        if place + first == len(self.ways) - 2 and share == 1.0:
            share = float(shares[place])
        way = float(self.ways[first + place] + share * (self.ways[first + place + 1] - self.ways[first + place]))
        return max(way, since_m)


def without_repeats(points: Sequence[Point]) -> list[Point]:
    """The points without those that coincide with the one before."""
    kept: list[Point] = []
    for point in points:
        if not kept or math.dist(kept[-1], point) > _NEGLIGIBLE_M:
            kept.append(point)
    return kept


def sections(points: Sequence[Point], cusp_rad: float) -> list[list[Point]]:
    """The line cut at every corner that turns by more than `cusp_rad`: there the robot halts and turns on the spot."""
    path = without_repeats(points)
    cut: list[list[Point]] = [path[:1]]
    for index in range(1, len(path)):
        cut[-1].append(path[index])
        if index + 1 < len(path):
            into = math.atan2(path[index][1] - path[index - 1][1], path[index][0] - path[index - 1][0])
            out = math.atan2(path[index + 1][1] - path[index][1], path[index + 1][0] - path[index][0])
            if abs(angle_difference(out, into)) > cusp_rad:
                cut.append([path[index]])
    return cut


def _bend(corner: Array, into: Array, out: Array, longest_m: float, corner_cut_m: float) -> Array:
    """Samples (N, 4) of the parabola from `h` before the corner to `h` after it: x, y, heading, curvature."""
    sine = float(into[0] * out[1] - into[1] * out[0])
    angle = math.atan2(sine, float(into @ out))
    if abs(angle) < _NEGLIGIBLE_RAD:
        return np.array([[*corner, *_tangent(out)]])
    # The middle of the parabola is h/2 sin(angle/2) away from the corner.
    h = min(longest_m, _LONGEST_BLEND_M, 2.0 * corner_cut_m / math.sin(abs(angle) / 2.0))
    t = np.linspace(0.0, 1.0, max(4, math.ceil(abs(angle) / _BEND_STEP_RAD) + 1))[:, None]
    points = corner - h * (1.0 - t) ** 2 * into + h * t**2 * out
    tangents = (1.0 - t) * into + t * out
    curvatures = sine / (2.0 * h * np.hypot(tangents[:, 0], tangents[:, 1]) ** 3)
    return np.column_stack([points, np.arctan2(tangents[:, 1], tangents[:, 0]), curvatures])


def _straight(start: Array, end: Array) -> Array:
    """Samples (N, 4) from one sample to the next, without curvature; dense enough that headings are not smeared."""
    length = math.hypot(end[0] - start[0], end[1] - start[1])
    if length < 2.0 * _NEGLIGIBLE_M:
        return np.empty((0, 4))
    edge = min(0.005, length / 4.0) / length
    shares = np.concatenate([[edge], np.linspace(edge, 1.0 - edge, max(2, math.ceil(length / _STRAIGHT_STEP_M)))[1:]])
    points = start[:2] + shares[:, None] * (end[:2] - start[:2])
    heading = math.atan2(end[1] - start[1], end[0] - start[0])
    return np.column_stack([points, np.full(len(points), heading), np.zeros(len(points))])


def _tangent(direction: Array) -> tuple[float, float]:
    return math.atan2(direction[1], direction[0]), 0.0
