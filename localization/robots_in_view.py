"""Whether a camera may learn what it sees as floor: not while a robot may stand there that no pose tells of.

A place that is learned with a robot on it shows as occupied when the robot leaves, and blocks whoever is to drive there.
"""

from collections.abc import Collection, Mapping

from localization.prediction import is_fresh
from protocol.messages import TrackedPose

_GAP_S = 1.0
"""Frames further apart are of two different scenes: what was searched in the first says nothing of the second."""
_REMEMBERED_S = 60.0
"""A robot that this camera saw so lately, and that nobody tracks, may still stand there unseen."""


class RobotsInView:
    """One camera's memory of the robots before it, frame after frame."""

    def __init__(self) -> None:
        self._searched = False
        self._last_ns: int | None = None
        self._seen_ns: dict[str, int] = {}

    def note(self, stamp_ns: int, seen: Collection[str], *, full_search: bool) -> None:
        """The vehicles whose tags a frame shows, by id; `full_search`: a search of the whole picture ended in it."""
        if self._last_ns is None or not 0 <= stamp_ns - self._last_ns <= _GAP_S * 1e9:
            self._searched = False
        self._last_ns = stamp_ns
        self._searched |= full_search
        self._seen_ns.update(dict.fromkeys(seen, stamp_ns))

    def are_known(self, poses: Mapping[str, TrackedPose]) -> bool:
        """Whether the newest poses tell of every robot that may stand in view at the time of the newest frame."""
        if not self._searched or self._last_ns is None:
            return False
        now_ns = self._last_ns
        lately = [name for name, stamp_ns in self._seen_ns.items() if now_ns - stamp_ns <= _REMEMBERED_S * 1e9]
        return all(name in poses and is_fresh(poses[name], now_ns) for name in lately)
