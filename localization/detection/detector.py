"""AprilTag's own detector, in the conventions of the rest: the first pixel's centre is (0, 0), and corners begin at the corner
where OpenCV's ArUco module begins. A detector belongs to the thread that uses it."""

from collections.abc import Collection, Iterable
from typing import Any, cast

import numpy as np
from apriltag import apriltag as AprilTag  # noqa: N812  # the binding names its class in lower case
from numpy.typing import NDArray

from localization.detection.observation import TagObservation
from localization.tags import TagKey

_TO_OPENCV_ORDER = [1, 0, 3, 2]
_TO_OPENCV_PIXELS = 0.5
"""AprilTag puts the origin at the first pixel's corner, OpenCV at its centre."""
_DECIMATIONS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)
"""AprilTag takes every n-th pixel, or, for 1.5, two of three averaged."""
COARSE_PX = 18.0
"""Of a tag's side at least this much is left by decimation: measured, nothing more is lost then than without, up to a blur
of sigma 3.8 px, and the corners are refined on the whole image anyway."""
FINE_PX = 2 * COARSE_PX
"""With so much left, noisy, pale and shadowed tags are found that the coarse look misses."""
_MIN_MARGIN = 20.0
_MIN_CORRECTED_MARGIN = 35.0
"""A code with a corrected bit must be read more clearly than a whole one."""
_MAX_CORRECTED_BITS = 1
_MIN_IMAGE_PX = 8
_MIN_DECIMATED_PX = 3
"""The detector finds nothing in less, and is not asked to: decimated to one or two pixels, it would crash."""


class TagDetector:
    """AprilTag's detector for some families; keeps one native detector per family and decimation alive.

    With `known`, other tags are ignored: on stressed tags of 20 px and less a few ids are read wrong.
    """

    def __init__(self, families: Iterable[str], known: Collection[TagKey] | None = None) -> None:
        self._families = tuple(families)
        self._known = known
        self._detectors: dict[tuple[str, float], AprilTag] = {}

    def detect(
        self, grey: NDArray[np.uint8], decimation: float = 1.0, offset: tuple[int, int] = (0, 0), scale: float = 1.0
    ) -> list[TagObservation]:
        """Tags in a grey image (height, width), which may be a part of a frame: its first pixel lies at `offset` (x, y) of the
        frame, and it was enlarged `scale` times. Corners are the frame's pixels."""
        if min(grey.shape) < max(_MIN_IMAGE_PX, _MIN_DECIMATED_PX * decimation):
            return []
        # Rows may lie apart, as those of a part of an image do; the native code takes them as they are.
        image = grey if grey.strides[1] == 1 else np.ascontiguousarray(grey)
        shift = np.array(offset, dtype=np.float64) - _TO_OPENCV_PIXELS
        found: list[TagObservation] = []
        for family in self._families:
            for raw in self._detector(family, decimation).detect(image):
                tag = _observation(family, cast("dict[str, Any]", raw), shift, scale)
                if _believable(tag) and (self._known is None or tag.key in self._known):
                    found.append(tag)
        return found

    def _detector(self, family: str, decimation: float) -> AprilTag:
        detector = self._detectors.get((family, decimation))
        if detector is None:
            # Without refined edges decimation would move the corners by about a pixel.
            detector = AprilTag(
                cast("Any", family), maxhamming=_MAX_CORRECTED_BITS, decimate=decimation, blur=0.0, refine_edges=True
            )
            self._detectors[family, decimation] = detector
        return detector


def decimation_for(side_px: float, wanted_px: float) -> float:
    """The largest decimation that leaves at least `wanted_px` of a tag's side."""
    return max((d for d in _DECIMATIONS if side_px / d >= wanted_px), default=_DECIMATIONS[0])


def _observation(family: str, raw: dict[str, Any], shift: NDArray[np.float64], scale: float) -> TagObservation:
    # Both images share their first corner, where AprilTag has its origin: enlarging is a multiplication.
    corners = np.asarray(raw["lb-rb-rt-lt"], dtype=np.float64)[_TO_OPENCV_ORDER] / scale + shift
    return TagObservation(family, int(raw["id"]), corners, float(raw["margin"]), int(raw["hamming"]))


def _believable(tag: TagObservation) -> bool:
    needed = _MIN_CORRECTED_MARGIN if tag.corrected_bits else _MIN_MARGIN
    return tag.decision_margin >= needed and bool(np.isfinite(tag.corners).all())
