"""The outputs that a lab description asks for, as one thing: UDP at once, Redis behind it."""

import asyncio
import logging
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from localization.outputs.gulliview import GulliViewReceiver
from localization.outputs.redis_poses import RedisPoses
from localization.outputs.robot_poses import RobotPoses
from localization.outputs.udp_sender import UdpSender
from protocol.bus import Bus
from protocol.clock import Clock
from protocol.gulliview import areas_that_wrap
from protocol.lab import Lab
from protocol.messages import Registration, TrackedPose

_logger = logging.getLogger(__name__)

_REPORT_EVERY_S = 60.0


@dataclass(frozen=True, slots=True)
class Outputs:
    """What is switched on; an output that is off is None, or absent from `receivers`."""

    robots: RobotPoses | None
    receivers: Sequence[GulliViewReceiver]
    redis: RedisPoses | None

    def send(self, poses: Sequence[TrackedPose]) -> None:
        """By UDP, to everyone. Never blocks, never raises."""
        if self.robots is not None:
            self.robots.send(poses)
        for receiver in self.receivers:
            receiver.send(poses)

    async def publish(self, poses: Sequence[TrackedPose]) -> None:
        """To the bus, after everyone who is waiting for a datagram has it."""
        if self.redis is not None:
            await self.redis.publish(poses)

    def register(self, registration: Registration) -> None:
        """A robot says where it listens."""
        if self.robots is not None:
            self.robots.register(registration)

    async def run(self, clock: Clock) -> None:
        """Keeps addresses, and writes now and then into the log what was sent; until cancelled."""
        tasks = [asyncio.ensure_future(receiver.run()) for receiver in self.receivers]
        if self.robots is not None:
            tasks.append(asyncio.ensure_future(self.robots.run()))
        told = self.describe()
        try:
            while True:
                await clock.sleep(_REPORT_EVERY_S)
                if (now := self.describe()) != told:
                    _logger.info("poses out: %s", now)
                    told = now
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            _logger.info("poses out: %s", self.describe())

    def describe(self) -> str:
        """What was sent by each, for the log."""
        parts: Iterable[RobotPoses | GulliViewReceiver | RedisPoses | None] = (
            self.robots,
            *self.receivers,
            self.redis,
        )
        return "; ".join(part.describe() for part in parts if part is not None) or "every output is switched off"


def outputs_of(lab: Lab, bus: Bus, sender: UdpSender, clock: Clock, key: bytes | None) -> Outputs:
    """As `lab.outputs` says; what can go wrong with it stands in the log."""
    wanted = lab.outputs
    receivers = [GulliViewReceiver(sender, clock, lab, receiver) for receiver in wanted.gulliview if receiver.enabled]
    if receivers:
        for sentence in areas_that_wrap(lab):
            _logger.warning("%s", sentence)
    if not wanted.redis.enabled:
        _logger.warning("outputs.redis is off: console, guidance and cameras have no poses of vehicles")
    return Outputs(
        robots=RobotPoses(sender, clock, key, wanted.datagrams) if wanted.datagrams.enabled else None,
        receivers=receivers,
        redis=RedisPoses(bus, clock, wanted.redis) if wanted.redis.enabled else None,
    )
