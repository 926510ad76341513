"""A recording as a folder of pictures, each named by its capture time in nanoseconds."""

from pathlib import Path

import cv2
import numpy as np

from localization.sources.base import BrokenFrameError, CaptureError
from protocol.frames import Frame

PICTURE_SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".webp"})
_AS_RECORDED = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION
"""Eight bits, grey or BGR; a camera's pictures lie as its sensor does."""


class FolderCapture:
    """The folder's pictures in the order of their capture times; CaptureError after the last."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._files = iter(sorted(_stamped(path)))
        self._number = 0

    def read(self) -> Frame:
        for stamp_ns, file in self._files:
            self._number += 1
            try:
                data = np.frombuffer(file.read_bytes(), dtype=np.uint8)
                image = cv2.imdecode(data, _AS_RECORDED) if data.size else None
            except (OSError, cv2.error) as error:
                raise BrokenFrameError(f"{file} cannot be read: {error}") from error
            if image is None:
                raise BrokenFrameError(f"{file} is not a picture")
            return Frame(self._number, stamp_ns, image.astype(np.uint8, copy=False))
        raise CaptureError(f"{self._path} ended after {self._number} pictures")

    def close(self) -> None:
        self._files = iter(())


def _stamped(path: Path) -> list[tuple[int, Path]]:
    try:
        files = [file for file in path.iterdir() if file.suffix.lower() in PICTURE_SUFFIXES]
    except OSError as error:
        raise CaptureError(f"{path} cannot be read: {error.strerror}") from error
    stamped = [(int(file.stem), file) for file in files if file.stem.isascii() and file.stem.isdigit()]
    if not stamped:
        raise CaptureError(f"{path} holds no pictures named by their capture time in nanoseconds")
    return stamped
