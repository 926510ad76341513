"""The lab description as a whole, cross-checked: ids are unique, references resolve, no tag means two things."""

from collections.abc import Iterator
from typing import Annotated, Self

from pydantic import Field, ValidationInfo, model_validator

from protocol.lab.base import Identifier, LabModel
from protocol.lab.devices import (
    ROS2_DRIVER,
    Accuracy,
    Area,
    CameraSpec,
    FloorTags,
    Outputs,
    Ports,
    SpeedZoneSpec,
    VehicleSpec,
    ZoneSpec,
)
from protocol.lab.simulation import Simulation

Location = tuple[str | int, ...]
"""Where in the document: keys and list indices from the root."""


class Lab(LabModel):
    """Everything that exists, cross-checked: ids are unique, references resolve, no tag means two things."""

    name: Identifier
    areas: Annotated[tuple[Area, ...], Field(min_length=1)]
    cameras: tuple[CameraSpec, ...] = ()
    floor_tags: FloorTags
    vehicles: tuple[VehicleSpec, ...] = ()
    zones: tuple[ZoneSpec, ...] = ()
    speed_zones: tuple[SpeedZoneSpec, ...] = ()
    accuracy: Accuracy = Accuracy()
    outputs: Outputs = Outputs()
    ports: Ports = Ports()
    simulation: Simulation = Simulation()

    @model_validator(mode="after")
    def _cross_check(self, info: ValidationInfo) -> Self:
        """Collects problems into the context's list when there is one (so that a loader can name lines), else raises."""
        context = info.context or {}
        problems = list(_cross_problems(self, recorded=context.get("recorded", False)))
        collected = context.get("problems")
        if collected is not None:
            collected.extend(problems)
        elif problems:
            raise ValueError("; ".join(what for _, what in problems))
        return self

    def camera(self, camera_id: str) -> CameraSpec:
        """The camera of that id; KeyError when there is none."""
        for camera in self.cameras:
            if camera.id == camera_id:
                return camera
        raise KeyError(f"no camera {camera_id!r} in the lab description")

    def vehicle(self, vehicle_id: str) -> VehicleSpec:
        """The vehicle of that id; KeyError when there is none."""
        for vehicle in self.vehicles:
            if vehicle.id == vehicle_id:
                return vehicle
        raise KeyError(f"no vehicle {vehicle_id!r} in the lab description")

    def area_at(self, x: float, y: float) -> Area | None:
        """The first area that contains the point (metres, map frame)."""
        return next((area for area in self.areas if area.contains(x, y)), None)

    def bounds(self) -> tuple[float, float, float, float]:
        """min x, min y, max x, max y of all areas, in metres."""
        xs = [x for area in self.areas for x, _ in area.outline]
        ys = [y for area in self.areas for _, y in area.outline]
        return min(xs), min(ys), max(xs), max(ys)

    @property
    def has_simulation(self) -> bool:
        """Whether any camera or vehicle is simulated."""
        return any(c.source == "sim" for c in self.cameras) or any(v.driver == "sim" for v in self.vehicles)


def _cross_problems(lab: Lab, *, recorded: bool) -> Iterator[tuple[Location, str]]:
    for section, ids in (
        ("areas", [a.id for a in lab.areas]),
        ("cameras", [c.id for c in lab.cameras]),
        ("vehicles", [v.id for v in lab.vehicles]),
        ("zones", [z.id for z in lab.zones]),
        ("speed_zones", [z.id for z in lab.speed_zones]),
    ):
        for index, name in enumerate(ids):
            if name in ids[:index]:
                yield (section, index, "id"), f"id {name!r} is used twice in {section}"
    areas = {area.id for area in lab.areas}
    for index, camera in enumerate(lab.cameras):
        if camera.area not in areas:
            yield (
                ("cameras", index, "area"),
                f"camera {camera.id!r} is in area {camera.area!r}, which does not exist (areas: {_listed(areas)})",
            )
        if camera.source == "sim" and camera.id not in lab.simulation.mounts and not recorded:
            yield ("cameras", index, "source"), f"simulated camera {camera.id!r} has no entry in simulation.mounts"
    yield from _tag_clashes(lab)
    yield from _ros2_clashes(lab)
    known_cameras, known_vehicles = {c.id for c in lab.cameras}, {v.id for v in lab.vehicles}
    for name in lab.simulation.mounts:
        if name not in known_cameras:
            yield (
                ("simulation", "mounts", name),
                f"mount for unknown camera {name!r} (cameras: {_listed(known_cameras)})",
            )
    for name in lab.simulation.starts:
        if name not in known_vehicles:
            yield (
                ("simulation", "starts", name),
                f"start for unknown vehicle {name!r} (vehicles: {_listed(known_vehicles)})",
            )
    yield from _tour_problems(lab)


def _tour_problems(lab: Lab) -> Iterator[tuple[Location, str]]:
    simulated = {vehicle.id for vehicle in lab.vehicles if vehicle.driver == "sim"}
    for name, points in lab.simulation.tours.items():
        if name not in simulated:
            yield (
                ("simulation", "tours", name),
                f"tour for {name!r}, which is no simulated vehicle ({_listed(simulated)})",
            )
        for index, (x, y) in enumerate(points):
            if lab.area_at(x, y) is None:
                yield ("simulation", "tours", name, index), f"({x:g}, {y:g}) lies outside every area"


def _tag_clashes(lab: Lab) -> Iterator[tuple[Location, str]]:
    """A family and id may mean one thing only: one floor tag or one vehicle (spec localization, "The room")."""
    owners = {(lab.floor_tags.family, tag_id): f"floor tag {tag_id}" for tag_id in lab.floor_tags.poses}
    for index, vehicle in enumerate(lab.vehicles):
        key = (vehicle.tag.family, vehicle.tag.id)
        if key in owners:
            yield (
                ("vehicles", index, "tag", "id"),
                f"{key[0]} id {key[1]} is used by both {owners[key]} and vehicle {vehicle.id!r}",
            )
        owners[key] = f"vehicle {vehicle.id!r}"


def _ros2_clashes(lab: Lab) -> Iterator[tuple[Location, str]]:
    """Two vehicles that command one base would each be right about its brakes and wrong about its way. A domain that is left
    out is ROS_DOMAIN_ID's, so it may be any other's."""
    before: list[tuple[str, int | None, str]] = []
    for index, vehicle in enumerate(lab.vehicles):
        if vehicle.driver != ROS2_DRIVER:
            continue
        name, domain = vehicle.ros2_namespace, None if vehicle.ros2 is None else vehicle.ros2.domain
        for other, others_domain, id_ in before:
            if other == name and (domain == others_domain or domain is None or others_domain is None):
                yield (
                    ("vehicles", index, "id"),
                    f"vehicles {id_!r} and {vehicle.id!r} are both the ROS 2 base /{name}, maybe in one DDS domain: give each "
                    "a ros2.namespace or a ros2.domain of its own",
                )
                break
        before.append((name, domain, vehicle.id))


def _listed(names: set[str]) -> str:
    return ", ".join(sorted(names)) or "none"
