"""A line to drive along, by the metres along it: the straight way of a leg, or a detour's bends. Metres, map frame."""

import itertools
from bisect import bisect_right
from collections.abc import Sequence

from server.guidance.path import Point, bearing, distance, point_along, progress_along, without_repeats


class Line:
    """One or more points; what lies before the first or beyond the last counts as there."""

    def __init__(self, points: Sequence[Point]) -> None:
        self.points = tuple(without_repeats(points))
        if not self.points:
            raise ValueError("a line has at least one point")
        steps = (distance(a, b) for a, b in itertools.pairwise(self.points))
        self._marks = tuple(itertools.accumulate(steps, initial=0.0))

    @property
    def length_m(self) -> float:
        return self._marks[-1]

    @property
    def end(self) -> Point:
        return self.points[-1]

    @property
    def last_bearing(self) -> float | None:
        """The direction (rad) of its last piece, None of a line without length."""
        return bearing(self.points[-2], self.points[-1]) if len(self.points) > 1 else None

    def locate(self, here: Point) -> float:
        """Metres along to the nearest place of the line."""
        best_m, nearest = 0.0, float("inf")
        for index, (a, b) in enumerate(itertools.pairwise(self.points)):
            along = progress_along(here, a, b)
            away = distance(here, point_along(a, b, along))
            if away < nearest - 1e-9:
                best_m, nearest = self._marks[index] + along, away
        return best_m

    def mark(self, index: int) -> float:
        """Metres along to a point of the line by its index."""
        return self._marks[index]

    def at(self, along_m: float) -> Point:
        """The point so many metres along."""
        if along_m <= 0 or len(self.points) == 1:
            return self.points[0]
        if along_m >= self.length_m:
            return self.end
        index = bisect_right(self._marks, along_m) - 1
        return point_along(self.points[index], self.points[index + 1], along_m - self._marks[index])

    def part(self, from_m: float, to_m: float) -> list[Point]:
        """The line between two distances, both ends included."""
        inner = [p for p, mark in zip(self.points, self._marks, strict=True) if from_m < mark < to_m]
        return without_repeats([self.at(from_m), *inner, self.at(to_m)])
