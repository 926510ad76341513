"""How much of a numbered sequence of messages arrives: the quality of a link, as either end sees it."""

from collections import deque


class LossWatch:
    """Over the last `window_s` seconds. Whoever sends numbers its messages one after the other; what comes late or twice changes
    nothing, a number that falls back is a new beginning."""

    def __init__(self, window_s: float = 5.0) -> None:
        self._window_s = window_s
        self._heard: deque[tuple[float, int]] = deque()

    def add(self, number: int, now_s: float) -> None:
        """A message of that number arrived; `now_s` are monotonic seconds."""
        if self._heard and number < self._heard[-1][1]:
            self._heard.clear()
        if not self._heard or number > self._heard[-1][1]:
            self._heard.append((now_s, number))
        self._forget(now_s)

    def share(self, now_s: float) -> float | None:
        """The share, 0 to 1, of the messages between the first and the last of them that did not arrive; None of too few."""
        self._forget(now_s)
        if len(self._heard) < 2:
            return None
        sent = self._heard[-1][1] - self._heard[0][1] + 1
        return 1.0 - len(self._heard) / sent

    def _forget(self, now_s: float) -> None:
        while self._heard and now_s - self._heard[0][0] > self._window_s:
            self._heard.popleft()
