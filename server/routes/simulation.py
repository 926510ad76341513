"""People and pallets on the simulated floor."""

from typing import Annotated

from fastapi import APIRouter, Path

from protocol.messages import SimulatedObject
from server.access import Operator, Viewer
from server.context import Context, Ctx
from server.errors import InvalidError, NotFoundError
from server.routes.answers import refusals

router = APIRouter(prefix="/sim/objects", tags=["simulation"])

_Id = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$", examples=["pallet-1"])]


@router.get("", summary="Simulated objects", responses=refusals(404))
async def list_simulated_objects(_identity: Viewer, context: Ctx) -> list[SimulatedObject]:
    """What was put on the simulated floor, by id; 404 where nothing is simulated."""
    _require_simulation(context)
    return list((await context.objects.all()).values())


@router.post("", summary="Put an object down", status_code=201, responses=refusals(404, 409))
async def create_simulated_object(identity: Operator, item: SimulatedObject, context: Ctx) -> SimulatedObject:
    """Refused when the id is taken."""
    _require_simulation(context)
    return await context.objects.put(item, identity.name, create=True)


@router.put("/{object_id}", summary="Move an object", responses=refusals(404))
async def put_simulated_object(
    identity: Operator, object_id: _Id, item: SimulatedObject, context: Ctx
) -> SimulatedObject:
    """Replaces it as a whole, or puts it down."""
    _require_simulation(context)
    if item.id != object_id:
        raise InvalidError(("body", "id"), f"the object's id is {item.id!r}, the address says {object_id!r}")
    return await context.objects.put(item, identity.name, create=False)


@router.delete("/{object_id}", summary="Take an object away", status_code=204, responses=refusals(404))
async def delete_simulated_object(identity: Operator, object_id: _Id, context: Ctx) -> None:
    """Takes it off the floor."""
    _require_simulation(context)
    await context.objects.delete(object_id, identity.name)


def _require_simulation(context: Context) -> None:
    if not context.lab.has_simulation:
        raise NotFoundError(f"nothing is simulated in lab {context.lab.name!r}")
