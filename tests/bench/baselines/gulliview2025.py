"""GulliView 2025: fast search on the frame as it is, only corners are undistorted, and each floor tag gives a pose of the
vehicle, whose mean counts (3.1.2, eq. 3.2 to 3.6)."""

import math
from collections.abc import Mapping
from typing import cast

import cv2
import numpy as np

from geometry import SE2, CameraModel
from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import FrameDetections
from tests.bench.baselines.detector import Array, PublishedDetector
from tests.bench.baselines.fast_search import FastSearch, turn_of
from tests.bench.baselines.method import mean_yaw, message


class GulliView2025:
    """One camera of the lab. `process` is a ValueError before `calibrate`."""

    def __init__(self, lab: Lab, camera_id: str, threads: int, every: int) -> None:
        self._lab, self._camera, self._threads = lab, lab.camera(camera_id), threads
        self._family = lab.floor_tags.family
        self._sizes_m = {vehicle.tag.id: vehicle.tag.size_m for vehicle in lab.vehicles}
        detector = PublishedDetector(self._family, self._sizes_m, threads)
        self._search = FastSearch(detector, every, turn=turn_of(lab, camera_id, every))
        self._pose = SquarePose(self._camera.model())
        self._map_from_camera: Array | None = None

    def calibrate(self, frame: Frame) -> None:
        floor = self._lab.floor_tags
        seen = PublishedDetector(self._family, floor.poses, self._threads).detect(frame.pixels)
        if not seen:
            raise ValueError(f"camera {self._camera.id} sees no floor tag")
        poses = self._pose.of(seen, dict.fromkeys(seen, floor.size_m))
        self._map_from_camera = np.stack([_on_floor(*floor.poses[tag]) @ np.linalg.inv(poses[tag]) for tag in poses])

    def process(self, frame: Frame) -> FrameDetections:
        if self._map_from_camera is None:
            raise ValueError(f"camera {self._camera.id} is not calibrated")
        corners = self._search.find(frame.pixels)
        poses = {
            tag_id: mean_pose(self._map_from_camera @ T_camera_tag)
            for tag_id, T_camera_tag in self._pose.of(corners, self._sizes_m).items()
        }
        return message(self._camera, frame, self._family, corners, poses, full_search=self._search.was_full)


class SquarePose:
    """Poses of single tags from their corners: eq. 3.2, points in the order that OpenCV's solver for squares wants."""

    def __init__(self, model: CameraModel) -> None:
        self._matrix, self._distortion = model.matrix(), model.distortion_array()

    def of(self, corners: Mapping[int, Array], sizes_m: Mapping[int, float]) -> dict[int, Array]:
        """T_camera_tag (4, 4) by tag id; what has no solution is left out."""
        poses: dict[int, Array] = {}
        for tag_id, pixels in corners.items():
            a = sizes_m[tag_id] / 2
            square = np.array([[-a, a, 0.0], [a, a, 0.0], [a, -a, 0.0], [-a, -a, 0.0]])
            backwards = np.ascontiguousarray(pixels[::-1]).reshape(-1, 1, 2)
            plane = cv2.undistortPoints(backwards, self._matrix, self._distortion, P=self._matrix)
            solved, rvec, tvec = cv2.solvePnP(square, plane, self._matrix, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
            if solved:
                poses[tag_id] = _matrix(rvec, tvec)
        return poses


def mean_pose(T_map_tag: Array) -> SE2:
    """The mean of what the floor tags say, (N, 4, 4): positions and headings each for themselves."""
    x, y = T_map_tag[:, :2, 3].mean(axis=0)
    return SE2(float(x), float(y), mean_yaw(np.arctan2(T_map_tag[:, 1, 0], T_map_tag[:, 0, 0])))


def _matrix(rvec: object, tvec: object) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3] = cv2.Rodrigues(cast("Array", rvec))[0]
    matrix[:3, 3] = np.asarray(tvec, dtype=np.float64).reshape(3)
    return matrix


def _on_floor(x: float, y: float, yaw: float) -> Array:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
