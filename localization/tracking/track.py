"""One vehicle's track: measurements of all cameras in the order of their capture times, whenever they arrive.

A measurement that comes late (another camera's, of an earlier instant) is put where it belongs and what followed is
filtered again; so cameras are fused by covariance, and the result does not depend on who was faster.
"""

from dataclasses import dataclass
from enum import StrEnum
from itertools import takewhile

import numpy as np
from numpy.typing import NDArray

from localization.tracking.filter import Innovation, State, correct, distance2, innovation, predict, start
from localization.tracking.motion import Agility
from localization.tracking.sight import Sight
from protocol.lab import Limits

Array = NDArray[np.float64]

LOST_AFTER_S = 0.5
_GATE = 21.11
"""The 99.99 % quantile of chi-square with three degrees of freedom."""
_DISAGREEMENT = np.diag([0.010**2, 0.010**2, 0.02**2])
"""Cameras that are sure of themselves may still differ by this much (m, m, rad: a tag's height or a lens a little wrong). It
widens the gate only; how sights are weighed is their own covariance's."""
_HISTORY_S = 0.6
_CLOCK_SET_BACK_S = 5.0
"""A sight this much older than the track is no late one: the cameras' clock was set back."""
_STALE_S = 0.15
"""A track without accepted sights for this long may be taken over by one that its gate refuses."""
_AGREEING = 2
"""So many refused sights must agree with each other before they are believed."""
_SAME_PLACE_M = 0.15


class Verdict(StrEnum):
    """What became of a sight."""

    STARTED = "started"
    FUSED = "fused"
    KNOWN = "known"
    TOO_OLD = "too_old"
    REFUSED = "refused"


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    sight: Sight
    state: State


class Track:
    """The filter of one vehicle, with enough of its past to take late sights."""

    def __init__(self, limits: Limits) -> None:
        self._limits, self._agility = limits, Agility.of(limits)
        self._steps: list[_Step] = []
        self._refused: list[Sight] = []

    @property
    def newest(self) -> State | None:
        """The state at the newest capture time; None before the first sight."""
        return self._steps[-1].state if self._steps else None

    def cameras(self, within_s: float) -> tuple[str, ...]:
        """Who contributed to the newest state within that time, in the order of their names."""
        if not self._steps:
            return ()
        since_ns = self._steps[-1].sight.stamp_ns - within_s * 1e9
        recent = takewhile(lambda step: step.sight.stamp_ns >= since_ns, reversed(self._steps))
        return tuple(sorted({step.sight.camera for step in recent}))

    def at(self, stamp_ns: int) -> State | None:
        """The state predicted to a time; None when the track is lost by then."""
        state = self.newest
        if state is None or abs(stamp_ns - state.stamp_ns) > LOST_AFTER_S * 1e9:
            return None
        return predict(state, stamp_ns, self._agility)

    def distance2(self, sight: Sight) -> float | None:
        """Squared Mahalanobis distance of a sight from the track, with what cameras may disagree by allowed for; None when
        there is no track to compare with."""
        seen = self._compared(self._index(sight.stamp_ns), sight)
        return None if seen is None else distance2(seen, _DISAGREEMENT)

    def add(self, sight: Sight) -> Verdict:
        """Fuses a sight, or starts (again) with it, or refuses it."""
        newest = self.newest
        ahead_s = 0.0 if newest is None else (sight.stamp_ns - newest.stamp_ns) * 1e-9
        if newest is None or ahead_s > LOST_AFTER_S or ahead_s < -_CLOCK_SET_BACK_S:
            return self._begin([sight])
        index = self._index(sight.stamp_ns)
        if self._knows(sight, index):
            return Verdict.KNOWN
        seen = self._compared(index, sight)
        if seen is None:
            return Verdict.TOO_OLD
        if distance2(seen, _DISAGREEMENT) > _GATE:
            return self._refuse(sight)
        self._insert(index, _Step(sight, correct(seen)))
        self._refused = []
        return Verdict.FUSED

    def _index(self, stamp_ns: int) -> int:
        """Where a sight of that time belongs: behind all that are not newer. Sought from the end: late is late by little."""
        index = len(self._steps)
        while index and self._steps[index - 1].sight.stamp_ns > stamp_ns:
            index -= 1
        return index

    def _knows(self, sight: Sight, index: int) -> bool:
        same = takewhile(lambda step: step.sight.stamp_ns == sight.stamp_ns, reversed(self._steps[:index]))
        return any(step.sight.camera == sight.camera for step in same)

    def _compared(self, index: int, sight: Sight) -> Innovation | None:
        """The sight against the state before it; None when there is none."""
        if index == 0:
            return None
        before = self._steps[index - 1].state
        if sight.stamp_ns - before.stamp_ns > LOST_AFTER_S * 1e9:
            return None
        return innovation(predict(before, sight.stamp_ns, self._agility), sight)

    def _begin(self, sights: list[Sight]) -> Verdict:
        first, *others = sights
        self._steps = [_Step(first, start(first, self._limits))]
        self._refused = []
        for sight in others:
            self._append(sight)
        return Verdict.STARTED

    def _insert(self, index: int, step: _Step) -> None:
        """Puts a step where it belongs and filters what followed it again."""
        again = self._steps[index:]
        self._steps[index:] = [step]
        for later in again:
            self._append(later.sight)
        oldest_ns = self._steps[-1].sight.stamp_ns - _HISTORY_S * 1e9
        if self._steps[0].sight.stamp_ns < oldest_ns:
            keep = next(i for i, kept in enumerate(self._steps) if kept.sight.stamp_ns >= oldest_ns)
            del self._steps[:keep]

    def _append(self, sight: Sight) -> None:
        predicted = predict(self._steps[-1].state, sight.stamp_ns, self._agility)
        self._steps.append(_Step(sight, correct(innovation(predicted, sight))))

    def _refuse(self, sight: Sight) -> Verdict:
        """Sights that agree with each other outvote a track that nobody confirms any more: the vehicle was carried away."""
        agreeing = [old for old in self._refused if _close(old, sight)]
        self._refused = [*agreeing, sight][-_AGREEING:]
        newest = self.newest
        assert newest is not None
        unconfirmed = sight.stamp_ns - newest.stamp_ns > _STALE_S * 1e9
        if unconfirmed and len(self._refused) >= _AGREEING:
            return self._begin(sorted(self._refused, key=lambda old: old.stamp_ns))
        return Verdict.REFUSED


def _close(a: Sight, b: Sight) -> bool:
    recent = abs(a.stamp_ns - b.stamp_ns) <= LOST_AFTER_S * 1e9
    return recent and float(np.hypot(*(a.pose - b.pose)[:2])) <= _SAME_PLACE_M
