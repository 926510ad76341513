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
    """The latch. Both changes are idempotent; each is told to all subscribers at once.

    Robots take a release only with a greater epoch than the engagement's. A record that is damaged or lost must not make
    the epochs start over, so they also grow with the clock (ms) and past `above`, the greatest that the caller knows of.
    """

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def get(self) -> EmergencyStop:
        """Released, with epoch 0, when it never was engaged."""
        return await read_emergency_stop(self._store)

    async def engage(self, stop: EmergencyStop) -> EmergencyStop:
        """Engages it as it was told to robots, with a greater epoch only if Redis knows of one as great; when it is engaged
        already, the first reason stays."""
        return await self._set(stop, above=stop.epoch - 1)

    async def release(self, actor: str, *, above: int = 0) -> EmergencyStop:
        return await self._set(EmergencyStop(engaged=False, by=actor), above)

    async def restore(self, stop: EmergencyStop) -> None:
        """Writes a stop that Redis did not have, unless it has something newer; a reason that it has stays."""

        async def work(transaction: Transaction) -> None:
            current = await read_emergency_stop(transaction)
            if current.epoch >= stop.epoch:
                return
            kept = current.engaged and current is not _DAMAGED
            new = current.model_copy(update={"epoch": stop.epoch}) if kept else stop
            transaction.publish(EMERGENCY_STOP, LAB_INSTANCE, new)
            if not kept:
                event = _event(stop)
                transaction.record(event.model_copy(update={"text": f"{event.text} (Redis did not have it)"}))

        await self._store.transaction((EMERGENCY_STOPS,), work)

    async def _set(self, wanted: EmergencyStop, above: int) -> EmergencyStop:
        async def work(transaction: Transaction) -> EmergencyStop:
            current = await read_emergency_stop(transaction)
            same = current.engaged == wanted.engaged
            if same and (wanted.engaged or current.epoch >= above):
                # Told again: a subscriber that missed the first word hears this one.
                transaction.publish(EMERGENCY_STOP, LAB_INSTANCE, current)
                return current
            new = wanted
            if wanted.epoch <= max(current.epoch, above):
                now_ns = self._clock.now_ns()
                epoch = newer_epoch(max(current.epoch, above), now_ns)
                new = wanted.model_copy(update={"epoch": epoch, "stamp_ns": now_ns})
            transaction.publish(EMERGENCY_STOP, LAB_INSTANCE, new)
            transaction.record(_event(new))
            return new

        return await self._store.transaction((EMERGENCY_STOPS,), work)


def newer_epoch(epoch: int, now_ns: int) -> int:
    """An epoch greater than this one and than all that were taken before now."""
    return max(epoch + 1, now_ns // 1_000_000)


def _event(stop: EmergencyStop) -> Event:
    if stop.engaged:
        text = f"{stop.by} engaged the emergency stop{': ' + stop.reason if stop.reason else ''}"
    else:
        text = f"{stop.by} released the emergency stop"
    return Event(
        stamp_ns=stop.stamp_ns,
        level=EventLevel.ERROR if stop.engaged else EventLevel.WARNING,
        source=stop.by,
        kind="emergency_stop" if stop.engaged else "emergency_stop_released",
        text=text,
    )
