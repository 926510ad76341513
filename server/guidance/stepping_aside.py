"""A robot that yields: it drives to a place out of another's way, waits there until the other has passed, and goes back."""

from collections.abc import Mapping
from dataclasses import dataclass

from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from geometry import SE2
from protocol.messages import Target
from server.guidance.box import PlannedPath
from server.guidance.following import Goal
from server.guidance.line import Line
from server.guidance.line_driving import LineDriver
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point, distance, polyline_length

_THERE_M, _NEAR_M = 0.1, 0.2
_LOOK_M = 5.0
"""How far ahead of the other robot its path is looked at: what it comes back to on its next lap is another matter."""
_LONGEST_S = 60.0
"""After this long a robot no longer waits for the others to pass."""


@dataclass(slots=True)
class Aside:
    """Where a robot goes to let others pass, since when (monotonic seconds), and the floor that they must have left behind:
    what it wants to drive over itself when it comes back."""

    driver: LineDriver
    others: frozenset[str]
    since_s: float
    claimed: BaseGeometry

    def there(self, pose: SE2, at_rest: bool) -> bool:
        """Whether the robot has arrived: is there, or rests near by (where its controller takes a target as reached)."""
        return distance((pose.x, pose.y), self.driver.line.end) <= (_NEAR_M if at_rest else _THERE_M)

    def over(self, paths: Mapping[str, tuple[Point, ...]], now_s: float) -> bool:
        """Whether the others have passed (none is about to drive over the claimed floor any more), or have had their time."""
        if now_s - self.since_s > _LONGEST_S:
            return True
        ahead = (Line(paths[name]) for name in self.others if paths.get(name))
        return not any(LineString(_two(line)).intersects(self.claimed) for line in ahead)

    def goal(self, pose: SE2, speed_mps: float, parameters: GuidanceParameters) -> tuple[Goal, PlannedPath]:
        """What to ask of the robot on its way aside, and the path ahead of it."""
        here = (pose.x, pose.y)
        self.driver.move_on(here)
        path = self.driver.ahead(here)
        carrot, turn = self.driver.carrot(here), self.driver.turn_to(pose)
        planned = PlannedPath(path, polyline_length(path))
        if turn is not None:
            return Goal(Target(x=here[0], y=here[1], yaw=turn), 0.0, True, turn), planned
        x, y = carrot or self.driver.line.end
        return Goal(Target(x=x, y=y), min(speed_mps, parameters.detour_mps), carrot is None), planned


def _two(line: Line) -> list[Point]:
    points = line.part(0.0, _LOOK_M)
    return points if len(points) > 1 else [points[0], points[0]]
