"""Between the simulated lab and its users: vehicles' drives, things put on the floor, and the ground truth.

Drive set-points and odometry stand for the cable between a robot's computer and its base; the ground truth is for tests
and experiments alone.
"""

from typing import Annotated, Literal

from msgspec import Struct
from pydantic import ConfigDict, Field

from protocol.messages.base import Finite, Identifier, Message


class DriveSetpoint(Struct, frozen=True, forbid_unknown_fields=True):
    """Agent to simulated base: the twist to hold (m/s, rad/s). The base stops by itself 0.3 s after the last one."""

    vehicle: str
    sequence: int
    linear_mps: float
    angular_radps: float


class Odometry(Struct, frozen=True, forbid_unknown_fields=True):
    """Simulated base to agent: pose integrated from the wheels since the base started at (0, 0, 0), with all its errors.
    `session` differs after each start of the base. `range_front_m` is the forward infrared sensor (None: nothing near)."""

    vehicle: str
    session: str
    stamp_ns: int
    x: float
    y: float
    yaw: float
    linear_mps: float
    angular_radps: float
    battery: float
    range_front_m: float | None = None


class TruePose(Struct, frozen=True, forbid_unknown_fields=True):
    """Where a vehicle's rotation centre truly is."""

    x: float
    y: float
    yaw: float
    linear_mps: float
    angular_radps: float


class GroundTruth(Struct, frozen=True, forbid_unknown_fields=True):
    """The truth of one instant: vehicles by id, and contacts between them or with objects since the start."""

    stamp_ns: int
    vehicles: dict[str, TruePose]
    contacts: int


class SimulatedObject(Message):
    """A person or a pallet on the simulated floor; a person with `path` walks it back and forth at `speed_mps`."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"id": "pallet-1", "kind": "pallet", "x": 1.0, "y": 1.0}]}
    )

    id: Identifier
    kind: Literal["person", "pallet"]
    x: Finite
    y: Finite
    yaw: Finite = 0.0
    path: tuple[tuple[Finite, Finite], ...] = ()
    speed_mps: Annotated[float, Field(ge=0, le=3)] = 0.0
