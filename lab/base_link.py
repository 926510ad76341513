"""The cable between robots' computers and their simulated bases: DRIVE datagrams in, ODOMETRY and SCAN out
(docs/architecture.md, "The simulated base"). What is short, forged, stale or doubled is counted and has no effect."""

import asyncio
import logging
import zlib
from collections import Counter
from typing import cast

from lab.network import LossyLink
from lab.world import World
from protocol.clock import Clock
from protocol.datagram import LAB, Datagram, ReplayGuard, Sequencer, Verdict, pack, unpack
from protocol.errors import DecodeError
from protocol.messages import DriveSetpoint, Odometry, Scan

ODOMETRY_PERIOD_NS = 20_000_000
_logger = logging.getLogger(__name__)

Address = tuple[str, int]


class BaseLink(asyncio.DatagramProtocol):
    """Both directions for all vehicles; `rejected` counts by reason what was not obeyed."""

    def __init__(self, world: World, clock: Clock, key: bytes | None) -> None:
        self.rejected: Counter[str] = Counter()
        self.accepted = 0
        self._world = world
        self._clock = clock
        self._key = key
        self._guard = ReplayGuard()
        self._sequencer = Sequencer(clock.now_ns())
        network, seed = world.lab.simulation.network, world.seed
        self._inward: LossyLink[tuple[bytes, Address]] = LossyLink(network, [seed, zlib.crc32(b"inward")])
        self._outward: LossyLink[tuple[bytes, Address]] = LossyLink(network, [seed, zlib.crc32(b"outward")])
        self._addresses: dict[str, Address] = {}
        self._transport: asyncio.DatagramTransport | None = None
        self._reported: Counter[str] = Counter()
        self._next_odometry_ns = 0
        self._next_scan_ns = dict.fromkeys(world.scanners, 0)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.DatagramTransport", transport)

    def datagram_received(self, data: bytes, addr: Address) -> None:
        self._inward.send((data, addr), self._clock.monotonic_s())
        self._take_arrived()

    def error_received(self, exc: Exception) -> None:
        """An agent that went away leaves a closed port behind; its next one will send from a new address."""
        _logger.debug("odometry was not delivered: %s", exc)

    def tick(self) -> None:
        """To be called after every step of the world: delivers what was delayed, sends odometry and scans when it is time."""
        self._take_arrived()
        stamp_ns = self._world.stamp_ns
        if not self._next_odometry_ns - ODOMETRY_PERIOD_NS <= stamp_ns < self._next_odometry_ns:
            self._next_odometry_ns = stamp_ns - stamp_ns % ODOMETRY_PERIOD_NS + ODOMETRY_PERIOD_NS
            self._send_odometry()
        self._send_scans(stamp_ns)
        for data, address in self._outward.due(self._clock.monotonic_s()):
            if self._transport is not None:
                self._transport.sendto(data, address)

    def report(self) -> None:
        """Logs what was rejected since the last report."""
        news = self.rejected - self._reported
        if news:
            _logger.warning(
                "rejected drive datagrams: %s", ", ".join(f"{count} {why}" for why, count in sorted(news.items()))
            )
            self._reported = self.rejected.copy()

    def _send_odometry(self) -> None:
        for vehicle, address in self._addresses.items():
            self._send(self._world.odometry(vehicle), address)

    def _send_scans(self, stamp_ns: int) -> None:
        """A scanner turns on at its own rate; one whose time was set (a suspended computer) begins anew."""
        for vehicle, next_ns in self._next_scan_ns.items():
            address = self._addresses.get(vehicle)
            period_ns = round(1e9 / self._world.scanners[vehicle].spec.rate_hz)
            if address is None or next_ns - 2 * period_ns <= stamp_ns < next_ns:
                continue
            late_ns = stamp_ns - next_ns
            self._next_scan_ns[vehicle] = (next_ns if 0 <= late_ns < period_ns else stamp_ns) + period_ns
            self._send(self._world.scan(vehicle), address)

    def _send(self, message: Odometry | Scan, address: Address) -> None:
        datagram = Datagram(LAB, self._sequencer.next(), self._clock.now_ns(), message)
        self._outward.send((pack(datagram, self._key), address), self._clock.monotonic_s())

    def _take_arrived(self) -> None:
        for data, address in self._inward.due(self._clock.monotonic_s()):
            why = self._obey(data, address)
            if why is None:
                self.accepted += 1
            else:
                self.rejected[why] += 1

    def _obey(self, data: bytes, address: Address) -> str | None:
        """Passes the set-point on; None, or why not."""
        try:
            datagram = unpack(data, self._key)
        except DecodeError as error:
            _logger.debug("from %s:%d: %s", *address, error)
            return "unreadable"
        message = datagram.message
        if not isinstance(message, DriveSetpoint):
            return "of another kind"
        if message.vehicle not in self._world.vehicle_ids:
            return "for unknown vehicles"
        if datagram.sender != message.vehicle:
            return "of another sender"
        verdict = self._guard.check(datagram, self._clock.now_ns())
        if verdict is not Verdict.FRESH:
            return verdict.value.replace("_", " ")
        try:
            self._world.set_drive(message.vehicle, message.linear_mps, message.angular_radps)
        except ValueError:
            return "not finite"
        self._addresses[message.vehicle] = address
        return None
