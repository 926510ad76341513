"""Calibration while the system runs: what cameras see of the floor tags, what a person asks for, what is proposed, what is in
force (spec localization, "Better than the reports")."""

from enum import StrEnum
from typing import Annotated, Self

from msgspec import Struct
from pydantic import Field

from protocol.messages.base import Finite, Identifier, Message, NonNegative, StampNs
from protocol.messages.sight import CameraExtrinsics

Corners = tuple[tuple[float, float], tuple[float, float], tuple[float, float], tuple[float, float]]

CURRENT, PREVIOUS = "current", "previous"
"""Fields of the hash of calibrations: the one in force, and the one before it, to which a person can go back."""


class FloorTagSighting(Struct, frozen=True, forbid_unknown_fields=True):
    """The floor tags that one camera saw, averaged over `frames` frames up to `stamp_ns`.

    `corners`: tag id -> four (x, y) in pixels, in the order of `Detection.corners_px`; `corner_noise_px` is the standard
    deviation of a single frame's corner, per axis. `extrinsics_ns` is the stamp of the extrinsics that the camera used when it
    sent this, `request` the id of the run that asked for it (0: nobody did), `basis` the digest of the camera's description.
    """

    camera: str
    stamp_ns: int
    frames: int
    corners: dict[int, Corners]
    corner_noise_px: float
    extrinsics_ns: int
    basis: str
    request: int = 0


RunId = Annotated[int, Field(gt=0, lt=2**53)]
"""Grows with the clock (ms), so that ids stay distinct also when Redis lost everything."""


class RunState(StrEnum):
    """collecting: cameras look at the floor tags; refining: all is being computed; proposed: a person has to decide; failed:
    it gave nothing, `text` says why; accepted, discarded: it was decided."""

    COLLECTING = "collecting"
    REFINING = "refining"
    PROPOSED = "proposed"
    FAILED = "failed"
    ACCEPTED = "accepted"
    DISCARDED = "discarded"


class CalibrationRun(Message):
    """A calibration that somebody asked for, and how far it has come."""

    id: RunId
    state: RunState
    stamp_ns: StampNs = Field(description="Of the newest change.")
    started_ns: StampNs
    by: str = Field(description="Who asked for it.")
    cameras: tuple[Identifier, ...] = Field(description="Cameras that are to look anew.")
    answered: tuple[Identifier, ...] = Field(default=(), description="Those of them that have.")
    text: str = Field(default="", description="Why it failed, or what was left out.")

    @property
    def is_busy(self) -> bool:
        """Whether the calibrator still works on it."""
        return self.state in (RunState.COLLECTING, RunState.REFINING)

    @property
    def is_open(self) -> bool:
        """Whether its outcome is still to come, or to be decided."""
        return self.is_busy or self.state is RunState.PROPOSED


class CalibratedCamera(Message):
    """T_map_camera with what it rests on; fields as in `CameraExtrinsics`."""

    rotvec: tuple[Finite, Finite, Finite]
    translation: tuple[Finite, Finite, Finite]
    covariance: tuple[Finite, ...] = Field(
        default=(), description="Upper triangle of the 10 x 10 covariance of rotvec, translation, fx, fy, cx, cy."
    )
    reprojection_px: NonNegative = Field(description="RMS distance of the floor tags' corners in the joint result.")
    floor_tags: tuple[int, ...] = Field(description="Floor tags that it rests on.")
    left_out: tuple[int, ...] = Field(default=(), description="Floor tags that were seen and not believed.")
    basis: str = Field(description="Digest of the image size and intrinsics it was computed with.")

    @classmethod
    def of(cls, extrinsics: CameraExtrinsics, left_out: tuple[int, ...], basis: str) -> Self:
        """From a camera's extrinsics."""
        return cls(
            rotvec=extrinsics.rotvec,
            translation=extrinsics.translation,
            covariance=extrinsics.covariance,
            reprojection_px=extrinsics.reprojection_px,
            floor_tags=extrinsics.floor_tags,
            left_out=left_out,
            basis=basis,
        )

    def extrinsics(self, camera: str, stamp_ns: int) -> CameraExtrinsics:
        """As the camera uses it, in force since `stamp_ns`."""
        return CameraExtrinsics(
            camera,
            stamp_ns,
            self.rotvec,
            self.translation,
            self.reprojection_px,
            self.floor_tags,
            self.covariance,
        )


class CalibratedFloorTag(Message):
    """Where a floor tag was found to lie (m, rad, map frame), and how far (m) from where the lab description has it."""

    x: Finite
    y: Finite
    yaw: Finite
    shift_m: NonNegative


class Calibration(Message):
    """A joint result over cameras and floor tags. Cameras take it when it is newer than what they found by themselves."""

    id: RunId
    stamp_ns: StampNs = Field(description="Since when it is in force; of a proposal: when it was computed.")
    by: str = Field(description="Who accepted it; `calibrator` when nobody had to.")
    floor_basis: str = Field(description="Digest of the floor tags of the lab description that it was computed with.")
    cameras: dict[Identifier, CalibratedCamera]
    floor_tags: dict[int, CalibratedFloorTag]


class CameraComparison(Message):
    """What a proposal changes for one camera. Pixels are RMS distances of the floor tags' corners in the new sighting, judged
    by the calibration in use and by the proposal; metres on the floor are taken over the part of it that the camera sees.
    `*_before_*` and the changes are null for a camera that had no calibration."""

    is_new: bool = Field(description="Whether the camera looked anew for this; if not, its last sighting was used.")
    frames: int
    corner_noise_px: NonNegative
    floor_tags: tuple[int, ...]
    left_out: tuple[int, ...]
    reprojection_before_px: NonNegative | None
    reprojection_after_px: NonNegative
    floor_shift_mean_m: NonNegative | None = Field(description="How far the camera's poses will move, on average.")
    floor_shift_max_m: NonNegative | None = Field(description="How far the camera's poses will move at most.")
    camera_moved_m: NonNegative | None
    camera_turned_rad: NonNegative | None
    floor_std_before_m: NonNegative | None
    floor_std_after_m: NonNegative | None = Field(
        description="Standard deviation of points on the floor that the calibration leaves open (RMS); null: not known."
    )


class FloorTagComparison(Message):
    """How far (m) a proposal puts a floor tag from where it is expected now, and which cameras saw it."""

    shift_m: NonNegative
    cameras: tuple[Identifier, ...]


class CalibrationProposal(Message):
    """The outcome of a run, for a person to accept or discard."""

    calibration: Calibration
    cameras: dict[Identifier, CameraComparison]
    floor_tags: dict[int, FloorTagComparison]
    not_answered: tuple[Identifier, ...] = Field(description="Cameras that were asked and sent nothing.")
