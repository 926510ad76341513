"""What cameras would say of the vehicles of the small lab, frame by frame, for tests of what is made of it."""

from geometry import SE2
from localization.tracking import Tracker
from protocol.messages import Detection, FrameDetections, TrackedPose
from tests.localization.synthetic import small_lab

LAB = small_lab()
VEHICLE = LAB.vehicle("robot-10")
SECOND = 1_000_000_000
PERIOD_NS = SECOND // 15
SIGMA_M, SIGMA_RAD = 0.001, 0.002
SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


def detection(vehicle: SE2, tag_id: int = 10, sigma_m: float = SIGMA_M, systematic_m: float = 0.0) -> Detection:
    """What a camera says of a vehicle whose rotation centre is there; `systematic_m` of its doubt is the calibration's."""
    worn = next(v.tag for v in LAB.vehicles if v.tag.id == tag_id) if tag_id in (10, 11) else VEHICLE.tag
    tag = vehicle @ worn.pose_on_vehicle()
    covariance = (sigma_m**2, 0.0, 0.0, sigma_m**2, 0.0, SIGMA_RAD**2)
    systematic = (systematic_m**2, 0.0, 0.0, systematic_m**2, 0.0, 0.0)
    return Detection("tag36h11", tag_id, SQUARE, 80.0, tag.x, tag.y, tag.yaw, covariance, systematic)


def seen(camera: str, stamp_ns: int, *detections: Detection) -> FrameDetections:
    return FrameDetections(camera, stamp_ns, stamp_ns, 0, False, detections, {})


def only(poses: list[TrackedPose]) -> TrackedPose:
    (pose,) = poses
    return pose


def standing(tracker: Tracker, frames: int = 10, pose: SE2 | None = None) -> int:
    """A track at rest; returns the stamp of its last frame."""
    for number in range(frames):
        tracker.update(seen("left", number * PERIOD_NS, detection(pose or SE2(1, 0.5, 0))))
    return (frames - 1) * PERIOD_NS
