"""Between the simulated lab and its users: vehicles' drives, things put on the floor, faults of cameras, the ground truth.

Drive set-points and odometry stand for the cable between a robot's computer and its base; the ground truth is for tests
and experiments alone.
"""

from enum import StrEnum
from typing import Annotated, Literal

from msgspec import Struct
from pydantic import ConfigDict, Field

from protocol.messages.base import Finite, Identifier, Message, Real, Whole

_Shift = Annotated[float, Field(strict=True, ge=-0.5, le=0.5)]
_Tilt = Annotated[float, Field(strict=True, ge=-0.1, le=0.1)]


class DriveSetpoint(Struct, frozen=True, forbid_unknown_fields=True):
    """Agent to simulated base: the twist to hold (m/s, rad/s). The base stops by itself 0.3 s after the last one."""

    vehicle: str
    sequence: Whole
    linear_mps: Real
    angular_radps: Real


class Odometry(Struct, frozen=True, forbid_unknown_fields=True):
    """Simulated base to agent: pose integrated from the wheels since the base started at (0, 0, 0), with all its errors.
    `session` differs after each start of the base. `range_front_m` is the forward infrared sensor (None: nothing near)."""

    vehicle: str
    session: str
    stamp_ns: Whole
    x: Real
    y: Real
    yaw: Real
    linear_mps: Real
    angular_radps: Real
    battery: Real
    range_front_m: Real | None = None


class Scan(Struct, frozen=True, forbid_unknown_fields=True):
    """Simulated base to agent: one turn of the safety scanner at `stamp_ns`. Beam i lies at `angle_min + i * angle_increment`
    (rad, counter-clockwise from the scanner's own x axis); `ranges_mm` holds two bytes per beam, most significant first: whole
    millimetres, 0 where no echo came back."""

    vehicle: str
    stamp_ns: Whole
    angle_min: Real
    angle_increment: Real
    ranges_mm: bytes


class TruePose(Struct, frozen=True, forbid_unknown_fields=True):
    """Where a vehicle's rotation centre truly is."""

    x: Real
    y: Real
    yaw: Real
    linear_mps: Real
    angular_radps: Real


class GroundTruth(Struct, frozen=True, forbid_unknown_fields=True):
    """The truth of one instant: vehicles by id, and contacts between them or with objects since the start."""

    stamp_ns: Whole
    vehicles: dict[str, TruePose]
    contacts: Whole


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
    speed_mps: Annotated[float, Field(strict=True, ge=0, le=3)] = 0.0


class FaultKind(StrEnum):
    """What a simulated camera may be made to do: `stall` (it stays connected and sends nothing), `unplug` (it is gone), `noise`
    (frames of random pixels), `resize` (frames of half the size), `cover` (something hangs in front of a part of the view),
    `bump` (its mount is moved)."""

    STALL = "stall"
    UNPLUG = "unplug"
    NOISE = "noise"
    RESIZE = "resize"
    COVER = "cover"
    BUMP = "bump"


class CameraFault(Message):
    """What is wrong with a simulated camera until it is taken back. `cover_share` is the part of the image's width, from the
    left, that is covered; `shift_*` is how far a bump moved the mount (m, map frame), `tilt_*` how far it turned it (rad, added
    to the mount's own)."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"kind": "bump", "shift_x_m": 0.02}]})

    kind: FaultKind
    cover_share: Annotated[float, Field(strict=True, gt=0, le=1)] = 1.0
    shift_x_m: _Shift = 0.0
    shift_y_m: _Shift = 0.0
    shift_z_m: _Shift = 0.0
    tilt_x: _Tilt = 0.0
    tilt_y: _Tilt = 0.0
