"""What decides about a vehicle's speed in a scene: the robot's own cooperation, and what it is compared with."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

from agents.manoeuvres.approach import Mobility
from agents.manoeuvres.coordinator import Coordinator
from agents.manoeuvres.parameters import DEFAULT, ManoeuvreParameters
from agents.manoeuvres.passages import Way
from agents.manoeuvres.precedence import Precedence, by_delay
from agents.manoeuvres.traffic import Sighting, ZoneMap
from launcher.manoeuvres.scenario import Entrant, Scenario
from protocol.messages.zones import ZoneMessage

_EPOCH_NS = 1_700_000_000_000_000_000


@dataclass(frozen=True, slots=True)
class Look:
    """What a vehicle knows in a cycle: the time (s), how far along its way it believes to be (m), its speed (m/s) and the
    others as the cameras saw them `sight_age_s` ago."""

    now_s: float
    progress_m: float
    speed_mps: float
    seen: Mapping[str, Sighting]
    sight_age_s: float


@dataclass(frozen=True, slots=True)
class Choice:
    """The speed it wants (m/s), which areas it holds, why it waits, and what it says to whom."""

    speed_mps: float
    holds: frozenset[str] = frozenset()
    why: str = ""
    message: ZoneMessage | None = None
    recipients: Iterable[str] = ()


class Mind(Protocol):
    """One vehicle's."""

    def hear(self, message: ZoneMessage, now_s: float) -> None: ...

    def choose(self, look: Look) -> Choice: ...


class Cooperative:
    """The robot's own: `agents.manoeuvres`. `clock_s` is how far the vehicle's clock is wrong."""

    def __init__(
        self,
        scenario: Scenario,
        entrant: Entrant,
        zones: ZoneMap,
        now_s: float,
        parameters: ManoeuvreParameters = DEFAULT,
        precedence: Precedence = by_delay,
        clock_s: float = 0.0,
    ) -> None:
        mobility = Mobility(
            scenario.speed_mps, scenario.acceleration_mps2, scenario.deceleration_mps2, parameters.reaction_s
        )
        self._clock_s = clock_s
        self.coordinator = Coordinator(
            entrant.robot, self._ns(now_s), scenario.outline, zones, mobility, parameters, precedence
        )
        self.coordinator.drive(Way(entrant.way))

    def hear(self, message: ZoneMessage, now_s: float) -> None:
        self.coordinator.hear(message, now_s)

    def choose(self, look: Look) -> Choice:
        advice = self.coordinator.step(
            self._ns(look.now_s),
            look.now_s,
            look.progress_m,
            look.speed_mps,
            look.seen,
            sight_age_s=look.sight_age_s,
        )
        holds = frozenset(area for claim in self.coordinator.booking.claims for area in claim.entered)
        why = "" if advice.hold is None else str(advice.hold)
        return Choice(advice.speed_mps, holds, why, advice.message, advice.recipients)

    def _ns(self, now_s: float) -> int:
        return _EPOCH_NS + round((now_s + self._clock_s) * 1e9)
