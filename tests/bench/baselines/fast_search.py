"""Fast search: near where each tag was last seen, and the whole frame every K-th time (GulliView 2024, 3.1.5: MIN_GLOBAL_SEARCH).

The reports leave the size of the neighbourhood open: here it is the tag's bounding box, wider by one side of the tag all
around, which holds 0.85 m/s at 60 Hz with room to spare. A frame without tags to follow costs nothing but its K-th search,
though the published system may search such frames as a whole.
"""

import numpy as np

from protocol.lab import Lab
from tests.bench.baselines.detector import Array, Image, PublishedDetector


def turn_of(lab: Lab, camera_id: str, every: int) -> int:
    """Where a camera begins its count to K, so that cameras take turns with their full searches."""
    return every * [camera.id for camera in lab.cameras].index(camera_id) // len(lab.cameras)


class FastSearch:
    """Belongs to one camera. `every` is K; `turn` shifts the full searches of cameras against each other."""

    def __init__(self, detector: PublishedDetector, every: int, turn: int = 0) -> None:
        self._detector, self._every, self._turn = detector, every, turn
        self._last_seen: dict[int, Array] = {}
        self._began = False
        self.was_full = False
        """Whether the newest frame was searched as a whole."""

    def find(self, image: Image) -> dict[int, Array]:
        """Corners by tag id, as the detector gives them."""
        self._turn += 1
        self.was_full = not self._began or self._turn % self._every == 0
        self._began = True
        if self.was_full:
            self._last_seen = self._detector.detect(image)
            return dict(self._last_seen)
        found: dict[int, Array] = {}
        for tag_id, corners in self._last_seen.items():
            near = self._near(image, corners)
            if tag_id in near:
                found[tag_id] = near[tag_id]
        self._last_seen |= found
        return found

    def _near(self, image: Image, corners: Array) -> dict[int, Array]:
        side_px = float(np.linalg.norm(corners[1] - corners[0]))
        left, top = np.maximum(np.floor(corners.min(axis=0) - side_px), 0).astype(int)
        right, bottom = np.ceil(corners.max(axis=0) + side_px).astype(int)
        return self._detector.detect(image[top:bottom, left:right], int(left), int(top))
