"""The detector of the published systems: AprilTag's library at full resolution with the settings of their logs (decimate 1, sigma
0.6; spec localization-measurements, "From the real system's logs"). Shared by all baselines."""

from collections.abc import Collection
from typing import Any, cast

import numpy as np
from apriltag import apriltag as AprilTag  # noqa: N812  # the binding names its class in lower case
from numpy.typing import NDArray

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

SIGMA_PX = 0.6
_TO_OPENCV_PIXELS = 0.5
"""AprilTag puts the origin at the first pixel's corner, OpenCV at its centre."""


class PublishedDetector:
    """Finds the tags of a family that are among `known`. `threads` is the detector's own count: theirs was 16 on a processor
    with that many."""

    def __init__(self, family: str, known: Collection[int], threads: int) -> None:
        self._known = frozenset(known)
        self._detector = AprilTag(cast("Any", family), threads=threads, decimate=1.0, blur=SIGMA_PX, refine_edges=True)

    def detect(self, image: Image, left: int = 0, top: int = 0) -> dict[int, Array]:
        """Corners (4, 2) in pixels by tag id: left-bottom, right-bottom, right-top, left-top of the print. `left` and `top` say
        where the image's first pixel lies in the whole frame."""
        # Blurring at decimation 1 writes into the image that it is given.
        found = cast("list[dict[str, Any]]", self._detector.detect(np.array(image, order="C")))
        shift = np.array([left, top], dtype=np.float64) - _TO_OPENCV_PIXELS
        return {
            int(tag["id"]): np.asarray(tag["lb-rb-rt-lt"], dtype=np.float64) + shift
            for tag in found
            if int(tag["id"]) in self._known
        }
