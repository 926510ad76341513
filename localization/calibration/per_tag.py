"""The reports' way from a tag in the image to the room, kept as a reference to compare with (GulliView 2025, 3.1.2, eq. 3.2-3.6).

solvePnP finds the pose of the vehicle's tag and of each of the camera's floor tags; through every floor tag's known place the
vehicle has a place in the room, and the answers are averaged. Nothing else in the system uses it.
"""

from collections.abc import Mapping
from typing import Self, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE2, SE3, CameraModel, mean_angle
from localization.calibration.sighting import FloorSighting
from localization.projection import undistort
from localization.tags import tag_corners

Array = NDArray[np.float64]


class NoPoseError(ValueError):
    """solvePnP found no pose for the four corners."""


class PerTagAverage:
    """One camera: `T_camera_tag` by floor tag, as solvePnP found them once, and their places `T_map_tag`."""

    def __init__(self, model: CameraModel, T_camera_tag: Mapping[int, SE3], places: Mapping[int, SE2]) -> None:
        if not T_camera_tag:
            raise ValueError("the per-tag average needs a floor tag")
        self._model = model
        self._to_map = [SE3.from_se2(places[tag]) @ pose.inverse() for tag, pose in sorted(T_camera_tag.items())]

    @classmethod
    def calibrated(cls, model: CameraModel, sighting: FloorSighting, places: Mapping[int, SE2], size_m: float) -> Self:
        """From what the camera saw of the floor tags that lie at `places` (T_map_tag), with a side of `size_m`."""
        seen = {tag: corners for tag, corners in sighting.corners.items() if tag in places}
        return cls(model, {tag: pnp_pose(model, corners, size_m) for tag, corners in seen.items()}, places)

    def poses(self, corners: Array, size_m: float) -> list[SE2]:
        """T_map_tag of a tag with these corners (4, 2), pixels, in ArUco's order: one answer per floor tag. NoPoseError."""
        T_camera_tag = pnp_pose(self._model, corners, size_m)
        return [(T_map_camera @ T_camera_tag).to_se2() for T_map_camera in self._to_map]

    def pose(self, corners: Array, size_m: float) -> SE2:
        """The average of the answers."""
        answers = self.poses(corners, size_m)
        x, y = (float(v) for v in np.mean([(answer.x, answer.y) for answer in answers], axis=0))
        return SE2(x, y, mean_angle(answer.yaw for answer in answers))


def pnp_pose(model: CameraModel, corners: Array, size_m: float) -> SE3:
    """T_camera_tag of a square from its corners in the image, by OpenCV's solvePnP as it comes (eq. 3.2): points are
    undistorted first. NoPoseError."""
    points = np.column_stack([tag_corners(size_m), np.zeros(4)])
    try:
        found, rvec, tvec = cv2.solvePnP(points, undistort(model, corners), np.eye(3), np.zeros(5))
    except cv2.error as error:
        raise NoPoseError(f"solvePnP: {error}") from None
    if not found or not (np.isfinite(rvec).all() and np.isfinite(tvec).all()):
        raise NoPoseError("solvePnP found no pose")
    return SE3.from_rotvec(cast("Array", rvec).reshape(3), cast("Array", tvec).reshape(3))
