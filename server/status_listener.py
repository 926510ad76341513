"""Listens for robots' STATUS datagrams, checks them, and publishes the newest of each robot in batches (design, "Robots
connect over HTTP and UDP"). What is refused is counted, told in the health, and now and then in the history."""

import asyncio
import logging
import socket
from collections import Counter
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from typing import cast

from protocol.bus import Bus
from protocol.channels import STATUSES
from protocol.clock import Clock
from protocol.datagram import ReplayGuard, Verdict, unpack
from protocol.errors import DecodeError
from protocol.lab import Lab
from protocol.messages import Event, EventLevel, Status
from server.repositories.history import record
from server.views.health import UdpView

_BATCH_S = 0.05
_TOLD_EVERY_S = 60.0
_NORMAL = (Verdict.DUPLICATE.value, Verdict.OUT_OF_ORDER.value)
"""Networks do these by themselves; they are counted, not told."""
_logger = logging.getLogger(__name__)


class StatusListener(asyncio.DatagramProtocol):
    """`counts` holds how many datagrams were received, accepted, and refused for which cause."""

    def __init__(self, bus: Bus, lab: Lab, clock: Clock, key: bytes | None) -> None:
        self.counts: Counter[str] = Counter()
        self.port = lab.ports.robots_udp
        self._bus, self._clock, self._key = bus, clock, key
        self._robots = frozenset(vehicle.id for vehicle in lab.vehicles)
        self._guard = ReplayGuard()
        self._pending: dict[str, Status] = {}
        self._filled = asyncio.Event()
        self._told_s: dict[str, float] = {}
        self._problem: str | None = None
        self._untold: list[Event] = []
        self._listening = False

    @asynccontextmanager
    async def listening(self, bound: socket.socket) -> AsyncGenerator[None]:
        """Listens on the bound socket while entered, and closes it."""
        loop = asyncio.get_running_loop()
        transport, _ = await loop.create_datagram_endpoint(lambda: self, sock=bound)
        self.port = cast("tuple[str, int]", bound.getsockname())[1]
        self._listening = True
        try:
            yield
        finally:
            self._listening = False
            transport.close()

    def forget(self, robot: str) -> None:
        """Lets a robot start over, as after a registration with a clock that was set back."""
        self._guard.forget(robot)

    def view(self) -> UdpView:
        """The counters, for the health."""
        counts = self.counts
        return UdpView(
            listening=self._listening,
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
            last_problem=self._problem,
        )

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        self.counts["received"] += 1
        origin = f"{addr[0]}:{addr[1]}"
        try:
            datagram = unpack(data, self._key)
        except DecodeError as error:
            return self._refuse("undecodable", f"datagram from {origin}: {error}")
        status, sender = datagram.message, datagram.sender
        if not isinstance(status, Status):
            return self._refuse("wrong_kind", f"{type(status).__name__} datagram of {sender!r} from {origin}")
        if status.robot != sender:
            text = f"status of {status.robot!r} sent as {sender!r} from {origin}"
            return self._refuse("wrong_sender", text)
        # Strangers end here, before anything is remembered of them.
        if sender not in self._robots:
            return self._refuse("unknown_robot", f"status for unknown robot {sender!r} from {origin}")
        verdict = self._guard.check(datagram, self._clock.now_ns())
        if verdict is not Verdict.FRESH:
            return self._refuse(verdict.value, f"status of {sender} from {origin} is {verdict.value.replace('_', ' ')}")
        self.counts["accepted"] += 1
        self._pending[sender] = status
        self._filled.set()
        return None

    def error_received(self, exc: Exception) -> None:
        self._problem = f"socket: {exc}"

    async def run(self) -> None:
        """Publishes what came in, newest of each robot, at most 20 times a second; until cancelled."""
        while True:
            await self._filled.wait()
            self._filled.clear()
            if self._pending:
                batch, self._pending = self._pending, {}
                await self._bus.publish_all(STATUSES, batch)
            untold, self._untold = self._untold, []
            for event in untold:
                await record(self._bus, event)
            await self._clock.sleep(_BATCH_S)

    def _refuse(self, cause: str, text: str) -> None:
        self.counts[cause] += 1
        self._problem = text
        now_s = self._clock.monotonic_s()
        if cause in _NORMAL or now_s < self._told_s.get(cause, -1e9) + _TOLD_EVERY_S:
            return
        self._told_s[cause] = now_s
        _logger.warning("refused: %s", text)
        self._untold.append(
            Event(
                stamp_ns=self._clock.now_ns(),
                level=EventLevel.WARNING,
                source="server",
                kind=f"datagram_{cause}",
                text=f"refused: {text}"[:500],
            )
        )
        self._filled.set()
