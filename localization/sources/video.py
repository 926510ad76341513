"""A recorded video file, with the capture times that lie beside it."""

from pathlib import Path

import cv2
import numpy as np

from localization.sources.base import CaptureError
from protocol.frames import Frame


class VideoFileCapture:
    """Stamps come from the text `NAME.stamps` or `NAME.mp4.stamps` beside it (one capture time in nanoseconds per frame and
    line), else from the video's own rate, beginning at 0."""

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise CaptureError(f"{path} does not exist")
        self._path = path
        beside = path.with_name(f"{path.name}.stamps")
        self._stamps_file = beside if beside.exists() else path.with_suffix(".stamps")
        self._stamps = _read_stamps(self._stamps_file)
        self._video = _opened(path)
        rate_hz = float(self._video.get(cv2.CAP_PROP_FPS))
        self._period_ns = round(1e9 / rate_hz) if rate_hz > 0 else 0
        self._number = 0

    def read(self) -> Frame:
        ok, image = self._video.read()
        if not ok:
            raise CaptureError(f"{self._path} ended after {self._number} frames")
        index, self._number = self._number, self._number + 1
        if self._stamps is None:
            stamp_ns = index * self._period_ns
        elif index < len(self._stamps):
            stamp_ns = self._stamps[index]
        else:
            raise CaptureError(f"{self._path} has more frames than {self._stamps_file} has lines")
        return Frame(self._number, stamp_ns, image.astype(np.uint8, copy=False))

    def close(self) -> None:
        self._video.release()


def _opened(path: Path) -> cv2.VideoCapture:
    try:
        video = cv2.VideoCapture(str(path))
    except cv2.error as error:
        raise CaptureError(f"{path} cannot be opened: {error.err}") from error
    if not video.isOpened():
        video.release()
        raise CaptureError(f"{path} cannot be opened")
    return video


def _read_stamps(path: Path) -> list[int] | None:
    if not path.exists():
        return None
    try:
        return [int(line) for line in path.read_text().split()]
    except (OSError, ValueError) as error:
        raise CaptureError(f"{path} should hold one capture time in nanoseconds per line: {error}") from error
