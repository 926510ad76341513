"""Each robot's own pose to its own socket, as the project's datagrams, all from one socket (spec localization, "Wire
formats out"; protocol, `datagram`)."""

import asyncio
import ipaddress
import logging
import socket
from collections.abc import Iterable
from typing import cast

from protocol.clock import Clock
from protocol.datagram import TRACKER, Datagram, Sequencer, pack
from protocol.messages import Registration, TrackedPose

_logger = logging.getLogger(__name__)


class RobotPoses(asyncio.DatagramProtocol):
    """Sends POSE datagrams to registered robots. `rate_hz` limits how often each robot is told (0: every update)."""

    def __init__(self, clock: Clock, key: bytes | None, rate_hz: float = 0.0) -> None:
        self._clock, self._key = clock, key
        self._period_s = 1.0 / rate_hz if rate_hz > 0 else 0.0
        self._sequencer = Sequencer(clock.now_ns())
        self._addresses: dict[str, tuple[str, int]] = {}
        self._due_s: dict[str, float] = {}
        self._transport: asyncio.DatagramTransport | None = None
        self.sent = 0
        self.failed = 0

    async def open(self) -> None:
        """Opens the socket; OSError when the system has none to give."""
        loop = asyncio.get_running_loop()
        await loop.create_datagram_endpoint(lambda: self, family=socket.AF_INET)

    async def register(self, registration: Registration) -> None:
        """From now on this robot's poses go to this address. A host that does not resolve is logged and changes nothing."""
        try:
            host = str(ipaddress.IPv4Address(registration.host))
        except ValueError:
            try:
                loop = asyncio.get_running_loop()
                found = await loop.getaddrinfo(registration.host, None, family=socket.AF_INET, type=socket.SOCK_DGRAM)
                host = cast("str", found[0][4][0])
            except (OSError, UnicodeError, IndexError) as error:
                _logger.warning("%s registered from %r: %s", registration.robot, registration.host, error)
                return
        address = (host, registration.udp_port)
        if self._addresses.get(registration.robot) != address:
            _logger.info("poses of %s go to %s:%d", registration.robot, *address)
        self._addresses[registration.robot] = address

    def send(self, poses: Iterable[TrackedPose]) -> None:
        """Sends each pose to the robot that it is of, if that is registered and due. Never blocks, never raises."""
        if self._transport is None:
            return
        for pose in poses:
            address = self._addresses.get(pose.vehicle)
            if address is None or not self._due(pose.vehicle):
                continue
            now_ns = self._clock.now_ns()
            self._transport.sendto(pack(Datagram(TRACKER, self._sequencer.next(), now_ns, pose), self._key), address)
            self.sent += 1

    def close(self) -> None:
        """Says in the log what was done."""
        if self._transport is not None:
            self._transport.close()
            _logger.info("%d poses sent to robots, %d of them in vain", self.sent, self.failed)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.DatagramTransport", transport)

    def error_received(self, exc: Exception) -> None:
        """A robot whose socket is gone, a network that is down: the next pose is as good as this one was."""
        self.failed += 1
        _logger.debug("a pose was not sent: %s", exc)

    def _due(self, vehicle: str) -> bool:
        if self._period_s == 0.0:
            return True
        now_s = self._clock.monotonic_s()
        due_s = self._due_s.get(vehicle, now_s)
        if now_s < due_s:
            return False
        # Kept on the grid, so that the rate holds on average; after a pause it starts anew.
        self._due_s[vehicle] = max(due_s, now_s - self._period_s) + self._period_s
        return True
