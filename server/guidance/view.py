"""What robots share in a cycle of guidance, and what the cycle says of each of them."""

from dataclasses import dataclass

from mapping.grid import FloorGrid
from protocol.messages import Assignment, Blockage
from server.guidance.blockage import RobotShapes
from server.guidance.decision import Decision
from server.guidance.floor_sums import FloorSums
from server.guidance.path import Point
from server.guidance.speed_limits import SpeedLimits


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What all robots share in one cycle: the obstacle raster (None: unknown or too old) with its sums, the floor that each robot
    covers, and the zones with a speed limit."""

    grid: FloorGrid | None
    sums: FloorSums | None
    robots: RobotShapes
    limits: SpeedLimits


@dataclass(frozen=True, slots=True)
class View:
    """One robot's result of a cycle: the decision, what the map shows of it, and its assignment as it now is."""

    decision: Decision
    blocked: bool = False
    blockage: Blockage | None = None
    box: tuple[Point, ...] = ()
    carrot: Point | None = None
    path: tuple[Point, ...] = ()
    detour: tuple[Point, ...] = ()
    leg: int | None = None
    assignment: Assignment | None = None
