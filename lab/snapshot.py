"""One instant of the simulated floor, as the renderer and the sensors see it: immutable, so that a thread may draw it
while the world goes on."""

from dataclasses import dataclass
from typing import Literal

ObjectKind = Literal["person", "pallet"]


@dataclass(frozen=True, slots=True)
class VehicleSnapshot:
    """A vehicle's rotation centre (m, rad, map frame) and its true twist (m/s, rad/s)."""

    id: str
    x: float
    y: float
    yaw: float
    linear_mps: float
    angular_radps: float


@dataclass(frozen=True, slots=True)
class ObjectSnapshot:
    """Something on the floor: its centre (m), heading (rad) and speed along it (m/s)."""

    id: str
    kind: ObjectKind
    x: float
    y: float
    yaw: float
    speed_mps: float


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The floor at `stamp_ns`."""

    stamp_ns: int
    vehicles: tuple[VehicleSnapshot, ...]
    objects: tuple[ObjectSnapshot, ...]
