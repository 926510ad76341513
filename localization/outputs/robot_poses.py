"""Each robot's own pose to its own socket, as the project's datagrams (spec localization, "Wire formats out"; protocol,
`datagram`). Who registered is told until it has not registered again for as long as the channel table says."""

import asyncio
import logging
from collections.abc import Iterable
from dataclasses import dataclass

from localization.outputs.pace import Pace
from localization.outputs.resolving import Lookup, UnresolvedHostError, is_address, look_up, resolve
from localization.outputs.udp_sender import Address, Counts, UdpSender
from protocol.channels import REGISTRATIONS
from protocol.clock import Clock
from protocol.datagram import TRACKER, Datagram, Sequencer, pack
from protocol.lab import Output
from protocol.messages import Registration, TrackedPose

_logger = logging.getLogger(__name__)


@dataclass(slots=True)
class _Listener:
    address: Address
    until_s: float


@dataclass(frozen=True, slots=True)
class _Lookup:
    host: str
    port: int
    task: asyncio.Task[None]


class RobotPoses:
    """Sends POSE datagrams to registered robots."""

    def __init__(
        self, sender: UdpSender, clock: Clock, key: bytes | None, output: Output | None = None, lookup: Lookup = look_up
    ) -> None:
        output = output or Output()
        self._sender, self._clock, self._key, self._lookup = sender, clock, key, lookup
        self._pace = Pace(clock, output.rate_hz)
        self._sequencer = Sequencer(clock.now_ns())
        self._listeners: dict[str, _Listener] = {}
        self._lookups: dict[str, _Lookup] = {}
        self.counts = Counts()

    def register(self, registration: Registration) -> None:
        """From now on, or from when its host is resolved, this robot's poses go to this address. A host that does not resolve is
        logged and changes nothing."""
        robot, host, port = registration.robot, registration.host, registration.udp_port
        lookup = self._lookups.get(robot)
        if lookup is not None:
            if (lookup.host, lookup.port) == (host, port):
                return  # a name server may take longer than the robot to register again
            lookup.task.cancel()
            del self._lookups[robot]
        if is_address(host):
            self._accept(robot, (host, port))
        else:
            self._lookups[robot] = _Lookup(host, port, asyncio.ensure_future(self._resolve(robot, host, port)))

    def send(self, poses: Iterable[TrackedPose]) -> None:
        """Sends each pose to the robot that it is of, if that is registered and due. Never blocks, never raises."""
        told = [pose for pose in poses if self._listener(pose.vehicle) is not None]
        for pose in self._pace.due(told):
            address = self._listeners[pose.vehicle].address
            datagram = Datagram(TRACKER, self._sequencer.next(), self._clock.now_ns(), pose)
            self._sender.send(pack(datagram, self._key), address, pose.vehicle, self.counts)

    async def run(self) -> None:
        """Until cancelled; then no name is looked up any more."""
        try:
            await asyncio.Event().wait()
        finally:
            for lookup in self._lookups.values():
                lookup.task.cancel()

    def describe(self) -> str:
        """What is sent to whom, for the log."""
        robots = ", ".join(sorted(self._listeners)) or "no robot"
        return f"datagrams to {robots}: {self.counts.sent} sent, {self.counts.failed} failed"

    async def _resolve(self, robot: str, host: str, port: int) -> None:
        try:
            self._accept(robot, (await resolve(host, self._lookup), port))
        except UnresolvedHostError as error:
            _logger.warning("%s registered from a host that is not known: %s", robot, error)
        del self._lookups[robot]  # nobody else does while this is not cancelled

    def _accept(self, robot: str, address: Address) -> None:
        known = self._listeners.get(robot)
        if known is None or known.address != address:
            _logger.info("poses of %s go to %s:%d", robot, *address)
        self._listeners[robot] = _Listener(address, self._clock.monotonic_s() + REGISTRATIONS.stale_after_s)

    def _listener(self, robot: str) -> _Listener | None:
        known = self._listeners.get(robot)
        if known is not None and self._clock.monotonic_s() > known.until_s:
            _logger.info("%s has not registered for %.0f s: no more poses for it", robot, REGISTRATIONS.stale_after_s)
            del self._listeners[robot]
            return None
        return known
