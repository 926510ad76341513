"""Sends an emergency stop to every robot by UDP broadcast and listens for who holds it (docs/architecture.md, "The order of a
robot"). Needs neither the server nor Redis, only the key of the datagrams."""

import asyncio
import fcntl
import secrets
import socket
import struct
from collections.abc import Collection, Sequence

from protocol.clock import Clock
from protocol.datagram import Datagram, Sequencer, pack, unpack
from protocol.errors import DecodeError
from protocol.messages import EmergencyStop, Status

REPEAT_S = (0.0, 0.05, 0.1, 0.2, 0.4, 0.8)
"""When the same datagram goes out: a network that loses a third of them loses all six of a robot in 1 of 1,400 cases."""
PATIENCE_S = 2.0
_GET_BROADCAST = 0x8919
"""Linux' SIOCGIFBRDADDR."""


class StopBroadcast(asyncio.DatagramProtocol):
    """`answers` are the newest statuses of robots that hold the stop; `failures` say why nothing at all could be sent to an
    address."""

    def __init__(self, key: bytes | None, clock: Clock, expected: Collection[str]) -> None:
        self.answers: dict[str, Status] = {}
        self.failures: dict[str, str] = {}
        self._key, self._clock = key, clock
        self._expected = frozenset(expected)
        self._complete = asyncio.Event()
        self._sending = False
        self._failed: OSError | None = None

    async def send(self, stop: EmergencyStop, targets: Sequence[tuple[str, int]], host: str = "0.0.0.0") -> None:  # noqa: S104
        """Sends the stop to all targets, again and again, until every expected robot has answered, or patience is over. What
        cannot be sent is among the failures."""
        try:
            transport = await self._open(host)
        except OSError as error:
            self.failures = {address: error.strerror or str(error) for address, _ in targets}
            return
        now_ns = self._clock.now_ns()
        sender = f"stop-{secrets.token_hex(4)}"
        data = pack(Datagram(sender, Sequencer(now_ns).next(), now_ns, stop), self._key)
        try:
            sending = asyncio.ensure_future(self._repeat(transport, data, targets))
            try:
                async with asyncio.timeout(PATIENCE_S):
                    await self._complete.wait()
            except TimeoutError:
                pass
            finally:
                sending.cancel()
        finally:
            transport.close()
            await self._clock.sleep(0)  # one round of the loop, in which the socket is really closed

    def datagram_received(self, data: bytes, addr: tuple[str | int, int]) -> None:  # noqa: ARG002
        try:
            status = unpack(data, self._key).message
        except DecodeError:
            return  # a stranger's
        if isinstance(status, Status) and status.stop_epoch is not None:
            self.answers[status.robot] = status
            if self._expected and self._expected <= self.answers.keys():
                self._complete.set()

    def error_received(self, exc: Exception) -> None:
        """The transport raises nothing when it cannot send, but calls this before `sendto` returns. At any other time nobody
        listens at one of the addresses; who did not answer is told in the end."""
        if self._sending and isinstance(exc, OSError):
            self._failed = exc

    async def _open(self, host: str) -> asyncio.DatagramTransport:
        transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(
            lambda: self, local_addr=(host, 0), family=socket.AF_INET, allow_broadcast=True
        )
        return transport

    async def _repeat(
        self, transport: asyncio.DatagramTransport, data: bytes, targets: Sequence[tuple[str, int]]
    ) -> None:
        sent_s, reached = 0.0, set[str]()
        for at_s in REPEAT_S:
            await self._clock.sleep(at_s - sent_s)
            sent_s = at_s
            for address, port in targets:
                error = self._sent(transport, data, address, port)
                if error is None:
                    reached.add(address)
                    self.failures.pop(address, None)
                elif address not in reached:
                    self.failures[address] = error.strerror or str(error)

    def _sent(self, transport: asyncio.DatagramTransport, data: bytes, address: str, port: int) -> OSError | None:
        """None, or why not: one network that is down must not keep the others from hearing it."""
        self._sending, self._failed = True, None
        try:
            transport.sendto(data, (address, port))
        except OSError as error:
            return error
        finally:
            self._sending = False
        return self._failed


def broadcast_addresses() -> list[str]:
    """Of every network of this machine, the loopback's first: robots may be simulated on this machine."""
    found = ["127.255.255.255"]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for _, name in socket.if_nameindex():
            request = struct.pack("256s", name.encode()[:15])
            try:
                answer = fcntl.ioctl(probe.fileno(), _GET_BROADCAST, request)
            except OSError:
                continue  # no address, or no broadcasts there
            address = socket.inet_ntoa(answer[20:24])
            if address not in (*found, "0.0.0.0"):  # noqa: S104
                found.append(address)
    return found
