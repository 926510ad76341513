"""What of lost and found vehicles is told as events: each change that lasts, and of a vehicle that comes and goes not every
one."""

from dataclasses import dataclass

from localization.tracking import TrackTransition

QUIET_S = 5.0
"""So long after an event nothing more is told of its vehicle."""


@dataclass(frozen=True, slots=True)
class _Told:
    tracked: bool
    at_s: float


class TrackReports:
    """Chooses what to tell. Times are monotonic seconds."""

    def __init__(self) -> None:
        self._pending: dict[str, TrackTransition] = {}
        self._told: dict[str, _Told] = {}

    def note(self, transition: TrackTransition) -> None:
        """A vehicle was found or lost; of several in a row the newest counts."""
        self._pending[transition.vehicle] = transition

    def take_due(self, now_s: float) -> list[TrackTransition]:
        """What is to be told now: where a vehicle's state is another one than was told last."""
        due: list[TrackTransition] = []
        for vehicle, transition in list(self._pending.items()):
            told = self._told.get(vehicle)
            if told is not None and now_s - told.at_s < QUIET_S:
                continue
            del self._pending[vehicle]
            if transition.tracked != (told is not None and told.tracked):
                self._told[vehicle] = _Told(transition.tracked, now_s)
                due.append(transition)
        return due


def sentence(transition: TrackTransition) -> str:
    """For the history."""
    x, y = transition.place
    if transition.tracked:
        return f"{transition.vehicle} is seen at ({x:.2f}, {y:.2f}) m"
    return f"{transition.vehicle} is lost, last seen at ({x:.2f}, {y:.2f}) m"
