"""Zones with a speed limit."""

from typing import Annotated

from fastapi import APIRouter, Path

from protocol.messages import SpeedZone
from server.access import Operator, Viewer
from server.context import Ctx
from server.errors import InvalidError
from server.routes.answers import refusals

router = APIRouter(prefix="/speed-zones", tags=["speed zones"])

_Id = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]


@router.get("", summary="All speed zones", responses=refusals())
async def list_speed_zones(_identity: Viewer, context: Ctx) -> list[SpeedZone]:
    """Those of the lab description too."""
    return list((await context.speed_zones.all()).values())


@router.post("", summary="Draw a speed zone", status_code=201, responses=refusals(409))
async def create_speed_zone(identity: Operator, zone: SpeedZone, context: Ctx) -> SpeedZone:
    """Robots in it slow down at once. Refused when the id is taken."""
    return await context.speed_zones.put(zone, identity.name, create=True)


@router.put("/{zone_id}", summary="Change a speed zone", responses=refusals(409))
async def put_speed_zone(identity: Operator, zone_id: _Id, zone: SpeedZone, context: Ctx) -> SpeedZone:
    """Replaces it as a whole, or draws it. Refused when it is part of the lab description."""
    if zone_id != zone.id:
        raise InvalidError(("body", "id"), f"the zone's id is {zone.id!r}, the address says {zone_id!r}")
    return await context.speed_zones.put(zone, identity.name, create=False)


@router.delete("/{zone_id}", summary="Delete a speed zone", status_code=204, responses=refusals(404, 409))
async def delete_speed_zone(identity: Operator, zone_id: _Id, context: Ctx) -> None:
    """Refused when it is part of the lab description."""
    await context.speed_zones.delete(zone_id, identity.name)
