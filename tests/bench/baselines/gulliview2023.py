"""GulliView 2023: every frame is undistorted as a whole, the maps for it computed anew each time, and searched as a whole.

OpenCV's `undistort` is what the report names (GulliView 2024, 3.1.4, of its predecessor).
"""

import cv2
import numpy as np

from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import FrameDetections
from tests.bench.baselines.detector import Image, PublishedDetector
from tests.bench.baselines.floor_plane import FloorPlane
from tests.bench.baselines.method import message


class GulliView2023:
    """One camera of the lab. `process` is a ValueError before `calibrate`."""

    def __init__(self, lab: Lab, camera_id: str, threads: int) -> None:
        self._lab, self._camera, self._threads = lab, lab.camera(camera_id), threads
        self._family = lab.floor_tags.family
        model = self._camera.model()
        self._matrix, self._distortion = model.matrix(), model.distortion_array()
        self._detector = PublishedDetector(self._family, [vehicle.tag.id for vehicle in lab.vehicles], threads)
        self._plane: FloorPlane | None = None

    def calibrate(self, frame: Frame) -> None:
        floor = PublishedDetector(self._family, self._lab.floor_tags.poses, self._threads)
        self._plane = FloorPlane(floor.detect(self._undistorted(frame.pixels)), self._lab.floor_tags)

    def process(self, frame: Frame) -> FrameDetections:
        if self._plane is None:
            raise ValueError(f"camera {self._camera.id} is not calibrated")
        corners = self._detector.detect(self._undistorted(frame.pixels))
        poses = {tag_id: self._plane.pose(seen) for tag_id, seen in corners.items()}
        return message(self._camera, frame, self._family, corners, poses, full_search=True)

    def _undistorted(self, image: Image) -> Image:
        return np.asarray(cv2.undistort(image, self._matrix, self._distortion), dtype=np.uint8)
