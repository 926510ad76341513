"""The capture times that a camera writes on its pictures, told in this machine's time.

Where both clocks agree, the camera's stamp is the capture time as it is. Where they do not, its clock still tells the time
between pictures better than their arrival, which the network makes late by turns: the least lateness of the last seconds
is taken for the difference of the clocks (the minimum filter of one-way delays, Paxson 1998, sect. 3).
"""

from collections import deque

_AGREES_NS = 500_000_000
"""A picture that arrives at most this long after its stamp comes from a clock that agrees with ours."""
_WINDOW_NS = 10_000_000_000
"""Quartz clocks drift by less than 100 ppm: a millisecond in this time."""


class RemoteClock:
    """Maps a camera's stamps to local ones; frames in the order of their arrival."""

    def __init__(self) -> None:
        self._lateness: deque[tuple[int, int]] = deque()

    def local_ns(self, remote_ns: int, arrived_ns: int) -> int:
        """The capture time (local wall clock, ns) of a picture stamped `remote_ns` by its camera; never after its arrival."""
        late_ns = arrived_ns - remote_ns
        while self._lateness and not 0 <= arrived_ns - self._lateness[0][0] <= _WINDOW_NS:
            self._lateness.popleft()
        # Kept so that the first is the least: later arrivals with less lateness supersede earlier ones.
        while self._lateness and self._lateness[-1][1] >= late_ns:
            self._lateness.pop()
        self._lateness.append((arrived_ns, late_ns))
        least_ns = self._lateness[0][1]
        if 0 <= least_ns <= _AGREES_NS and late_ns <= 2 * _AGREES_NS:
            return remote_ns
        return min(arrived_ns, remote_ns + least_ns)
