"""Raw buffers of V4L2 devices as images, by the pixel format that the driver names (Linux kernel, "V4L2 image formats").

A grey camera's picture is the buffer's luma as it is; nothing is guessed from a buffer's shape but whether it is whole.
"""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.sources.base import BrokenFrameError
from localization.sources.jpeg import decode_jpeg

Image = NDArray[np.uint8]

_JPEG = frozenset({"MJPG", "JPEG"})
_PACKED = {
    "YUYV": (0, cv2.COLOR_YUV2BGR_YUYV),
    "YUY2": (0, cv2.COLOR_YUV2BGR_YUYV),
    "YVYU": (0, cv2.COLOR_YUV2BGR_YVYU),
    "UYVY": (1, cv2.COLOR_YUV2BGR_UYVY),
}
"""Two bytes for each pixel: which of them is luma, and OpenCV's conversion."""
_PLANAR = {
    "NV12": cv2.COLOR_YUV2BGR_NV12,
    "NV21": cv2.COLOR_YUV2BGR_NV21,
    "YU12": cv2.COLOR_YUV2BGR_I420,
    "I420": cv2.COLOR_YUV2BGR_I420,
    "YV12": cv2.COLOR_YUV2BGR_YV12,
}
"""The luma plane, and below it half as many rows of colour."""
_GREY_BITS = {"GREY": 8, "Y8": 8, "Y800": 8, "Y10": 10, "Y12": 12, "Y14": 14, "Y16": 16}
_BGR = frozenset({"BGR3"})

FORMATS = tuple(sorted({*_JPEG, *_PACKED, *_PLANAR, *_GREY_BITS, *_BGR}))
"""The formats that are understood."""


def format_name(fourcc: float) -> str:
    """The four letters of OpenCV's `CAP_PROP_FOURCC`, without the blanks at their end; empty when the driver names none."""
    code = int(fourcc) if 0 < fourcc < 2**32 else 0
    return code.to_bytes(4, "little").decode("latin-1").rstrip(" \0")


def image_of(raw: NDArray[Any], pixel_format: str, *, color: bool) -> Image:
    """The picture in a buffer, (height, width) or, with `color`, (height, width, 3) BGR. BrokenFrameError when the buffer is not
    what its format says. `pixel_format` is one of FORMATS."""
    if pixel_format in _JPEG:
        return decode_jpeg(_bytes_of(raw, pixel_format), color=color)
    if pixel_format in _PACKED:
        luma, conversion = _PACKED[pixel_format]
        if raw.dtype != np.uint8 or raw.ndim != 3 or raw.shape[2] != 2:
            raise _unfit(raw, pixel_format)
        return _converted(raw, conversion) if color else np.ascontiguousarray(raw[:, :, luma])
    if pixel_format in _PLANAR:
        if raw.dtype != np.uint8 or raw.ndim != 2 or raw.shape[0] % 3 or raw.shape[1] % 2:
            raise _unfit(raw, pixel_format)
        return _converted(raw, _PLANAR[pixel_format]) if color else np.ascontiguousarray(raw[: raw.shape[0] * 2 // 3])
    if pixel_format in _GREY_BITS:
        grey = _eight_bits(raw, pixel_format)
        return _converted(grey, cv2.COLOR_GRAY2BGR) if color else grey
    if raw.dtype != np.uint8 or raw.ndim != 3 or raw.shape[2] != 3:
        raise _unfit(raw, pixel_format)
    return raw if color else _converted(raw, cv2.COLOR_BGR2GRAY)


def _bytes_of(raw: NDArray[Any], pixel_format: str) -> Image:
    if raw.dtype != np.uint8 or raw.size != max(raw.shape, default=0):
        raise _unfit(raw, pixel_format)
    return raw.reshape(-1)


def _eight_bits(raw: NDArray[Any], pixel_format: str) -> Image:
    """The high bits of each pixel: where two bytes carry it, the value lies in the lower `bits` of them."""
    bits = _GREY_BITS[pixel_format]
    if raw.ndim != 2 or raw.dtype != (np.uint8 if bits == 8 else np.uint16):
        raise _unfit(raw, pixel_format)
    return raw if bits == 8 else (raw >> (bits - 8)).astype(np.uint8)


def _converted(image: Image, conversion: int) -> Image:
    return cv2.cvtColor(image, conversion).astype(np.uint8, copy=False)


def _unfit(raw: NDArray[Any], pixel_format: str) -> BrokenFrameError:
    return BrokenFrameError(f"a buffer of {raw.dtype} and shape {raw.shape} is no {pixel_format} picture")
