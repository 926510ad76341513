"""People and pallets on the simulated floor, and faults of its cameras."""

from typing import Annotated

from fastapi import APIRouter, Path

from protocol.messages import CameraFault, SimulatedObject
from server.access import Operator, Viewer
from server.context import Context, Ctx
from server.errors import InvalidError, NotFoundError
from server.routes.answers import refusals

router = APIRouter(prefix="/sim", tags=["simulation"])

_Id = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$", examples=["pallet-1"])]
_CameraId = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$", examples=["cam0"])]


@router.get("/objects", summary="Simulated objects", responses=refusals(404))
async def list_simulated_objects(_identity: Viewer, context: Ctx) -> list[SimulatedObject]:
    """What was put on the simulated floor, by id; 404 where nothing is simulated."""
    _require_simulation(context)
    return list((await context.objects.all()).values())


@router.post("/objects", summary="Put an object down", status_code=201, responses=refusals(404, 409))
async def create_simulated_object(identity: Operator, item: SimulatedObject, context: Ctx) -> SimulatedObject:
    """Refused when the id is taken."""
    _require_simulation(context)
    return await context.objects.put(item, identity.name, create=True)


@router.put("/objects/{object_id}", summary="Move an object", responses=refusals(404))
async def put_simulated_object(
    identity: Operator, object_id: _Id, item: SimulatedObject, context: Ctx
) -> SimulatedObject:
    """Replaces it as a whole, or puts it down."""
    _require_simulation(context)
    if item.id != object_id:
        raise InvalidError(("body", "id"), f"the object's id is {item.id!r}, the address says {object_id!r}")
    return await context.objects.put(item, identity.name, create=False)


@router.delete("/objects/{object_id}", summary="Take an object away", status_code=204, responses=refusals(404))
async def delete_simulated_object(identity: Operator, object_id: _Id, context: Ctx) -> None:
    """Takes it off the floor."""
    _require_simulation(context)
    await context.objects.delete(object_id, identity.name)


@router.put("/cameras/{camera_id}/fault", summary="Have a camera suffer a fault", responses=refusals(404))
async def put_camera_fault(identity: Operator, camera_id: _CameraId, fault: CameraFault, context: Ctx) -> CameraFault:
    """A simulated camera stalls, is unplugged, sends garbage, is covered or bumped, until the fault is taken back; shown as
    the camera's `fault`. 404 for a camera that is not simulated."""
    return await context.faults.put(camera_id, fault, identity.name)


@router.delete("/cameras/{camera_id}/fault", summary="End a camera's fault", status_code=204, responses=refusals(404))
async def delete_camera_fault(identity: Operator, camera_id: _CameraId, context: Ctx) -> None:
    """The camera is as it was before; one that was bumped is moved back."""
    await context.faults.delete(camera_id, identity.name)


def _require_simulation(context: Context) -> None:
    if not context.lab.has_simulation:
        raise NotFoundError(f"nothing is simulated in lab {context.lab.name!r}")
