"""People and pallets on the simulated floor: what should stand there; the simulated lab obeys. Durable."""

from protocol import keys
from protocol.clock import Clock
from protocol.messages import Event, EventLevel, SimulatedObject
from server.errors import ConflictError, NotFoundError
from server.repositories.documents import Documents, Store, Transaction

SIMULATED_OBJECTS = Documents(keys.SIMULATED_OBJECTS, SimulatedObject)


class SimulatedObjectRepository:
    """Simulated objects by id."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def all(self) -> dict[str, SimulatedObject]:
        return await self._store.all(SIMULATED_OBJECTS)

    async def put(self, item: SimulatedObject, actor: str, *, create: bool) -> SimulatedObject:
        """ConflictError when `create` and it exists."""

        async def work(transaction: Transaction) -> SimulatedObject:
            if create and await transaction.find(SIMULATED_OBJECTS, item.id) is not None:
                raise ConflictError(f"object {item.id!r} exists already")
            transaction.put(SIMULATED_OBJECTS, item.id, item)
            text = f"{actor} put {item.kind} {item.id} at ({item.x:.3f}, {item.y:.3f})"
            transaction.record(self._event(actor, "object_placed", text))
            return item

        return await self._store.transaction((SIMULATED_OBJECTS,), work)

    async def delete(self, object_id: str, actor: str) -> None:
        """NotFoundError when there is none."""

        async def work(transaction: Transaction) -> None:
            if not await transaction.exists(SIMULATED_OBJECTS, object_id):
                raise NotFoundError(f"there is no object {object_id!r}")
            transaction.delete(SIMULATED_OBJECTS, object_id)
            transaction.record(self._event(actor, "object_removed", f"{actor} removed {object_id}"))

        await self._store.transaction((SIMULATED_OBJECTS,), work)

    def _event(self, actor: str, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)
