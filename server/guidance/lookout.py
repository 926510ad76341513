"""Looking whether a robot may go on: at its obstacle box, or at the floor that its corners would sweep when it turns."""

from dataclasses import dataclass

import shapely

from geometry import SE2
from protocol.channels import OBSTACLES
from protocol.lab import VehicleSpec
from protocol.messages import Blockage, Reason, ReasonCode
from server.guidance.blockage import RobotShapes, nearest_blockage, observed_share
from server.guidance.box import Body, Box, BoxRequest, footprint_at, outline
from server.guidance.decision import Ground
from server.guidance.floor_sums import Bounds
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point
from server.guidance.view import Surroundings


@dataclass(frozen=True, slots=True)
class Seen:
    """What was looked at (its outline, to be drawn), what is in it, and the reason to wait for that, if any."""

    outline: tuple[Point, ...]
    blockage: Blockage | None = None
    reason: Reason | None = None


class Lookout:
    """One robot's."""

    def __init__(self, spec: VehicleSpec, ground: Ground, parameters: GuidanceParameters) -> None:
        self._spec, self._ground, self._parameters = spec, ground, parameters
        self._front_m = Body.of(spec).front_m

    def ahead(self, around: Surroundings, wanted: BoxRequest) -> Seen:
        """At the obstacle box, and whether the path leaves every area within its reach."""
        place = self._ground.leaving(wanted.path.points, wanted.reach_m)
        if place is not None:
            text = f"the way ahead leaves every area at ({place[0]:.2f}, {place[1]:.2f})"
            return Seen(wanted.outline(), None, Reason(code=ReasonCode.OUTSIDE_AREA, text=text))
        if self._nothing_near(around, wanted.bounds()):
            return Seen(wanted.outline())
        box, size = wanted.box(), wanted.size
        robots = around.robots if size.robots else RobotShapes({})
        found = self._found(around, box, wanted.pose, robots)
        if found is not None:
            return Seen(outline(box.area), found, _blocked(found, "ahead"))
        return Seen(outline(box.area), None, self._unknown(around, box, wanted.pose, "way ahead", counts=size.unknown))

    def turning(self, around: Surroundings, sweep: Box, here: SE2) -> Seen:
        """At the floor that a turn on the spot sweeps; robots and unknown floor always count there."""
        found = self._found(around, sweep, here, around.robots)
        if found is None:
            return Seen((), None, self._unknown(around, sweep, here, "floor around", counts=True))
        # There is no way ahead along which to measure.
        away_m = footprint_at(here, self._spec).distance(shapely.Point(found.x, found.y))
        found = found.model_copy(update={"distance_m": round(away_m, 3)})
        return Seen((), found, _blocked(found, "beside it, in the way of its turning,"))

    def _nothing_near(self, around: Surroundings, bounds: Bounds) -> bool:
        """Whether there is nothing to be looked at exactly: no other robot, every cell seen and free. What the robot itself
        covers is looked at."""
        if around.grid is None or around.sums is None:
            return False
        return around.sums.all_clear(bounds) and around.robots.nobody_near(bounds, self._spec.id)

    def _found(self, around: Surroundings, box: Box, here: SE2, robots: RobotShapes) -> Blockage | None:
        if around.grid is None:
            return None
        own = footprint_at(here, self._spec).buffer(self._parameters.own_margin_m)
        return nearest_blockage(self._spec.id, box, own, self._front_m, around.grid, robots)

    def _unknown(self, around: Surroundings, box: Box, here: SE2, what: str, *, counts: bool) -> Reason | None:
        """The reason to wait for what nobody sees: the whole map, or, if it counts, too much of the box."""
        if around.grid is None:
            text = f"the obstacle map is missing or older than {OBSTACLES.stale_after_s:g} s"
            return Reason(code=ReasonCode.OBSTACLES_UNKNOWN, text=text)
        if not counts:
            return None
        own = footprint_at(here, self._spec).buffer(self._parameters.own_margin_m)
        unseen = 1.0 - observed_share(box.area.intersection(self._ground.area).difference(own), around.grid)
        if unseen <= self._parameters.unseen_share:
            return None
        return Reason(code=ReasonCode.OBSTACLES_UNKNOWN, text=f"no camera sees {unseen:.0%} of the {what}")


def _blocked(found: Blockage, where: str) -> Reason:
    text = f"{found.distance_m:.2f} m {where} at ({found.x:.2f}, {found.y:.2f})"
    if found.robot is None:
        return Reason(code=ReasonCode.OBSTACLE, text=text)
    return Reason(code=ReasonCode.ROBOT_AHEAD, text=f"{found.robot} {text}")
