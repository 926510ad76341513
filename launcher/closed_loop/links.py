"""One direction between two processes, with what may go wrong there."""

import heapq
import itertools
from typing import Generic, TypeVar

import numpy as np

T = TypeVar("T")
_AGAIN_S = 0.2
"""TCP sends a segment that was lost again after about so long: its least timeout, or what comes behind tells it of the gap."""


class Link(Generic[T]):
    """What is sent comes out of `due` after `delay_s` and `more_delay_s`. `loss` is the share of packets lost: on a `stream`
    (TCP) they only come later and hold up what is behind them, else (UDP) they never come. A link that is `cut` loses all."""

    def __init__(self, seed: list[int], delay_s: float, *, stream: bool = False) -> None:
        self.loss = 0.0
        self.more_delay_s = 0.0
        self.cut = False
        self._delay_s, self._stream = delay_s, stream
        self._rng = np.random.default_rng(seed)
        self._waiting: list[tuple[float, int, T]] = []
        self._order = itertools.count()
        self._last_s = 0.0

    def send(self, item: T, now_s: float) -> None:
        if self.cut:
            return
        due_s = now_s + self._delay_s + self.more_delay_s
        if self._stream:
            while self.loss and self._rng.random() < self.loss:
                due_s += _AGAIN_S
            due_s = self._last_s = max(due_s, self._last_s)
        elif self.loss and self._rng.random() < self.loss:
            return
        heapq.heappush(self._waiting, (due_s, next(self._order), item))

    def due(self, now_s: float) -> list[T]:
        """What has arrived, in its order."""
        arrived: list[T] = []
        while self._waiting and self._waiting[0][0] <= now_s:
            arrived.append(heapq.heappop(self._waiting)[2])
        return arrived

    def clear(self) -> None:
        """What is on the way is lost, as when the process at one end dies."""
        self._waiting.clear()
        self._last_s = 0.0
