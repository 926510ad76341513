"""What the cameras see, on the way of a frame: msgspec structs, checked when decoded, frozen."""

from msgspec import Struct

from protocol.messages.base import Real, Whole


class Detection(Struct, frozen=True, forbid_unknown_fields=True):
    """One tag in one frame.

    `corners_px` are four (x, y) in pixels, the first pixel's centre is (0, 0), in the order in which OpenCV's ArUco module
    gives them. `x`, `y`, `yaw` are the pose of the *tag* in the map frame (m, rad), `covariance` the upper triangle
    (xx, xy, xyaw, yy, yyaw, yawyaw) of its covariance (m^2, m rad, rad^2). `systematic` is the part of it that is the same
    in the next frame too, since it comes from the calibration and the tag's measured height: waiting does not average it away.
    """

    family: str
    tag_id: Whole
    corners_px: tuple[tuple[float, float], tuple[float, float], tuple[float, float], tuple[float, float]]
    decision_margin: float
    x: float
    y: float
    yaw: float
    covariance: tuple[float, float, float, float, float, float]
    systematic: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class FrameDetections(Struct, frozen=True, forbid_unknown_fields=True):
    """The vehicle tags found in one frame of one camera. `stamp_ns` is the capture time, `sent_ns` when the message was
    ready; `full_search` says that this frame (or the last band of one) completed a search of the whole picture; `timings_ms` has
    the stages `wait` (capture to start), `window` and `full` (the two searches), `undistort`, `pose`."""

    camera: str
    stamp_ns: Whole
    sent_ns: Whole
    frame: Whole
    full_search: bool
    detections: tuple[Detection, ...]
    timings_ms: dict[str, float]


class TrackedPose(Struct, frozen=True, forbid_unknown_fields=True):
    """A vehicle's rotation centre in the map frame at `stamp_ns` (capture time of the newest frame that was fused).

    Velocities and accelerations are in the map frame (m/s, rad/s, m/s^2); `covariance` as in Detection; `cameras` saw it in
    that update.
    """

    vehicle: str
    stamp_ns: Whole
    x: Real
    y: Real
    yaw: Real
    vx: Real
    vy: Real
    yaw_rate: Real
    covariance: tuple[Real, Real, Real, Real, Real, Real]
    cameras: tuple[str, ...]
    area: str | None = None
    ax: Real = 0.0
    ay: Real = 0.0


class CameraState(Struct, frozen=True, forbid_unknown_fields=True):
    """How a camera does. `error` says what is wrong (None when nothing is), `error_since_ns` since when; latency is frame to
    message, median of the last seconds, in ms; `reprojection_px` is the extrinsics' RMS error, None before calibration."""

    camera: str
    stamp_ns: Whole
    connected: bool
    error: str | None
    width: Whole
    height: Whole
    rate_hz: float
    latency_ms: float
    frames: Whole
    broken: Whole
    skipped: Whole
    floor_tags_seen: tuple[int, ...]
    reprojection_px: float | None
    timings_ms: dict[str, float]
    error_since_ns: Whole | None = None


class CameraExtrinsics(Struct, frozen=True, forbid_unknown_fields=True):
    """T_map_camera: a calibration result. `rotvec` is axis times angle (rad), `translation` metres; a point of the camera
    frame (x right, y down, z forward) is mapped into the map frame. `covariance` is the upper triangle, row by row, of the
    10 x 10 covariance of (rotvec, translation, fx, fy, cx, cy): what floor tags and description leave open, rad, m and px;
    the rotation's error is the left perturbation exp(delta) R. Empty when it is not known."""

    camera: str
    stamp_ns: Whole
    rotvec: tuple[Real, Real, Real]
    translation: tuple[Real, Real, Real]
    reprojection_px: Real
    floor_tags: tuple[int, ...]
    covariance: tuple[Real, ...] = ()


class FloorRaster(Struct, frozen=True, forbid_unknown_fields=True):
    """A grid on the floor. Cell (row, column) covers x from origin_x + column * cell_m and y from origin_y + row * cell_m;
    rows grow with y. `occupied` and `observed` are bit fields, row-major, most significant bit first (numpy.packbits);
    a cell not observed says nothing."""

    source: str
    stamp_ns: Whole
    origin_x: Real
    origin_y: Real
    cell_m: Real
    columns: Whole
    rows: Whole
    occupied: bytes
    observed: bytes
