"""How a camera looks to an operator: its state, where it hangs, and which part of the floor it sees."""

from pydantic import Field

from protocol.channels import CAMERA_STATES
from protocol.lab import CameraSpec, Intrinsics
from protocol.lab.address import without_password
from protocol.messages import CameraExtrinsics, CameraFault, CameraState
from server.views.base import AgeS, Outline, View, age_s
from server.views.field_of_view import floor_outline


class CameraStateView(View):
    """How the camera does, as its process last said; `error` is null when nothing is wrong."""

    stamp_ns: int
    age_s: AgeS
    fresh: bool
    connected: bool
    error: str | None
    error_since_ns: int | None = Field(description="Since when there is an error, if that is known.")
    width: int
    height: int
    rate_hz: float
    latency_ms: float = Field(description="Frame to message, median of the last seconds.")
    frames: int
    broken: int
    skipped: int
    floor_tags_seen: tuple[int, ...]
    reprojection_px: float | None
    timings_ms: dict[str, float]


class ExtrinsicsView(View):
    """T_map_camera: `rotvec` is axis times angle (rad), `translation` metres; x right, y down, z forward in the camera."""

    stamp_ns: int
    rotvec: tuple[float, float, float]
    translation: tuple[float, float, float]
    reprojection_px: float
    floor_tags: tuple[int, ...]


class CameraView(View):
    """A camera with all that is known of it."""

    id: str
    area: str
    source: str
    width: int
    height: int
    rate_hz: float
    intrinsics: Intrinsics
    state: CameraStateView | None
    extrinsics: ExtrinsicsView | None = Field(description="Null until the camera has been calibrated.")
    outline: Outline | None = Field(description="The floor that it sees; null until it has been calibrated.")
    fault: CameraFault | None = Field(description="What this simulated camera is made to suffer.")

    def without_ages(self) -> "CameraView":
        """The same without what changes by time alone, to tell whether anything new is known."""
        return self.model_copy(update={"state": self.state and self.state.model_copy(update={"age_s": 0.0})})


def camera_view(
    camera: CameraSpec,
    state: CameraState | None,
    extrinsics: CameraExtrinsics | None,
    now_ns: int,
    fault: CameraFault | None = None,
) -> CameraView:
    """How the camera looks at `now_ns`."""
    return CameraView(
        id=camera.id,
        area=camera.area,
        source=without_password(camera.source),
        width=camera.width,
        height=camera.height,
        rate_hz=camera.rate_hz,
        intrinsics=camera.intrinsics,
        state=None if state is None else _state(state, now_ns),
        extrinsics=None
        if extrinsics is None
        else ExtrinsicsView(
            stamp_ns=extrinsics.stamp_ns,
            rotvec=extrinsics.rotvec,
            translation=extrinsics.translation,
            reprojection_px=extrinsics.reprojection_px,
            floor_tags=extrinsics.floor_tags,
        ),
        outline=None
        if extrinsics is None
        else floor_outline(camera.model(), extrinsics.rotvec, extrinsics.translation),
        fault=fault,
    )


def _state(state: CameraState, now_ns: int) -> CameraStateView:
    age = age_s(state.stamp_ns, now_ns)
    return CameraStateView(
        stamp_ns=state.stamp_ns,
        age_s=age,
        fresh=age <= CAMERA_STATES.stale_after_s,
        connected=state.connected,
        error=state.error,
        error_since_ns=state.error_since_ns,
        width=state.width,
        height=state.height,
        rate_hz=state.rate_hz,
        latency_ms=state.latency_ms,
        frames=state.frames,
        broken=state.broken,
        skipped=state.skipped,
        floor_tags_seen=state.floor_tags_seen,
        reprojection_px=state.reprojection_px,
        timings_ms=state.timings_ms,
    )
