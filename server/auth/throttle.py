"""Slows down guessing of passwords: after five wrong ones within a minute a user from an address has to wait, and so has
an address after thirty for whatever users. Kept in memory: the guesser gains nothing by our restart that takes longer."""

from collections import deque

from protocol.clock import Clock

_WINDOW_S = 60.0
_PER_USER, _PER_ADDRESS = 5, 30
_MOST_KEYS = 10_000


class LoginThrottle:
    """Counts failures per (user, address) and per address on a monotonic clock."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._failures: dict[tuple[str, ...], deque[float]] = {}

    def wait_s(self, user: str, address: str) -> float:
        """Seconds until this user may try again from this address; 0 when now."""
        return max(self._wait_s((user, address), _PER_USER), self._wait_s((address,), _PER_ADDRESS))

    def failed(self, user: str, address: str) -> None:
        """Notes a wrong password."""
        now_s = self._clock.monotonic_s()
        if len(self._failures) > _MOST_KEYS:
            self._forget_old(now_s)
        for key, limit in (((user, address), _PER_USER), ((address,), _PER_ADDRESS)):
            self._failures.setdefault(key, deque(maxlen=limit)).append(now_s)

    def succeeded(self, user: str, address: str) -> None:
        """Forgets the user's wrong ones."""
        self._failures.pop((user, address), None)

    def _wait_s(self, key: tuple[str, ...], limit: int) -> float:
        failures = self._failures.get(key)
        if failures is None or len(failures) < limit:
            return 0.0
        return max(0.0, failures[0] + _WINDOW_S - self._clock.monotonic_s())

    def _forget_old(self, now_s: float) -> None:
        old = [key for key, times in self._failures.items() if times[-1] + _WINDOW_S < now_s]
        for key in old or list(self._failures)[: _MOST_KEYS // 2]:
            del self._failures[key]
