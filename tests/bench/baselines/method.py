"""What all baselines share: one camera's frames in, one message per frame out, in the words that our own messages use."""

import math
from collections.abc import Mapping
from typing import Protocol

import numpy as np

from geometry import SE2
from protocol.frames import Frame
from protocol.lab import CameraSpec
from protocol.messages import Detection, FrameDetections
from tests.bench.baselines.detector import Array

_YAW_VARIANCE = 0.1


class Baseline(Protocol):
    """A published way to localize, for one camera."""

    def calibrate(self, frame: Frame) -> None:
        """Finds the camera's place from one picture of the floor tags, as the reports' calibration program did."""
        ...

    def process(self, frame: Frame) -> FrameDetections:
        """The vehicles' tags in a frame."""
        ...


def message(
    camera: CameraSpec,
    frame: Frame,
    family: str,
    corners: Mapping[int, Array],
    poses: Mapping[int, SE2],
    *,
    full_search: bool,
) -> FrameDetections:
    """The message of a frame: corners (4, 2) in pixels and T_map_tag by tag id. The variances are the reports' static ones
    (spec localization, "Frames"): they grow with the distance to the picture's centre."""
    return FrameDetections(
        camera=camera.id,
        stamp_ns=frame.stamp_ns,
        sent_ns=frame.stamp_ns,
        frame=frame.number,
        full_search=full_search,
        detections=tuple(_detection(camera, family, tag_id, corners[tag_id], pose) for tag_id, pose in poses.items()),
        timings_ms={},
    )


def _detection(camera: CameraSpec, family: str, tag_id: int, corners: Array, pose: SE2) -> Detection:
    x_px, y_px = corners.mean(axis=0)
    variance = 0.01 + 1e-6 * math.hypot(x_px - camera.intrinsics.cx, y_px - camera.intrinsics.cy)
    a, b, c, d = ((float(x), float(y)) for x, y in corners)
    return Detection(
        family=family,
        tag_id=tag_id,
        corners_px=(a, b, c, d),
        decision_margin=0.0,
        x=pose.x,
        y=pose.y,
        yaw=pose.yaw,
        covariance=(variance, 0.0, 0.0, variance, 0.0, _YAW_VARIANCE),
    )


def mean_yaw(yaws: Array) -> float:
    """The mean direction of angles (N,), rad."""
    return math.atan2(float(np.sin(yaws).mean()), float(np.cos(yaws).mean()))
