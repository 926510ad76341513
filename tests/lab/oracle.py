"""An independent view of the same cameras: OpenCV's projection and AprilTag's own detector."""

from typing import Any, cast

import cv2
import numpy as np
from apriltag import apriltag
from numpy.typing import ArrayLike, NDArray

from protocol.lab import Lab

_detector = apriltag("tag36h11")


def projected(lab: Lab, camera_id: str, points: ArrayLike) -> NDArray[np.float64]:
    """Pixels (N, 2) of map points (N, 3) by cv2.projectPoints, with the mount's convention written out in rotation vectors."""
    mount, model = lab.simulation.mounts[camera_id], lab.camera(camera_id).model()
    turns = [(0.0, 0.0, mount.yaw), (np.pi + mount.tilt_x, 0.0, 0.0), (0.0, mount.tilt_y, 0.0)]
    rotation = np.linalg.multi_dot([np.asarray(cv2.Rodrigues(np.array(turn))[0]) for turn in turns])
    to_camera = rotation.T
    pixels, _ = cv2.projectPoints(
        np.asarray(points, dtype=np.float64),
        np.asarray(cv2.Rodrigues(to_camera)[0]),
        -to_camera @ np.array(mount.position),
        model.matrix(),
        model.distortion_array(),
    )
    return np.asarray(pixels, dtype=np.float64).reshape(-1, 2)


def detected(pixels: NDArray[np.uint8]) -> dict[int, NDArray[np.float64]]:
    """Corners (4, 2) by tag id: left-bottom, right-bottom, right-top, left-top, in OpenCV's pixel convention."""
    # The binding's type stub cannot name the corners' key.
    found = cast("tuple[dict[str, Any], ...]", _detector.detect(pixels))
    return {int(tag["id"]): np.asarray(tag["lb-rb-rt-lt"], dtype=np.float64) - 0.5 for tag in found}


def rms(errors: NDArray[np.float64]) -> float:
    """Root of the mean squared distance of points (..., 2)."""
    return float(np.sqrt((errors**2).sum(axis=-1).mean()))
