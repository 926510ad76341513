"""Takes robots' statuses, whichever way they came: checks who, when and in which order, publishes the newest of each robot in
batches. What is refused is counted and, now and then, told in the history."""

import asyncio
import logging
from collections import Counter

from protocol.bus import Bus
from protocol.channels import STATUSES
from protocol.clock import Clock
from protocol.codec import encode
from protocol.datagram import Datagram, ReplayGuard, Verdict
from protocol.lab import Lab
from protocol.loss import LossWatch
from protocol.messages import Event, EventLevel, Status
from protocol.messages.status_fields import StatusFields
from server.repositories.history import record

_BATCH_S = 0.05
_TOLD_EVERY_S = 60.0
_NORMAL = (Verdict.DUPLICATE.value, Verdict.OUT_OF_ORDER.value)
"""Networks do these by themselves; they are counted, not told."""
_STATUSES = (StatusFields, Status)
_logger = logging.getLogger(__name__)


class StatusIntake:
    """`counts` holds how many were received, accepted, and refused for which cause; `problem` is the newest refusal in a
    sentence. Events are from `source`, of kinds that begin with `what`."""

    def __init__(self, bus: Bus, lab: Lab, clock: Clock, source: str = "intake", what: str = "datagram") -> None:
        self.counts: Counter[str] = Counter()
        self.problem: str | None = None
        self._bus, self._clock, self._source, self._what = bus, clock, source, what
        self._robots = frozenset(vehicle.id for vehicle in lab.vehicles)
        self._guard = ReplayGuard()
        self._pending: dict[str, bytes] = {}
        self._filled = asyncio.Event()
        self._losses: dict[str, LossWatch] = {}
        self._told_s: dict[str, float] = {}
        self._untold: list[Event] = []

    def forget(self, robot: str) -> None:
        """Lets a robot start over, as after a registration with a clock that was set back."""
        self._guard.forget(robot)

    def losses(self) -> dict[str, float]:
        """By robot: the share of its statuses of the last seconds that did not arrive, rounded to per cent."""
        now_s = self._clock.monotonic_s()
        shares = {robot: watch.share(now_s) for robot, watch in self._losses.items()}
        return {robot: round(share, 2) for robot, share in shares.items() if share is not None}

    def offer(self, datagram: Datagram, origin: str) -> None:
        """Takes the status in the envelope, or refuses it; `origin` is where it came from, for people."""
        status, sender = datagram.message, datagram.sender
        if not isinstance(status, _STATUSES):
            return self.refuse("wrong_kind", f"{type(status).__name__} datagram of {sender!r} from {origin}")
        if status.robot != sender:
            text = f"status of {status.robot!r} sent as {sender!r} from {origin}"
            return self.refuse("wrong_sender", text)
        # Strangers end here, before anything is remembered of them.
        if sender not in self._robots:
            return self.refuse("unknown_robot", f"status for unknown robot {sender!r} from {origin}")
        verdict = self._guard.check(datagram, self._clock.now_ns())
        if verdict is not Verdict.FRESH:
            return self.refuse(verdict.value, f"status of {sender} from {origin} is {verdict.value.replace('_', ' ')}")
        self.counts["accepted"] += 1
        losses = self._losses.get(sender)
        if losses is None:
            losses = self._losses[sender] = LossWatch()
        losses.add(datagram.sequence, self._clock.monotonic_s())
        self._pending[sender] = datagram.payload or encode(status)
        self._filled.set()
        return None

    def refuse(self, cause: str, text: str) -> None:
        """Counts it; unusual causes are told, each at most once a minute."""
        self.counts[cause] += 1
        self.problem = text
        now_s = self._clock.monotonic_s()
        if cause in _NORMAL or now_s < self._told_s.get(cause, -1e9) + _TOLD_EVERY_S:
            return
        self._told_s[cause] = now_s
        _logger.warning("refused: %s", text)
        self._untold.append(
            Event(
                stamp_ns=self._clock.now_ns(),
                level=EventLevel.WARNING,
                source=self._source,
                kind=f"{self._what}_{cause}",
                text=f"refused: {text}"[:500],
            )
        )
        self._filled.set()

    async def run(self) -> None:
        """Publishes what came in, newest of each robot, at most 20 times a second; until cancelled."""
        while True:
            await self._filled.wait()
            self._filled.clear()
            if self._pending:
                batch, self._pending = self._pending, {}
                await self._bus.publish_raw(STATUSES, batch)
            untold, self._untold = self._untold, []
            for event in untold:
                await record(self._bus, event)
            await self._clock.sleep(_BATCH_S)
