"""The lab description as it may be shown: without the simulation's truth and without the cameras' passwords."""

from protocol.lab import Area, CameraSpec, FloorTags, Lab, Ports, VehicleSpec, ZoneSpec
from protocol.lab.address import without_password
from server.views.base import View


class LabView(View):
    """What exists in the lab. `bounds` is min x, min y, max x, max y of all areas, in metres."""

    name: str
    areas: tuple[Area, ...]
    cameras: tuple[CameraSpec, ...]
    floor_tags: FloorTags
    vehicles: tuple[VehicleSpec, ...]
    zones: tuple[ZoneSpec, ...]
    ports: Ports
    bounds: tuple[float, float, float, float]
    simulated: bool


def lab_view(lab: Lab) -> LabView:
    """The view of a lab."""
    return LabView(
        name=lab.name,
        areas=lab.areas,
        cameras=tuple(c.model_copy(update={"source": without_password(c.source)}) for c in lab.cameras),
        floor_tags=lab.floor_tags,
        vehicles=lab.vehicles,
        zones=lab.zones,
        ports=lab.ports,
        bounds=lab.bounds(),
        simulated=lab.has_simulation,
    )
