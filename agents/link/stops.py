"""Emergency stops by UDP broadcast: the way to stop robots that needs neither server nor Redis (spec gpss, "Safety").

Every agent listens on the lab's `stop_udp`; agents on one machine share the port, and a broadcast reaches them all. A datagram
can only engage the stop: releasing it is a person's business, by way of the server. A stop counts as new when its signature
is right, its stamp is not further off than clocks may be, and it was not heard before; so a recorded one stops nothing later.
"""

import asyncio
import logging
import socket
from collections.abc import Callable

from agents.link.backoff import Trouble
from agents.link.datagrams import status_datagram
from protocol.clock import Clock
from protocol.datagram import Datagram, Sequencer, unpack
from protocol.errors import DecodeError
from protocol.messages import EmergencyStop, Status

MOST_OFF_S = 30.0
"""Whoever stops robots may have a clock that is off by so much. Robots that are to be stopped must not ask for more."""
LOOPBACK_BROADCAST = "127.255.255.255"
_RETRY_S = 5.0
_MOST_REMEMBERED = 1000
_logger = logging.getLogger(__name__)


class ReplayedStops:
    """Which stops were heard already, by sender and number, for as long as they would count."""

    def __init__(self) -> None:
        self._heard: dict[tuple[str, int], int] = {}

    def is_new(self, datagram: Datagram, now_ns: int) -> bool:
        """Whether it was not heard before; it is not new a second time."""
        self._heard = {key: stamp_ns for key, stamp_ns in self._heard.items() if is_near(stamp_ns, now_ns)}
        key = datagram.sender, datagram.sequence
        if key in self._heard:
            return False
        if len(self._heard) < _MOST_REMEMBERED:  # what is more may count twice, which does little harm
            self._heard[key] = datagram.stamp_ns
        return True


class StopListener(asyncio.DatagramProtocol):
    """`on_stop` gets each new stop; whoever sent it is answered with the robot's `status` of the given number. `ignored` counts
    what was no stop. Answers have numbers of their own: among those of the server's statuses they would look lost there."""

    def __init__(
        self, key: bytes | None, clock: Clock, on_stop: Callable[[EmergencyStop], None], status: Callable[[int], Status]
    ) -> None:
        self.ignored = 0
        self._key, self._clock = key, clock
        self._on_stop, self._status = on_stop, status
        self._sequencer = Sequencer(clock.now_ns())
        self._replays = ReplayedStops()
        self._trouble = Trouble(_logger, "emergency stops by broadcast")
        self._transport: asyncio.DatagramTransport | None = None

    async def run(self, host: str, port: int) -> None:
        """Listens for ever; tries again while the port cannot be had."""
        try:
            while True:
                try:
                    await self.open(host, port)
                except OSError as error:
                    self._trouble.note(f"cannot listen on UDP {host}:{port}: {error}")
                else:
                    self._trouble.over()
                await self._clock.sleep(_RETRY_S)
        finally:
            self.close()

    async def open(self, host: str, port: int) -> None:
        """Listens on the port, which others may share; does nothing when it does already. OSError when it cannot be had."""
        if self._transport is not None and not self._transport.is_closing():
            return
        bound = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            bound.setblocking(False)
            bound.bind((host, port))
            loop = asyncio.get_running_loop()
            transport, _ = await loop.create_datagram_endpoint(lambda: self, sock=bound)
        except OSError:
            bound.close()
            raise
        self._transport = transport

    def close(self) -> None:
        if self._transport is not None:
            self._transport.close()

    def datagram_received(self, data: bytes, addr: tuple[str | int, int]) -> None:
        try:
            datagram = unpack(data, self._key)
        except DecodeError as error:
            self._ignore(addr, str(error))
            return
        stop = datagram.message
        if not isinstance(stop, EmergencyStop) or not stop.engaged:
            self._ignore(addr, "no emergency stop; a release does not come this way")
        elif not is_near(datagram.stamp_ns, self._clock.now_ns()):
            self._ignore(addr, "a stop of another time: recorded, or the clocks are far apart")
        else:
            if self._replays.is_new(datagram, self._clock.now_ns()):
                # A release must be able to exceed it, whatever the sender made up.
                epoch = min(stop.epoch, datagram.stamp_ns // 1_000_000)
                self._on_stop(stop.model_copy(update={"epoch": epoch}))
            self._answer(addr)  # also to the sender's repetitions, which make up for lost ones

    def error_received(self, exc: Exception) -> None:
        """Whoever asked has gone."""
        _logger.debug("the answer to a stop was not delivered: %s", exc)

    def _answer(self, addr: tuple[str | int, int]) -> None:
        status = self._status(self._sequencer.next())
        if self._transport is not None:
            self._transport.sendto(status_datagram(status, self._key), addr)

    def _ignore(self, addr: tuple[str | int, int], why: str) -> None:
        self.ignored += 1
        _logger.debug("ignored a datagram from %s: %s", addr, why)


def stop_host(host: str) -> str:
    """Where to listen for broadcasts: on the machine alone when the server is on it, else on every network."""
    return LOOPBACK_BROADCAST if host.startswith("127.") or host in ("::1", "localhost") else "0.0.0.0"  # noqa: S104


def is_near(stamp_ns: int, now_ns: int) -> bool:
    """Whether a stop of that time counts now."""
    return abs(now_ns - stamp_ns) <= MOST_OFF_S * 1e9
