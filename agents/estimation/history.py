"""The last seconds of odometry, asked for the motion between any two moments: this is how the camera's delay is made up for."""

from bisect import bisect_right

from agents.drivers.driver import OdometryReading
from geometry import SE2

_MOST_READINGS = 1000
"""However fast a base talks, memory stays bounded."""
_CLOCK_SET_BACK_NS = 1_000_000_000
"""Odometry that is older than the last by more than this: the machine's clock was set back."""
_JUMP_M = 0.5
_JUMP_MPS = 20.0
"""A base that moves further at once did not drive: its frame is another one."""


class OdometryHistory:
    """Readings of one session in the order of their stamps.

    Between two readings the robot is taken to hold the twist that leads from one to the other; before the first and after
    the last it is taken to hold theirs, for at most `max_extrapolation_s`.
    """

    def __init__(self, span_s: float = 2.0, max_extrapolation_s: float = 0.15) -> None:
        self._span_ns = round(span_s * 1e9)
        self._reach_ns = round(max_extrapolation_s * 1e9)
        self._readings: list[OdometryReading] = []

    @property
    def newest(self) -> OdometryReading | None:
        return self._readings[-1] if self._readings else None

    def add(self, reading: OdometryReading) -> None:
        """Takes a reading that is newer than all before; others change nothing."""
        if self._readings and reading.stamp_ns <= self._readings[-1].stamp_ns:
            return
        self._readings.append(reading)
        oldest_ns = reading.stamp_ns - self._span_ns
        keep_from = max(bisect_right(self._readings, oldest_ns, key=_stamp), len(self._readings) - _MOST_READINGS)
        del self._readings[:keep_from]

    def clear(self) -> None:
        self._readings.clear()

    def after(self, stamp_ns: int) -> tuple[OdometryReading, ...]:
        """The readings that are newer than the moment, in order."""
        return tuple(self._readings[bisect_right(self._readings, stamp_ns, key=_stamp) :])

    def at(self, stamp_ns: int) -> SE2 | None:
        """T_odom_robot at that moment; None when the readings do not reach that far."""
        if not self._readings:
            return None
        after = bisect_right(self._readings, stamp_ns, key=_stamp)
        if after == 0:
            return self._extrapolated(self._readings[0], stamp_ns)
        before = self._readings[after - 1]
        if after == len(self._readings):
            return self._extrapolated(before, stamp_ns)
        following = self._readings[after]
        share = (stamp_ns - before.stamp_ns) / (following.stamp_ns - before.stamp_ns)
        vx, vy, omega = before.pose.between(following.pose).log()
        return before.pose @ SE2.exp(share * vx, share * vy, share * omega)

    def _extrapolated(self, reading: OdometryReading, stamp_ns: int) -> SE2 | None:
        ahead_ns = stamp_ns - reading.stamp_ns
        if abs(ahead_ns) > self._reach_ns:
            return None
        ahead_s = ahead_ns / 1e9
        return reading.pose @ SE2.exp(ahead_s * reading.twist.linear_mps, 0.0, ahead_s * reading.twist.angular_radps)


def is_another_session(before: OdometryReading, after: OdometryReading) -> bool:
    """Whether the base restarted, or the clock was set back."""
    return after.session != before.session or after.stamp_ns < before.stamp_ns - _CLOCK_SET_BACK_NS


def is_jump(before: OdometryReading, after: OdometryReading) -> bool:
    """Whether the base says that it was somewhere else at once: it restarted without saying so."""
    dt_s = max(0.0, (after.stamp_ns - before.stamp_ns) / 1e9)
    return before.pose.distance_to(after.pose) > _JUMP_M + _JUMP_MPS * dt_s


def _stamp(reading: OdometryReading) -> int:
    return reading.stamp_ns
