"""How often each vehicle's pose leaves by one output."""

from collections.abc import Iterable

from protocol.clock import Clock
from protocol.messages import TrackedPose


class Pace:
    """Lets each vehicle's poses through at most `rate_hz` times a second (0: every one)."""

    def __init__(self, clock: Clock, rate_hz: float) -> None:
        self._clock = clock
        self._period_s = 1.0 / rate_hz if rate_hz > 0 else 0.0
        self._due_s: dict[str, float] = {}

    def due(self, poses: Iterable[TrackedPose]) -> list[TrackedPose]:
        """Those of the poses that are due now; asking counts as sending."""
        if self._period_s == 0.0:
            return list(poses)
        now_s = self._clock.monotonic_s()
        return [pose for pose in poses if self._is_due(pose.vehicle, now_s)]

    def _is_due(self, vehicle: str, now_s: float) -> bool:
        due_s = self._due_s.get(vehicle, now_s)
        if now_s < due_s:
            return False
        # Kept on the grid, so that the rate holds on average; after a pause it starts anew.
        self._due_s[vehicle] = max(due_s, now_s - self._period_s) + self._period_s
        return True
