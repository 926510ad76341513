"""Everything that OpenCV's VideoCapture opens: video files, RTSP and HTTP URLs, V4L2 device numbers."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from localization.sources.base import BrokenFrameError, CaptureError
from protocol.clock import Clock
from protocol.frames import Frame
from protocol.lab import CameraSpec

_OPEN_TIMEOUT_MS = 5000
_READ_TIMEOUT_MS = 3000
"""The network backend would otherwise wait half a minute for a camera that was unplugged."""


class DeviceCapture:
    """A live camera, by device number or URL. Frames are stamped when they arrive."""

    def __init__(self, source: str | int, spec: CameraSpec, clock: Clock) -> None:
        self._source, self._clock = source, clock
        self._video = _opened(source)
        if isinstance(source, int):
            self._video.set(cv2.CAP_PROP_FRAME_WIDTH, spec.width)
            self._video.set(cv2.CAP_PROP_FRAME_HEIGHT, spec.height)
            self._video.set(cv2.CAP_PROP_FPS, spec.rate_hz)
            self._video.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        self._number = 0

    def read(self) -> Frame:
        grabbed = self._video.grab()
        stamp_ns = self._clock.now_ns()
        if not grabbed:
            raise CaptureError(f"{self._source} gives no more frames")
        ok, image = self._video.retrieve()
        self._number += 1
        if not ok:
            raise BrokenFrameError(f"{self._source} sent a frame that cannot be decoded")
        return Frame(self._number, stamp_ns, image.astype(np.uint8, copy=False))

    def close(self) -> None:
        self._video.release()


class VideoFileCapture:
    """A recorded video. Stamps come from the `.stamps` text beside it (one capture time in nanoseconds per frame and
    line), else from the video's own times, beginning at 0."""

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise CaptureError(f"{path} does not exist")
        self._path = path
        self._stamps = _read_stamps(path.with_suffix(".stamps"))
        self._video = _opened(str(path))
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
            raise CaptureError(f"{self._path} has more frames than {self._path.with_suffix('.stamps')} has lines")
        return Frame(self._number, stamp_ns, image.astype(np.uint8, copy=False))

    def close(self) -> None:
        self._video.release()


def _opened(source: str | int) -> cv2.VideoCapture:
    try:
        if isinstance(source, str) and "://" in source:
            timeouts: list[Any] = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, _OPEN_TIMEOUT_MS]
            timeouts += [cv2.CAP_PROP_READ_TIMEOUT_MSEC, _READ_TIMEOUT_MS]
            video = cv2.VideoCapture(source, cv2.CAP_FFMPEG, timeouts)
        else:
            video = cv2.VideoCapture(source)
    except cv2.error as error:
        raise CaptureError(f"{source} cannot be opened: {error}") from error
    if not video.isOpened():
        video.release()
        raise CaptureError(f"{source} cannot be opened")
    return video


def _read_stamps(path: Path) -> list[int] | None:
    if not path.exists():
        return None
    try:
        return [int(line) for line in path.read_text().split()]
    except (OSError, ValueError) as error:
        raise CaptureError(f"{path} should hold one capture time in nanoseconds per line: {error}") from error
