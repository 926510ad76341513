"""What a search gives and what it is told: tags seen in an image, and guesses where tags should be."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.tags import TagKey

Image = NDArray[np.uint8]
"""Grey of shape (height, width) or BGR of shape (height, width, 3)."""

_WHITE_BORDER = 1.0 / 8
"""The white cell around the eight of a tag's side must be seen, relative to the side: where the picture's edge cut it by a tenth
to a quarter, corners were seen up to 4 px (7 mm on the floor) inside of where they are."""


class Box(NamedTuple):
    """A part of an image, pixels; right and bottom are exclusive."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def pixels(self) -> int:
        return (self.right - self.left) * (self.bottom - self.top)

    def of(self, image: Image) -> Image:
        """The part itself, a view."""
        return image[self.top : self.bottom, self.left : self.right]


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
        return side_length(self.corners)


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


def side_length(corners: NDArray[np.float64]) -> float:
    """Mean length of the sides of a quadrangle (4, 2)."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = corners.tolist()
    sides = ((ax - bx, ay - by), (bx - cx, by - cy), (cx - dx, cy - dy), (dx - ax, dy - ay))
    return sum((x * x + y * y) ** 0.5 for x, y in sides) / 4


def to_grey(image: Image) -> NDArray[np.uint8]:
    """The image itself when it is grey."""
    return image if image.ndim == 2 else cast("NDArray[np.uint8]", cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))


def without_duplicates(tags: Iterable[TagObservation]) -> list[TagObservation]:
    """One observation per printed tag: of several at the same place the clearest. The same id elsewhere is kept."""
    kept: dict[TagKey, list[TagObservation]] = {}
    for tag in sorted(tags, key=lambda tag: -tag.decision_margin):
        same_id = kept.setdefault(tag.key, [])
        if not any(_distance(tag, other) < other.side_px / 2 for other in same_id):
            same_id.append(tag)
    return [tag for same_id in kept.values() for tag in same_id]


def is_whole(tag: TagObservation, image: Image) -> bool:
    """Whether the tag's white border is in the picture too. The detector also reads tags that are cut off a little, and puts
    the missing corner at the picture's edge, several millimetres from where it is."""
    height, width = image.shape[:2]
    return is_whole_in(tag, Box(0, 0, width, height))


def is_whole_in(tag: TagObservation, box: Box) -> bool:
    """`is_whole` for a part of a picture: only what lies wholly in it was read from all of its pixels."""
    border_px = _WHITE_BORDER * tag.side_px
    corners = tag.corners.tolist()
    return (
        min(x for x, _ in corners) >= box.left + border_px
        and max(x for x, _ in corners) <= box.right - 1 - border_px
        and min(y for _, y in corners) >= box.top + border_px
        and max(y for _, y in corners) <= box.bottom - 1 - border_px
    )


def _distance(a: TagObservation, b: TagObservation) -> float:
    return float(np.linalg.norm(a.centre - b.centre))
