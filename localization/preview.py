"""A small picture of what a camera sees, the tags found outlined and named, for the console's camera panel."""

from collections.abc import Iterable, Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.detection import TagObservation
from localization.tags import TagKey

WIDTH_PX = 480
_QUALITY = 70
_VEHICLE = (80, 220, 60)
_FLOOR = (230, 160, 40)


def preview_jpeg(
    pixels: NDArray[np.uint8], tags: Iterable[TagObservation], names: Mapping[TagKey, str], width_px: int = WIDTH_PX
) -> bytes:
    """A JPEG of the frame (grey or BGR), `width_px` wide. Tags with a name are vehicles, the others lie on the floor."""
    height, width = pixels.shape[:2]
    scale = min(1.0, width_px / width)
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    small = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    picture = cv2.cvtColor(small, cv2.COLOR_GRAY2BGR) if small.ndim == 2 else small
    for tag in tags:
        name = names.get(tag.key)
        colour = _FLOOR if name is None else _VEHICLE
        corners = np.rint(((tag.corners + 0.5) * scale - 0.5) * 16).astype(np.int32).reshape(-1, 1, 2)
        cv2.polylines(picture, [corners], True, colour, 1, cv2.LINE_AA, shift=4)
        x, y = (int(v) for v in corners.reshape(-1, 2).min(axis=0) // 16)
        label = str(tag.tag_id) if name is None else name
        cv2.putText(picture, label, (x, max(10, y - 4)), cv2.FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv2.LINE_AA)
    ok, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    assert ok, "OpenCV encodes any 8-bit image"
    return data.tobytes()
