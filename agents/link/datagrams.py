"""The robot's UDP socket: POSE datagrams of the tracker come in, STATUS datagrams go to the server."""

import asyncio
import logging
import socket
from collections.abc import Callable
from dataclasses import dataclass, field
from urllib.parse import urlsplit

from protocol.clock import Clock
from protocol.datagram import TRACKER, Datagram, ReplayGuard, Sequencer, Verdict, pack, unpack
from protocol.errors import DecodeError
from protocol.messages import Status, TrackedPose

_logger = logging.getLogger(__name__)


@dataclass(slots=True)
class DatagramCounts:
    """What came in: poses taken, bytes that are no datagram of ours or wrongly signed, other kinds or of
    another sender than the tracker, other vehicles'."""

    poses: int = 0
    undecodable: int = 0
    unexpected: int = 0
    foreign: int = 0
    verdicts: dict[Verdict, int] = field(default_factory=dict[Verdict, int])

    def __str__(self) -> str:
        late = {verdict: count for verdict, count in self.verdicts.items() if verdict is not Verdict.FRESH}
        ignored = {"undecodable": self.undecodable, "unexpected": self.unexpected, "foreign": self.foreign} | late
        told = ", ".join(f"{count} {why.replace('_', ' ')}" for why, count in ignored.items() if count)
        return f"{self.poses} poses" + (f"; ignored: {told}" if told else "")


class RobotSocket(asyncio.DatagramProtocol):
    """The tracker's poses of the own vehicle that are signed (where a key is configured), fresh and in order reach
    `on_pose`."""

    def __init__(self, robot: str, key: bytes | None, clock: Clock, on_pose: Callable[[TrackedPose], object]) -> None:
        self.counts = DatagramCounts()
        self.address = ""
        self._robot = robot
        self._key = key
        self._clock = clock
        self._on_pose = on_pose
        self._guard = ReplayGuard()
        self.counts.verdicts = self._guard.counts
        self._sequencer = Sequencer(clock.now_ns())
        self._transport: asyncio.DatagramTransport | None = None
        self._server: tuple[str, int] | None = None

    async def open(self, host: str) -> int:
        """Binds to a free port of `host` and returns it. OSError when the host is not this machine's."""
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(
            lambda: self, local_addr=(host, 0), family=family
        )
        return int(self._transport.get_extra_info("sockname")[1])

    def close(self) -> None:
        """Says in the log what came in."""
        if self._transport is not None:
            self._transport.close()
            _logger.info("datagrams: %s", self.counts)

    async def send_to(self, host: str, port: int) -> None:
        """Statuses go there from now on; `address` becomes the robot's own on that way. OSError when there is no way."""
        if self._transport is None:
            raise OSError("the robot's UDP socket is closed")
        family: int = self._transport.get_extra_info("socket").family
        found = await asyncio.get_running_loop().getaddrinfo(host, port, family=family, type=socket.SOCK_DGRAM)
        address = found[0][4]
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect(address)  # sends nothing, but chooses the way
            self.address = str(probe.getsockname()[0])
        self._server = str(address[0]), int(address[1])

    def next_sequence(self) -> int:
        """The number of the next status, in its message and on its datagram."""
        return self._sequencer.next()

    def send_status(self, status: Status) -> None:
        """Does nothing before the server has said where to."""
        if self._transport is None or self._server is None or self._transport.is_closing():
            return
        self._transport.sendto(status_datagram(status, self._key), self._server)

    def datagram_received(self, data: bytes, addr: tuple[str | int, int]) -> None:
        try:
            datagram = unpack(data, self._key)
        except DecodeError as error:
            self.counts.undecodable += 1
            _logger.debug("dropped a datagram from %s: %s", addr, error)
            return
        pose = datagram.message
        if not isinstance(pose, TrackedPose) or datagram.sender != TRACKER:
            self.counts.unexpected += 1
        elif pose.vehicle != self._robot:
            self.counts.foreign += 1
        elif self._guard.check(datagram, self._clock.now_ns()) is Verdict.FRESH:
            self.counts.poses += 1
            self._on_pose(pose)

    def error_received(self, exc: Exception) -> None:
        """The server does not listen at the moment; statuses are sent again anyway."""
        _logger.debug("a status was not delivered: %s", exc)


def status_datagram(status: Status, key: bytes | None) -> bytes:
    """The status as its robot sends it, without its texts where they are too long for a datagram: what the robot does matters
    more than why."""
    try:
        return _packed(status, key)
    except ValueError:  # long texts in wide characters
        stopped_by = status.stopped_by and status.stopped_by.model_copy(update={"text": ""})
        return _packed(status.model_copy(update={"faults": (), "stopped_by": stopped_by}), key)


def _packed(status: Status, key: bytes | None) -> bytes:
    return pack(Datagram(status.robot, status.sequence, status.stamp_ns, status), key)


def server_host(server_url: str) -> str:
    """The host of the server's address. ValueError when it is no http(s) address."""
    parts = urlsplit(server_url)
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise ValueError(f"the server's address must look like http://HOST:PORT, got {server_url!r}")
    return parts.hostname


def bind_host(server: str) -> str:
    """What to listen on: the loopback alone when the server is there, else every interface."""
    if server == "localhost" or server.startswith("127."):
        return "127.0.0.1"
    if server == "::1":
        return "::1"
    return "::" if ":" in server else "0.0.0.0"  # noqa: S104  # poses come from the tracker's machine
