"""What the scene shows, as read from Redis: live messages as they come, durable things polled."""

from dataclasses import dataclass, field

from protocol.messages import (
    CameraExtrinsics,
    CameraState,
    EmergencyStop,
    FloorRaster,
    GuidanceState,
    Route,
    Status,
    TrackedPose,
    Waypoint,
)


@dataclass(frozen=True, slots=True)
class FloorPicture:
    """The stitched floor: JPEG bytes, map +y up, over min x, min y, max x, max y (m)."""

    jpeg: bytes
    bounds: tuple[float, float, float, float]


@dataclass(slots=True)
class World:
    """The newest of everything; written by the feed, read by the layers."""

    poses: dict[str, TrackedPose] = field(default_factory=dict[str, TrackedPose])
    statuses: dict[str, Status] = field(default_factory=dict[str, Status])
    guidance: dict[str, GuidanceState] = field(default_factory=dict[str, GuidanceState])
    cameras: dict[str, CameraState] = field(default_factory=dict[str, CameraState])
    obstacles: FloorRaster | None = None
    emergency_stop: EmergencyStop | None = None
    waypoints: dict[str, Waypoint] = field(default_factory=dict[str, Waypoint])
    routes: dict[str, Route] = field(default_factory=dict[str, Route])
    extrinsics: dict[str, CameraExtrinsics] = field(default_factory=dict[str, CameraExtrinsics])
    picture: FloorPicture | None = None
