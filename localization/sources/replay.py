"""Plays a recording as if it happened now: at its own pace, capture times moved to the present."""

from localization.sources.base import Capture
from protocol.clock import Clock
from protocol.frames import Frame

_LONGEST_PAUSE_S = 1.0
"""Longer gaps of a recording are shortened, so that a replay never looks like a stalled camera."""


class ReplayCapture:
    """Wraps a capture whose stamps are of the past."""

    def __init__(self, recorded: Capture, clock: Clock) -> None:
        self._recorded, self._clock = recorded, clock
        self._shift_ns: int | None = None

    def read(self) -> Frame | None:
        start_s = self._clock.monotonic_s()
        frame = self._recorded.read()
        if frame is None:
            return None
        decode_ms = (self._clock.monotonic_s() - start_s) * 1e3
        now_ns = self._clock.now_ns()
        if self._shift_ns is None:
            self._shift_ns = now_ns - frame.stamp_ns
        ahead_s = (frame.stamp_ns + self._shift_ns - now_ns) * 1e-9
        if ahead_s > _LONGEST_PAUSE_S:
            self._shift_ns -= round((ahead_s - _LONGEST_PAUSE_S) * 1e9)
            ahead_s = _LONGEST_PAUSE_S
        self._clock.wait(ahead_s)
        return Frame(frame.number, frame.stamp_ns + self._shift_ns, frame.pixels, decode_ms)

    def close(self) -> None:
        self._recorded.close()
