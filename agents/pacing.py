"""Keeps a loop at its rate and counts the rounds that came too late."""

from protocol.clock import Clock

CONTROL_RATE_HZ = 20.0
"""Of the agent's control loop."""


class Pacer:
    """Call `wait` once per round. A round that took longer than its period is an overrun: the missed rounds are left out
    instead of being caught up with, because a control loop in a hurry would act on the same data twice."""

    def __init__(self, clock: Clock, rate_hz: float) -> None:
        self.period_s = 1.0 / rate_hz
        self.overruns = 0
        self._clock = clock
        self._next_s = clock.monotonic_s() + self.period_s

    async def wait(self) -> None:
        """Sleeps until the next round is due."""
        now_s = self._clock.monotonic_s()
        if now_s > self._next_s:
            self.overruns += 1
            missed = int((now_s - self._next_s) / self.period_s) + 1
            self._next_s += missed * self.period_s
        await self._clock.sleep(self._next_s - now_s)
        self._next_s += self.period_s
