"""How long to wait before a process that ended is started again."""

FIRST_S = 0.2
LONGEST_S = 5.0
HEALTHY_S = 10.0
"""A process that ran this long was healthy: its next restart is quick again."""


class Backoff:
    """Delays that double from `FIRST_S` to `LONGEST_S`, and start over after a healthy run."""

    def __init__(self) -> None:
        self._next_s = FIRST_S

    def delay_s(self, uptime_s: float) -> float:
        """The wait (s) after a run of `uptime_s`."""
        if uptime_s >= HEALTHY_S:
            self._next_s = FIRST_S
        delay, self._next_s = self._next_s, min(2 * self._next_s, LONGEST_S)
        return delay
