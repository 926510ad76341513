"""The fleet-wide emergency stop: a latch in Redis (append-only, so it survives every restart) that only a person releases
(spec gpss, "Safety")."""

from protocol.channels import EMERGENCY_STOP, LAB_INSTANCE
from protocol.clock import Clock
from protocol.errors import DecodeError
from protocol.messages import EmergencyStop, Event, EventLevel
from server.repositories.documents import Store, Transaction, documents_of

EMERGENCY_STOPS = documents_of(EMERGENCY_STOP)
_DAMAGED = EmergencyStop(engaged=True, reason="what Redis holds of the emergency stop is damaged")
"""A latch that cannot be read counts as engaged, and a person can release it."""


async def read_emergency_stop(source: Store | Transaction) -> EmergencyStop:
    """The latch as Redis has it."""
    try:
        return await source.get(EMERGENCY_STOPS, LAB_INSTANCE) or EmergencyStop(engaged=False)
    except DecodeError:
        return _DAMAGED


class EmergencyStopRepository:
    """The latch. Both changes are idempotent; each is told to all subscribers at once."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def get(self) -> EmergencyStop:
        """Released, with epoch 0, when it never was engaged."""
        return await read_emergency_stop(self._store)

    async def engage(self, reason: str, actor: str) -> EmergencyStop:
        """Engages it; when it is engaged already, the first reason stays."""
        return await self._set(engaged=True, reason=reason, actor=actor)

    async def release(self, actor: str) -> EmergencyStop:
        return await self._set(engaged=False, reason="", actor=actor)

    async def _set(self, *, engaged: bool, reason: str, actor: str) -> EmergencyStop:
        async def work(transaction: Transaction) -> EmergencyStop:
            current = await read_emergency_stop(transaction)
            if current.engaged == engaged:
                # Told again: a subscriber that missed the first word hears this one.
                transaction.publish(EMERGENCY_STOP, LAB_INSTANCE, current)
                return current
            now_ns = self._clock.now_ns()
            new = EmergencyStop(engaged=engaged, epoch=current.epoch + 1, stamp_ns=now_ns, by=actor, reason=reason)
            transaction.publish(EMERGENCY_STOP, LAB_INSTANCE, new)
            transaction.record(
                Event(
                    stamp_ns=now_ns,
                    level=EventLevel.ERROR if engaged else EventLevel.WARNING,
                    source=actor,
                    kind="emergency_stop" if engaged else "emergency_stop_released",
                    text=f"{actor} engaged the emergency stop{': ' + reason if reason else ''}"
                    if engaged
                    else f"{actor} released the emergency stop",
                )
            )
            return new

        return await self._store.transaction((EMERGENCY_STOPS,), work)
