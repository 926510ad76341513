"""GulliView 2024: every frame is undistorted as a whole by maps computed once; fast search with a full one every K-th frame."""

import cv2
import numpy as np

from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import FrameDetections
from tests.bench.baselines.detector import Image, PublishedDetector
from tests.bench.baselines.fast_search import FastSearch, turn_of
from tests.bench.baselines.floor_plane import FloorPlane
from tests.bench.baselines.method import message


class GulliView2024:
    """One camera of the lab. `process` is a ValueError before `calibrate`."""

    def __init__(self, lab: Lab, camera_id: str, threads: int, every: int) -> None:
        self._lab, self._camera, self._threads = lab, lab.camera(camera_id), threads
        self._family = lab.floor_tags.family
        model = self._camera.model()
        matrix, distortion = model.matrix(), model.distortion_array()
        size = (model.width, model.height)
        # Fixed-point maps, the fastest that remap knows.
        self._maps = cv2.initUndistortRectifyMap(matrix, distortion, np.eye(3), matrix, size, cv2.CV_16SC2)
        detector = PublishedDetector(self._family, [vehicle.tag.id for vehicle in lab.vehicles], threads)
        self._search = FastSearch(detector, every, turn=turn_of(lab, camera_id, every))
        self._plane: FloorPlane | None = None

    def calibrate(self, frame: Frame) -> None:
        floor = PublishedDetector(self._family, self._lab.floor_tags.poses, self._threads)
        self._plane = FloorPlane(floor.detect(self._undistorted(frame.pixels)), self._lab.floor_tags)

    def process(self, frame: Frame) -> FrameDetections:
        if self._plane is None:
            raise ValueError(f"camera {self._camera.id} is not calibrated")
        corners = self._search.find(self._undistorted(frame.pixels))
        poses = {tag_id: self._plane.pose(seen) for tag_id, seen in corners.items()}
        return message(self._camera, frame, self._family, corners, poses, full_search=self._search.was_full)

    def _undistorted(self, image: Image) -> Image:
        return np.asarray(cv2.remap(image, *self._maps, cv2.INTER_LINEAR), dtype=np.uint8)
