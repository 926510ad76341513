"""JPEG to pixels. Grey cameras' pictures are decoded to grey at once: their colours are never made."""

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.sources.base import BrokenFrameError

_GREY = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
_COLOR = cv2.IMREAD_COLOR_BGR | cv2.IMREAD_IGNORE_ORIENTATION
"""A camera's pictures lie as its sensor does, whatever their EXIF data say."""
_START = b"\xff\xd8"


def decode_jpeg(data: bytes | NDArray[np.uint8], *, color: bool) -> NDArray[np.uint8]:
    """The picture, (height, width) or (height, width, 3) BGR. BrokenFrameError when it is none, or a part of one."""
    array = np.frombuffer(data, dtype=np.uint8) if isinstance(data, bytes) else data.reshape(-1)
    if array[:2].tobytes() != _START:
        raise BrokenFrameError(f"a frame of {array.size} bytes is not a JPEG picture")
    try:
        image = cv2.imdecode(array, _COLOR if color else _GREY)
    except cv2.error as error:
        raise BrokenFrameError(f"a JPEG frame of {array.size} bytes cannot be decoded: {error.err}") from error
    if image is None:
        raise BrokenFrameError(f"a JPEG frame of {array.size} bytes is damaged or not whole")
    return image.astype(np.uint8, copy=False)
