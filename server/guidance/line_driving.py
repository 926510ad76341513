"""Driving along a line piece by piece, for ways that are planned with little room: at every bend the robot turns on the spot.

A robot that chases a temporary waypoint cuts bends, and one that turns while it drives swings out: by more than a detour's
clearance. So the temporary waypoint stays on the present piece of the line, beyond its end if need be, and a robot that does not
head along its piece turns first.
"""

from geometry import SE2, angle_difference
from server.guidance.line import Line
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point, bearing, distance, point_along, progress_along

PASSED_M = 0.08
"""This near its end a piece is driven."""
_ALIGN_ABOVE_RAD = 0.2
_LITTLE_M = 0.01


class LineDriver:
    """One robot on one line; remembers the piece that it is on, and whether it turns to go along it."""

    def __init__(self, line: Line, parameters: GuidanceParameters) -> None:
        self.line = line
        self._parameters = parameters
        self._piece = 0
        self._aligning = True

    def move_on(self, here: Point) -> float:
        """Takes notice of where the robot is; metres along the line."""
        points = self.line.points
        while self._piece < len(points) - 2 and self._passed(here):
            self._piece, self._aligning = self._piece + 1, True
        return self.along(here)

    def along(self, here: Point) -> float:
        """How far along the line a robot is that is on the present piece."""
        if len(self.line.points) < 2:
            return 0.0
        return self.line.mark(self._piece) + progress_along(here, *self._ends)

    @property
    def begun_m(self) -> float:
        """Metres along the line to where the present piece begins."""
        return self.line.mark(self._piece)

    @property
    def aligning(self) -> bool:
        """Whether the robot does not yet head along its piece."""
        return self._aligning

    def turn_to(self, pose: SE2) -> float | None:
        """The heading (rad) that the robot is to turn to before it drives on; None when it may drive."""
        if len(self.line.points) < 2 or distance(*self._ends) < _LITTLE_M:
            return None
        heading = bearing(*self._ends)
        error = abs(angle_difference(heading, pose.yaw))
        if error > _ALIGN_ABOVE_RAD:
            self._aligning = True
        elif error <= self._parameters.yaw_tolerance_rad:
            self._aligning = False
        return heading if self._aligning else None

    def carrot(self, here: Point) -> Point | None:
        """The temporary waypoint on the present piece, also beyond it; None when it would be beyond the line's end."""
        look_ahead = self._parameters.detour_look_ahead_m
        if len(self.line.points) < 2 or self.along(here) + look_ahead >= self.line.length_m:
            return None
        start, end = self._ends
        return point_along(start, end, progress_along(here, start, end) + look_ahead)

    def ahead(self, here: Point) -> list[Point]:
        """What is left of the line, from the robot on."""
        return [here, *self.line.part(self.along(here), self.line.length_m)[1:]]

    @property
    def _ends(self) -> tuple[Point, Point]:
        return self.line.points[self._piece], self.line.points[self._piece + 1]

    def _passed(self, here: Point) -> bool:
        start, end = self._ends
        return distance(here, end) <= PASSED_M or progress_along(here, start, end) >= distance(start, end) - _LITTLE_M
