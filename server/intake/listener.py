"""Listens for robots' STATUS datagrams (design, "Robots connect over HTTP and UDP"): what is one of ours and signed goes to the
intake, the rest is counted, and now and then told in the history."""

import asyncio
import socket
import sys
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager, suppress

from protocol.bus import Bus
from protocol.clock import Clock
from protocol.datagram import Kind, unpack
from protocol.errors import DecodeError
from protocol.lab import Lab
from protocol.messages import IntakeState
from protocol.messages.status_fields import read_status
from server.intake.statuses import StatusIntake

_AT_ONCE = 256
"""So many datagrams are taken before others on the loop have their turn."""
_GATHER_S = 0.005
"""So long after datagrams were taken the next are looked for. Robots' statuses wait for the next batch anyway, and to wake up for
each of ten thousand a second took more processor time than to read it."""
_LARGEST = 4096
"""More than any of ours has: what is cut off here is refused for its length."""
_QUEUE_BYTES = 4 << 20
"""Datagrams wait here while the loop is busy: what a thousand robots send in half a second, as the kernel counts it. Who is not
the administrator gets less where the kernel's limit (net.core.rmem_max) is lower."""
_READERS = {Kind.STATUS: read_status}
_SO_RCVBUFFORCE = 33
"""Linux's, from socket(7); the socket module does not have it."""


class StatusListener:
    """`state` tells how many datagrams were received, accepted, and refused for which cause; `run` must be running."""

    def __init__(self, bus: Bus, lab: Lab, clock: Clock, key: bytes | None) -> None:
        self._key, self._clock = key, clock
        self._intake = StatusIntake(bus, lab, clock)

    @asynccontextmanager
    async def listening(self, bound: socket.socket) -> AsyncGenerator[None]:
        """Listens on the bound socket while entered, and closes it."""
        bound.setblocking(False)
        _widen(bound)
        taking = asyncio.create_task(self._take_all(bound))
        try:
            yield
        finally:
            taking.cancel()
            await asyncio.wait([taking])
            bound.close()

    def forget(self, robot: str) -> None:
        """Lets a robot start over, as after a registration with a clock that was set back."""
        self._intake.forget(robot)

    def state(self) -> IntakeState:
        """The counters, the newest refusal, and how well each robot is heard."""
        counts = self._intake.counts
        return IntakeState(
            stamp_ns=self._clock.now_ns(),
            received=counts["received"],
            accepted=counts["accepted"],
            undecodable=counts["undecodable"],
            wrong_kind=counts["wrong_kind"],
            unknown_robot=counts["unknown_robot"],
            wrong_sender=counts["wrong_sender"],
            old=counts["old"],
            future=counts["future"],
            duplicate=counts["duplicate"],
            out_of_order=counts["out_of_order"],
            last_problem=self._intake.problem,
            losses=self._intake.losses(),
        )

    async def _take_all(self, bound: socket.socket) -> None:
        """Not by a datagram endpoint: that has a round of the loop, and the process a wake-up, for every datagram."""
        while True:
            await _readable(bound)
            while self._drain(bound):
                await self._clock.sleep(_GATHER_S)

    def _drain(self, bound: socket.socket) -> int:
        """Takes what has arrived; how many."""
        receive, take = bound.recvfrom, self.datagram_received
        for count in range(_AT_ONCE):
            try:
                data, address = receive(_LARGEST)
            except (BlockingIOError, InterruptedError):
                return count
            except OSError as error:
                self._intake.problem = f"socket: {error}"
                return count
            take(data, address)
        return _AT_ONCE

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        """Of one robot, or of anybody."""
        self._intake.counts["received"] += 1
        origin = f"{addr[0]}:{addr[1]}"
        try:
            datagram = unpack(data, self._key, _READERS)
        except DecodeError as error:
            self._intake.refuse("undecodable", f"datagram from {origin}: {error}")
        else:
            self._intake.offer(datagram, origin)

    async def run(self) -> None:
        """Publishes what came in, until cancelled."""
        await self._intake.run()


async def _readable(bound: socket.socket) -> None:
    loop, readable = asyncio.get_running_loop(), asyncio.Event()
    loop.add_reader(bound, readable.set)
    try:
        await readable.wait()
    finally:
        loop.remove_reader(bound)


def _widen(bound: socket.socket) -> None:
    bound.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _QUEUE_BYTES)
    if sys.platform == "linux":
        with suppress(PermissionError):
            bound.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, _QUEUE_BYTES)
