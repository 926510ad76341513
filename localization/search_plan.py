"""When a camera searches the whole picture (spec localization, "The pipeline of 2025", step 3; adaptive instead of a constant K).

Spread over frames as a rule: at once after something was lost, slowly while every vehicle of the lab is tracked by some camera.
With a fixed K, as the reports have it, a whole frame at least every K-th time.
"""

from collections.abc import Collection

HASTE_S = 2.0
"""So long after a vehicle was lost, or after the start, it is looked for as fast as a frame's budget allows."""
_HASTY_SHARE = 4
"""With a fixed K, while nothing is tracked at all, every frame is searched for two seconds, then this many times as often as K
says."""
_NOTHING_TRACKED_S = 0.2
_SOMETHING_MISSING_S = 0.5
_ALL_TRACKED_S = 3.0
"""How long a round over the picture takes."""


class SearchPlan:
    """`vehicles` are those that may appear; `turn` shifts the fixed K, so that cameras do not search in the same instant."""

    def __init__(self, vehicles: Collection[str], every: int | None, turn: int) -> None:
        self._vehicles, self._every, self._turn = frozenset(vehicles), every, turn
        self._last_tracked_ns: dict[str, int] = {}
        self._any_tracked_ns: int | None = None
        self._start_ns: int | None = None

    def note(self, stamp_ns: int, tracked: Collection[str]) -> None:
        """Vehicles that some camera follows at the time of a new frame."""
        self._turn += 1
        if self._start_ns is None or stamp_ns < self._start_ns:
            self._start_ns = stamp_ns
        self._last_tracked_ns.update(dict.fromkeys(tracked, stamp_ns))
        if tracked or self._any_tracked_ns is None:
            self._any_tracked_ns = stamp_ns

    def whole_frame_due(self, stamp_ns: int) -> bool:
        """With a fixed K: whether this frame is one."""
        if self._every is None:
            return False
        every = self._every
        if self._any_tracked_ns != stamp_ns:
            assert self._any_tracked_ns is not None, "note comes first"
            every = 1 if stamp_ns - self._any_tracked_ns < HASTE_S * 1e9 else max(1, every // _HASTY_SHARE)
        return self._turn % every == 0

    def is_missing(self, stamp_ns: int) -> bool:
        """Whether a vehicle of the lab is followed by no camera."""
        return any(self._last_tracked_ns.get(vehicle) != stamp_ns for vehicle in self._vehicles)

    def round_s(self, stamp_ns: int) -> float:
        """How long the spread search may take for the whole picture; 0: as fast as it can."""
        missing = [vehicle for vehicle in self._vehicles if self._last_tracked_ns.get(vehicle) != stamp_ns]
        if not missing:
            return _ALL_TRACKED_S
        assert self._start_ns is not None, "note comes first"
        newest_loss_ns = max(self._last_tracked_ns.get(vehicle, self._start_ns) for vehicle in missing)
        if 0 <= stamp_ns - newest_loss_ns < HASTE_S * 1e9:
            return 0.0
        return _NOTHING_TRACKED_S if len(missing) == len(self._vehicles) else _SOMETHING_MISSING_S
