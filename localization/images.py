"""Tags in single pictures: what `./lilliput detect` prints.

Nothing is known about such a picture, so the whole of it is searched at full resolution, and every tag of the family counts.
"""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.detection import FullSearch, TagDetector, TagObservation

FAMILY = "tag36h11"


class UnreadableImageError(Exception):
    """A file that is not a picture OpenCV can read; the text names it."""


@dataclass(frozen=True, slots=True)
class ImageTag:
    """A tag in a picture. Corners: (x, y) in pixels, the first pixel's centre is (0, 0), in OpenCV ArUco's order."""

    family: str
    id: int
    corners: tuple[tuple[float, float], ...]
    decision_margin: float


def read_grey(path: Path) -> NDArray[np.uint8]:
    """The picture in grey, shape (height, width), turned as its EXIF data says. UnreadableImageError when it is none."""
    try:
        data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise UnreadableImageError(f"{path}: {error.strerror or error}") from error
    if data.size == 0:
        raise UnreadableImageError(f"{path}: the file is empty")
    try:
        image = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    except cv2.error as error:
        raise UnreadableImageError(f"{path}: {error.err or 'not a picture'}") from error
    if image is None:
        raise UnreadableImageError(f"{path}: not a picture that OpenCV can read")
    return image.astype(np.uint8, copy=False)


def detect_tags(grey: NDArray[np.uint8], family: str = FAMILY) -> list[TagObservation]:
    """Every tag in a grey picture (height, width), from top to bottom, then from left to right."""
    search = FullSearch(TagDetector([family]), side_px=1.0)
    return sorted(search.find(grey), key=lambda tag: (float(tag.centre[1]), float(tag.centre[0])))


def detect_image(path: Path | str, family: str = FAMILY) -> list[ImageTag]:
    """The tags in the picture of that name. UnreadableImageError, naming the file, when it is none."""
    return [
        ImageTag(tag.family, tag.tag_id, tuple((float(x), float(y)) for x, y in tag.corners), tag.decision_margin)
        for tag in detect_tags(read_grey(Path(path)), family)
    ]
