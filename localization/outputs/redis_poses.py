"""Poses to the bus: the channel `poses`, from which the console, guidance and the cameras' windows have them."""

from collections.abc import Iterable

from localization.outputs.pace import Pace
from protocol.bus import Bus
from protocol.channels import POSES
from protocol.clock import Clock
from protocol.lab import Output
from protocol.messages import TrackedPose


class RedisPoses:
    """Publishes poses that are due. While Redis is out of reach they are dropped and counted by the bus."""

    def __init__(self, bus: Bus, clock: Clock, output: Output) -> None:
        self._bus, self._pace = bus, Pace(clock, output.rate_hz)
        self.published = 0

    async def publish(self, poses: Iterable[TrackedPose]) -> None:
        """One round trip for all of them."""
        due = {pose.vehicle: pose for pose in self._pace.due(poses)}
        if due and await self._bus.publish_all(POSES, due):
            self.published += len(due)

    def describe(self) -> str:
        """What was published, for the log."""
        return f"Redis: {self.published} published"
