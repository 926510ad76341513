"""The intake: robots' STATUS datagrams in, `statuses` out, and once a second what became of the datagrams (`intake`), from which
the server has its health and how well each robot is heard."""

import socket
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import aclosing, asynccontextmanager
from typing import cast

from protocol.bus import Bus
from protocol.channels import INTAKE, LAB_INSTANCE, REGISTRATIONS
from protocol.clock import Clock
from protocol.lab import Lab
from protocol.messages import IntakeState, Registration
from server.intake.listener import StatusListener


class IntakeService:
    """`parts` must be running, each until cancelled; one that fails may be begun again."""

    def __init__(self, lab: Lab, bus: Bus, clock: Clock, key: bytes | None) -> None:
        self._bus, self._clock = bus, clock
        self._listener = StatusListener(bus, lab, clock, key)
        self._sessions: dict[str, str] = {}

    @asynccontextmanager
    async def listening(self, bound: socket.socket) -> AsyncGenerator[None]:
        """Listens on the bound socket while entered, and closes it."""
        async with self._listener.listening(bound):
            yield

    def parts(self) -> tuple[Callable[[], Awaitable[None]], ...]:
        """What has to run beside each other."""
        return self._listener.run, self.follow_registrations, self.report

    def state(self) -> IntakeState:
        """What became of the datagrams until now."""
        return self._listener.state()

    async def follow_registrations(self) -> None:
        """Lets robots start over that registered anew: their clocks may have been set back meanwhile."""
        async with aclosing(self._bus.subscribe(REGISTRATIONS)) as said:
            async for received in said:
                registration = cast("Registration", received.message)
                known = self._sessions.get(registration.robot)
                if known != registration.session:
                    self._sessions[registration.robot] = registration.session
                    self._listener.forget(registration.robot)

    async def report(self) -> None:
        """Tells the others."""
        while True:
            await self._bus.publish(INTAKE, LAB_INSTANCE, self.state())
            await self._clock.sleep(1.0 / INTAKE.rate_hz)

    def describe(self) -> str:
        """What came in and what was refused, for the log."""
        state = self.state()
        return f"{state.received} datagrams received, {state.accepted} accepted; {state.last_problem or 'none refused'}"
