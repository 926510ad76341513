"""Tags in an image: AprilTag's own detector behind two strategies, the whole frame or windows around predicted tags.

Implements steps 2 and 3 of the pipeline of 2025 (spec localization). Corners leave in OpenCV's conventions: the first
pixel's centre is (0, 0), and they begin at the corner where OpenCV's ArUco module begins. A detector belongs to the thread
that uses it.
"""

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, cast

import cv2
import numpy as np
from apriltag import apriltag as AprilTag  # noqa: N812  # the binding names its class in lower case
from numpy.typing import NDArray

from localization.tags import TagKey

Image = NDArray[np.uint8]
"""Grey of shape (height, width) or BGR of shape (height, width, 3)."""

_TO_OPENCV_ORDER = [1, 0, 3, 2]
_TO_OPENCV_PIXELS = 0.5
"""AprilTag puts the origin at the first pixel's corner, OpenCV at its centre."""
_DECIMATIONS = (1.0, 1.5, 2.0, 3.0)
_COARSE_PX = 18.0
"""Of a tag's side at least this much is left by decimation: measured, nothing more is lost then than without, up to a blur
of sigma 3.8 px, and the corners are refined on the whole image anyway."""
_MIN_MARGIN = 20.0
_MIN_CORRECTED_MARGIN = 35.0
"""A code with a corrected bit must be read more clearly than a whole one."""
_MAX_CORRECTED_BITS = 1
_WHITE_BORDER = 0.75 / 8
"""How much of the white cell around the eight of a tag's side must be seen, relative to the side."""
_MIN_IMAGE_PX = 8
"""The detector finds nothing in less, and is not asked to."""


@dataclass(frozen=True, slots=True, eq=False)
class TagObservation:
    """A tag seen in an image. `corners` has shape (4, 2), pixels, in OpenCV's convention and ArUco's order."""

    family: str
    tag_id: int
    corners: NDArray[np.float64]
    decision_margin: float
    corrected_bits: int

    @property
    def key(self) -> TagKey:
        return self.family, self.tag_id

    @property
    def centre(self) -> NDArray[np.float64]:
        """Mean of the corners, shape (2,), pixels."""
        return cast("NDArray[np.float64]", self.corners.mean(axis=0))

    @property
    def side_px(self) -> float:
        """Mean length of the four sides, pixels."""
        return float(np.linalg.norm(self.corners - np.roll(self.corners, 1, axis=0), axis=1).mean())


@dataclass(frozen=True, slots=True)
class TagGuess:
    """Where a tag should be: its centre, the length of its side and how far off the centre may be, all in pixels."""

    key: TagKey
    x: float
    y: float
    side_px: float
    margin_px: float


class TagSearch(Protocol):
    """A way to find tags in an image."""

    def find(self, image: Image, guesses: Sequence[TagGuess] = ()) -> list[TagObservation]:
        """The tags seen, each once; `guesses` say what to expect."""
        ...


class TagDetector:
    """AprilTag's detector for some families; keeps one native detector per family and decimation alive.

    With `known`, other tags are ignored: on stressed tags of 20 px and less a few ids are read wrong.
    """

    def __init__(self, families: Iterable[str], known: Collection[TagKey] | None = None) -> None:
        self._families = tuple(families)
        self._known = known
        self._detectors: dict[tuple[str, float], AprilTag] = {}

    def detect(
        self, grey: NDArray[np.uint8], decimation: float = 1.0, offset: tuple[int, int] = (0, 0)
    ) -> list[TagObservation]:
        """Tags in a grey image (height, width); `offset` is where its first pixel lies in the whole frame (x, y)."""
        if min(grey.shape) < _MIN_IMAGE_PX:
            return []
        image = np.ascontiguousarray(grey)
        shift = np.array(offset, dtype=np.float64) - _TO_OPENCV_PIXELS
        found: list[TagObservation] = []
        for family in self._families:
            for raw in self._detector(family, decimation).detect(image):
                tag = _observation(family, cast("dict[str, Any]", raw), shift)
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


class FullSearch:
    """Looks everywhere. `side_px` is the smallest tag that must be found, in pixels."""

    def __init__(self, detector: TagDetector, side_px: float, *, finest: float = 1.0, coarsest: float = 3.0) -> None:
        self._detector = detector
        self._finest, self._coarsest = finest, coarsest
        self.side_px = side_px

    def find(self, image: Image, guesses: Sequence[TagGuess] = ()) -> list[TagObservation]:
        side_px = min([self.side_px, *(guess.side_px for guess in guesses)])
        decimation = max(self._finest, min(self._coarsest, decimation_for(side_px, _COARSE_PX)))
        return without_duplicates(self._detector.detect(to_grey(image), decimation))


class WindowedSearch:
    """Looks only around each guess: coarsely first, and again more finely where that did not find the tag."""

    def __init__(self, detector: TagDetector) -> None:
        self._detector = detector

    def find(self, image: Image, guesses: Sequence[TagGuess] = ()) -> list[TagObservation]:
        found: list[TagObservation] = []
        for guess in guesses:
            if any(tag.key == guess.key and _hits(tag, guess) for tag in found):
                continue  # the neighbour's window had it already
            window = _window(guess, image.shape[1], image.shape[0])
            if window is None:
                continue
            left, top, right, bottom = window
            grey = to_grey(image[top:bottom, left:right])
            coarse = decimation_for(guess.side_px, _COARSE_PX)
            for decimation in dict.fromkeys((coarse, decimation_for(guess.side_px, 2 * _COARSE_PX))):
                tags = self._detector.detect(grey, decimation, (left, top))
                found += tags
                if any(tag.key == guess.key for tag in tags):
                    break
        return without_duplicates(found)


def decimation_for(side_px: float, wanted_px: float) -> float:
    """The largest decimation that leaves at least `wanted_px` of a tag's side."""
    return max((d for d in _DECIMATIONS if side_px / d >= wanted_px), default=_DECIMATIONS[0])


def to_grey(image: Image) -> NDArray[np.uint8]:
    """The image itself when it is grey."""
    return image if image.ndim == 2 else cast("NDArray[np.uint8]", cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))


def without_duplicates(tags: Iterable[TagObservation]) -> list[TagObservation]:
    """One observation per printed tag: of several at the same place the clearest. The same id elsewhere is kept."""
    kept: list[TagObservation] = []
    for tag in sorted(tags, key=lambda tag: -tag.decision_margin):
        if not any(tag.key == other.key and _distance(tag, other) < other.side_px / 2 for other in kept):
            kept.append(tag)
    return kept


def is_whole(tag: TagObservation, image: Image) -> bool:
    """Whether the tag's white border is in the picture too. The detector also reads tags that are cut off a little, and puts
    the missing corner at the picture's edge, several millimetres from where it is."""
    border_px = _WHITE_BORDER * tag.side_px
    height, width = image.shape[:2]
    low, high = tag.corners.min(axis=0), tag.corners.max(axis=0)
    return bool((low >= border_px).all() and high[0] <= width - 1 - border_px and high[1] <= height - 1 - border_px)


def _observation(family: str, raw: dict[str, Any], shift: NDArray[np.float64]) -> TagObservation:
    corners = np.asarray(raw["lb-rb-rt-lt"], dtype=np.float64)[_TO_OPENCV_ORDER] + shift
    return TagObservation(family, int(raw["id"]), corners, float(raw["margin"]), int(raw["hamming"]))


def _believable(tag: TagObservation) -> bool:
    needed = _MIN_CORRECTED_MARGIN if tag.corrected_bits else _MIN_MARGIN
    return tag.decision_margin >= needed and bool(np.isfinite(tag.corners).all())


def _distance(a: TagObservation, b: TagObservation) -> float:
    return float(np.linalg.norm(a.centre - b.centre))


def _hits(tag: TagObservation, guess: TagGuess) -> bool:
    x, y = tag.centre
    return math.hypot(x - guess.x, y - guess.y) <= guess.side_px + guess.margin_px


def _window(guess: TagGuess, width: int, height: int) -> tuple[int, int, int, int] | None:
    """left, top, right, bottom (exclusive): the tag turned at will, its white border and the margin; None outside."""
    reach = guess.side_px * (math.sqrt(0.5) + 0.25) + guess.margin_px
    left, right = max(0, math.floor(guess.x - reach)), min(width, math.ceil(guess.x + reach) + 1)
    top, bottom = max(0, math.floor(guess.y - reach)), min(height, math.ceil(guess.y + reach) + 1)
    if min(right - left, bottom - top) < guess.side_px:
        return None
    return left, top, right, bottom
