"""How much of a numbered sequence of messages arrives: the quality of a link, as either end sees it."""

from collections import deque
from dataclasses import dataclass

_SLOTS = 10


@dataclass(slots=True)
class _Slot:
    """Of the messages heard in a tenth of the window: the first one's number, and how many there were."""

    begun_s: float
    first: int
    heard: int


class LossWatch:
    """Over the last `window_s` seconds, to a tenth of them. Whoever sends numbers its messages one after the other; what comes
    twice changes nothing, a number that falls back is a new beginning. It remembers no single message, as a server watches
    thousands of links."""

    def __init__(self, window_s: float = 5.0) -> None:
        self._window_s, self._slot_s = window_s, window_s / _SLOTS
        self._slots: deque[_Slot] = deque()
        self._last = 0

    def add(self, number: int, now_s: float) -> None:
        """A message of that number arrived; `now_s` are monotonic seconds."""
        slots = self._slots
        if slots and number < self._last:
            slots.clear()
        if slots and number == self._last:
            return
        self._last = number
        if slots and now_s - slots[-1].begun_s < self._slot_s:
            slots[-1].heard += 1
            return
        slots.append(_Slot(now_s, number, 1))
        self._forget(now_s)

    def share(self, now_s: float) -> float | None:
        """The share, 0 to 1, of the messages between the first and the last of them that did not arrive; None of too few."""
        self._forget(now_s)
        heard = sum(slot.heard for slot in self._slots)
        if heard < 2:
            return None
        return 1.0 - heard / (self._last - self._slots[0].first + 1)

    def _forget(self, now_s: float) -> None:
        while self._slots and now_s - self._slots[0].begun_s > self._window_s:
            self._slots.popleft()
