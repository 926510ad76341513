"""What the parts of a robot's manoeuvring look at: the robot itself, and a cycle's view of its surroundings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.manoeuvres.approach import Mobility, stopping_m
from agents.manoeuvres.parameters import ManoeuvreParameters
from agents.manoeuvres.passages import Use, Way
from agents.manoeuvres.traffic import Ahead, Sighting, ZoneMap

STANDS_MPS = 0.02
LINE_M = 0.02
"""How far before an area a robot stops: more than its estimate trembles, or one that begins anew there would think it is
inside."""


class Robot:
    """A robot, where it drives and what it goes by. `outline`: corners (m, seen from its rotation centre)."""

    def __init__(
        self,
        robot: str,
        outline: Sequence[tuple[float, float]],
        mobility: Mobility,
        zones: ZoneMap,
        parameters: ManoeuvreParameters,
    ) -> None:
        self.id = robot
        self.corners = tuple(outline)
        self.outline: NDArray[np.float64] = np.asarray(outline, dtype=np.float64)
        self.mobility = mobility
        self.zones = zones
        self.parameters = parameters

    @property
    def front_m(self) -> float:
        """From the rotation centre to the front."""
        return float(self.outline[:, 0].max())

    @property
    def reach_m(self) -> float:
        """From the rotation centre to the farthest corner."""
        return float(np.hypot(*self.outline.T).max())

    @property
    def gap_m(self) -> float:
        """What it leaves free behind one that stands."""
        return 2 * self.parameters.margin_m + self.parameters.standing_m

    @property
    def standing_m(self) -> float:
        """The room that it needs to stand between two areas."""
        return float(np.ptp(self.outline[:, 0])) + self.gap_m


@dataclass(frozen=True, slots=True)
class Situation:
    """One cycle: the times, where the robot is on its way (m) and how fast (m/s), the zones that it is near, the other vehicles
    as the cameras saw them `sight_age_s` ago, and those of them that are ahead on the way."""

    now_ns: int
    now_s: float
    way: Way
    progress_m: float
    speed_mps: float
    near: frozenset[str]
    seen: Mapping[str, Sighting]
    sight_age_s: float
    leaders: Sequence[Ahead]

    def before(self, enter_m: float, robot: Robot) -> list[Ahead]:
        """Vehicles ahead on the way that come to that place (m along the way) before the robot."""
        return [leader for leader in self.leaders if self.progress_m + robot.front_m + leader.gap_m <= enter_m]

    def at_line(self, enter_m: float, robot: Robot) -> bool:
        """Whether the robot has to know now whether it may enter there."""
        within_m = stopping_m(self.speed_mps, robot.mobility) + robot.parameters.standing_m
        return enter_m - LINE_M - self.progress_m <= within_m

    def is_in(self, use: Use) -> bool:
        """Whether the robot's body is in the area by more than its estimate trembles."""
        return use.enter_m + LINE_M / 2 <= self.progress_m < use.exit_m
