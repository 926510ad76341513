"""One vehicle's track: measurements of all cameras in the order of their capture times, whenever they arrive.

A measurement that comes late (another camera's, of an earlier instant) is put where it belongs and what followed is
filtered again; so cameras are fused by covariance, and the result does not depend on who was faster.
"""

from bisect import bisect_right
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from localization.tracking.motion import Agility, State, correct, innovation, predict, start
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


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """A vehicle's pose (3,) with covariance (3, 3) as one camera saw it at a capture time."""

    camera: str
    stamp_ns: int
    pose: Array
    covariance: Array


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
        return tuple(sorted({step.sight.camera for step in self._steps if step.sight.stamp_ns >= since_ns}))

    def at(self, stamp_ns: int) -> State | None:
        """The state predicted to a time; None when the track is lost by then."""
        state = self.newest
        if state is None or abs(stamp_ns - state.stamp_ns) > LOST_AFTER_S * 1e9:
            return None
        return predict(state, stamp_ns, self._agility)

    def distance2(self, sight: Sight) -> float | None:
        """Squared Mahalanobis distance of a sight from the track, with what cameras may disagree by allowed for; None when
        there is no track to compare with."""
        before = self._before(sight.stamp_ns)
        if before is None or sight.stamp_ns - before.stamp_ns > LOST_AFTER_S * 1e9:
            return None
        predicted = predict(before, sight.stamp_ns, self._agility)
        return innovation(predicted, sight.pose, sight.covariance + _DISAGREEMENT).distance2

    def add(self, sight: Sight) -> Verdict:
        """Fuses a sight, or starts (again) with it, or refuses it."""
        newest = self.newest
        ahead_s = 0.0 if newest is None else (sight.stamp_ns - newest.stamp_ns) * 1e-9
        if newest is None or ahead_s > LOST_AFTER_S or ahead_s < -_CLOCK_SET_BACK_S:
            return self._begin([sight])
        if any(step.sight.camera == sight.camera and step.sight.stamp_ns == sight.stamp_ns for step in self._steps):
            return Verdict.KNOWN
        distance2 = self.distance2(sight)
        if distance2 is None:
            return Verdict.TOO_OLD
        if distance2 > _GATE:
            return self._refuse(sight)
        self._insert(sight)
        self._refused = []
        return Verdict.FUSED

    def _before(self, stamp_ns: int) -> State | None:
        index = bisect_right(self._steps, stamp_ns, key=lambda step: step.sight.stamp_ns)
        return self._steps[index - 1].state if index else None

    def _begin(self, sights: list[Sight]) -> Verdict:
        first = sights[0]
        self._steps = [_Step(first, start(first.stamp_ns, first.pose, first.covariance, self._limits))]
        self._refused = []
        for sight in sights[1:]:
            self._insert(sight)
        return Verdict.STARTED

    def _insert(self, sight: Sight) -> None:
        index = bisect_right(self._steps, sight.stamp_ns, key=lambda step: step.sight.stamp_ns)
        again = [sight, *(step.sight for step in self._steps[index:])]
        del self._steps[index:]
        for each in again:
            predicted = predict(self._steps[-1].state, each.stamp_ns, self._agility)
            self._steps.append(_Step(each, correct(predicted, innovation(predicted, each.pose, each.covariance))))
        oldest_ns = self._steps[-1].sight.stamp_ns - _HISTORY_S * 1e9
        keep = next(i for i, step in enumerate(self._steps) if step.sight.stamp_ns >= oldest_ns)
        del self._steps[:keep]

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
