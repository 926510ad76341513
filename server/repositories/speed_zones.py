"""Zones with a speed limit that operators draw, beside those of the lab description; durable."""

from shapely.geometry import Polygon

from protocol import keys
from protocol.clock import Clock
from protocol.lab import Lab
from protocol.messages import Event, EventLevel, SpeedZone
from server.errors import ConflictError, InvalidError, NotFoundError
from server.repositories.documents import Documents, Store, Transaction

SPEED_ZONES = Documents(keys.SPEED_ZONES, SpeedZone)


def speed_zones_of(lab: Lab) -> dict[str, SpeedZone]:
    """Those of the lab description, by id."""
    return {z.id: SpeedZone(id=z.id, outline=z.outline, speed_mps=z.speed_mps) for z in lab.speed_zones}


class SpeedZoneRepository:
    """Speed zones by id. Those of the lab description are there too, and stay as they are."""

    def __init__(self, store: Store, lab: Lab, clock: Clock) -> None:
        self._store, self._clock = store, clock
        self._fixed = speed_zones_of(lab)

    async def all(self) -> dict[str, SpeedZone]:
        return {**await self._store.all(SPEED_ZONES), **self._fixed}

    async def put(self, zone: SpeedZone, actor: str, *, create: bool) -> SpeedZone:
        """Writes the zone. InvalidError when its outline crosses itself or has no inside; ConflictError when `create` and it
        exists, and when the lab description has one of that id."""
        polygon = Polygon(zone.outline)
        if not polygon.is_valid or polygon.area <= 0:
            raise InvalidError(("body", "outline"), "the outline is not a simple polygon with an inside")
        self._require_ours(zone.id)

        async def work(transaction: Transaction) -> SpeedZone:
            if create and await transaction.exists(SPEED_ZONES, zone.id):
                raise ConflictError(f"speed zone {zone.id!r} exists already")
            transaction.put(SPEED_ZONES, zone.id, zone)
            text = f"{actor} limited the speed in zone {zone.id} to {zone.speed_mps:g} m/s"
            transaction.record(self._event(actor, "speed_zone_changed", text))
            return zone

        return await self._store.transaction((SPEED_ZONES,), work)

    async def delete(self, zone_id: str, actor: str) -> None:
        """NotFoundError when there is none, ConflictError when it is the lab description's."""
        self._require_ours(zone_id)

        async def work(transaction: Transaction) -> None:
            if not await transaction.exists(SPEED_ZONES, zone_id):
                raise NotFoundError(f"there is no speed zone {zone_id!r}")
            transaction.delete(SPEED_ZONES, zone_id)
            transaction.record(self._event(actor, "speed_zone_deleted", f"{actor} deleted speed zone {zone_id}"))

        await self._store.transaction((SPEED_ZONES,), work)

    def _require_ours(self, zone_id: str) -> None:
        if zone_id in self._fixed:
            raise ConflictError(f"speed zone {zone_id!r} is part of the lab description; change it there")

    def _event(self, actor: str, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)
