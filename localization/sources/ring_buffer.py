"""The ring between a camera's reader and its user: the newest wins, and neither ever waits for the other (GulliView 2024,
3.1.1).

The report's ring holds pixels that the producer overwrites in place, and so needs slots enough for as long as the consumer
looks at one (t_consumer / t_producer; it used 64). Here frames are handed over by reference: what has been taken is never
written to again, so a few slots do, which also lets a recorder that falls behind for a moment take every frame (`oldest`).
"""

import threading
from collections import deque

from protocol.frames import Frame

SLOTS = 8


class FrameRing:
    """One producer, one consumer. `skipped` counts frames that newer ones replaced before they were taken."""

    def __init__(self, slots: int = SLOTS) -> None:
        if slots < 1:
            raise ValueError(f"a ring needs a slot, not {slots}")
        self._frames: deque[Frame] = deque(maxlen=slots)
        self._changed = threading.Condition()
        self._closed = False
        self.skipped = 0

    def put(self, frame: Frame) -> None:
        """Takes the place of the oldest frame when the ring is full; never waits for the consumer."""
        with self._changed:  # held elsewhere only to move references
            self.skipped += len(self._frames) == self._frames.maxlen
            self._frames.append(frame)
            self._changed.notify_all()

    def newest(self, timeout_s: float) -> Frame | None:
        """Takes the newest frame and drops the older ones; None when none came in time, or the ring was closed."""
        with self._changed:
            self._wait(timeout_s)
            if not self._frames:
                return None
            frame = self._frames.pop()
            self.skipped += len(self._frames)
            self._frames.clear()
            return frame

    def oldest(self, timeout_s: float) -> Frame | None:
        """Takes the oldest frame that is still there, for those who want every one; None as `newest`."""
        with self._changed:
            self._wait(timeout_s)
            return self._frames.popleft() if self._frames else None

    def close(self) -> None:
        """Wakes who waits; what is in the ring is dropped."""
        with self._changed:
            self._closed = True
            self._frames.clear()
            self._changed.notify_all()

    def _wait(self, timeout_s: float) -> None:
        self._changed.wait_for(lambda: self._frames or self._closed, timeout_s)
