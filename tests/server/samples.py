"""Messages of a robot's life, for tests that need some."""

from typing import Any

from protocol.messages import (
    CameraExtrinsics,
    CameraState,
    Command,
    FloorRaster,
    Movement,
    Reason,
    ReasonCode,
    Status,
    Target,
    TrackedPose,
)

START_NS = 1_700_000_000_000_000_000


def pose(vehicle: str, stamp_ns: int, x: float = 1.0) -> TrackedPose:
    covariance = (4e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6)
    return TrackedPose(vehicle, stamp_ns, x, 2.0, 0.5, 0.1, 0.0, 0.0, covariance, ("cam0",), "camp")


def status(robot: str, stamp_ns: int, sequence: int = 1, **changes: Any) -> Status:
    return Status(robot=robot, sequence=sequence, stamp_ns=stamp_ns, linear_mps=0.1, angular_radps=0.0, **changes)


def command(robot: str, stamp_ns: int, sequence: int = 1, movement: Movement = Movement.MOVE_TO) -> Command:
    return Command(
        robot=robot,
        epoch=1,
        sequence=sequence,
        stamp_ns=stamp_ns,
        deadline_ns=stamp_ns + 500_000_000,
        movement=movement,
        reason=Reason(code=ReasonCode.ROUTE if movement is Movement.MOVE_TO else ReasonCode.OBSTACLE, text="why"),
        target=Target(x=2.0, y=2.0) if movement is Movement.MOVE_TO else None,
        speed_mps=0.3,
    )


def camera_state(camera: str, stamp_ns: int, error: str | None = None) -> CameraState:
    return CameraState(
        camera=camera,
        stamp_ns=stamp_ns,
        connected=error is None,
        error=error,
        width=1920,
        height=1080,
        rate_hz=15.0,
        latency_ms=20.0,
        frames=100,
        broken=0,
        skipped=0,
        floor_tags_seen=(0, 1),
        reprojection_px=0.2,
        timings_ms={"detect": 10.0},
    )


def extrinsics(camera: str, stamp_ns: int = START_NS) -> CameraExtrinsics:
    """Three metres above (2, 2), looking straight down, image x along map x."""
    return CameraExtrinsics(camera, stamp_ns, (3.141592653589793, 0.0, 0.0), (2.0, 2.0, 3.0), 0.2, (0, 1))


def raster(stamp_ns: int, occupied: bytes = b"\x80\x00") -> FloorRaster:
    return FloorRaster("mapper", stamp_ns, 0.0, 0.0, 0.05, 4, 4, occupied, b"\xff\xff")
