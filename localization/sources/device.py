"""A camera at this machine (V4L2): by number or `/dev/video...`.

Asked for MJPEG, which is what USB cameras need to send Full HD at 60 Hz, and for raw buffers, so that a grey camera's pictures
are decoded to grey at once (`sources.raw_buffers`). Frames bear the driver's capture time.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np

from localization.sources.base import BrokenFrameError, CaptureError
from localization.sources.raw_buffers import FORMATS, format_name, image_of
from protocol.clock import Clock
from protocol.frames import Frame
from protocol.lab import CameraSpec

_OLDEST_S = 1.0
"""A buffer is never held back for longer; a stamp that says so is of another clock."""


class Video(Protocol):
    """The part of cv2.VideoCapture that is used here."""

    def isOpened(self) -> bool: ...
    def set(self, propId: int, value: float) -> bool: ...
    def get(self, propId: int) -> float: ...
    def grab(self) -> bool: ...
    def retrieve(self) -> tuple[bool, Any]: ...
    def release(self) -> None: ...


def _open_v4l2(path: str) -> Video:
    return cv2.VideoCapture(path, cv2.CAP_V4L2)


class DeviceCapture:
    """CaptureError, also from the constructor, when there is no such device, it sends a format that is not understood, or it
    stops."""

    def __init__(
        self, device: str | int, spec: CameraSpec, clock: Clock, open_video: Callable[[str], Video] = _open_v4l2
    ) -> None:
        self._path = f"/dev/video{device}" if isinstance(device, int) or device.isdecimal() else device
        self._color, self._clock = spec.color, clock
        if not Path(self._path).exists():
            raise CaptureError(f"{self._path} does not exist ({_present()})")
        self._video = open_video(self._path)
        if not self._video.isOpened():
            self._video.release()
            raise CaptureError(f"{self._path} cannot be opened: is it a camera, free, and may this user read it?")
        wishes = (
            (cv2.CAP_PROP_FOURCC, float(cv2.VideoWriter.fourcc(*"MJPG"))),
            (cv2.CAP_PROP_FRAME_WIDTH, float(spec.width)),
            (cv2.CAP_PROP_FRAME_HEIGHT, float(spec.height)),
            (cv2.CAP_PROP_FPS, spec.rate_hz),
            (cv2.CAP_PROP_BUFFERSIZE, 1.0),
            (cv2.CAP_PROP_CONVERT_RGB, 0.0),
        )
        for name, value in wishes:  # what a driver refuses shows in the frames, which are checked
            self._video.set(name, value)
        self._format = format_name(self._video.get(cv2.CAP_PROP_FOURCC))
        if self._format not in FORMATS:
            self._video.release()
            named = f"pixel format {self._format}" if self._format else "a pixel format that its driver does not name"
            raise CaptureError(f"{self._path} sends {named}; understood are {', '.join(FORMATS)}")
        self._number = 0

    def read(self) -> Frame:
        if not self._video.grab():
            raise CaptureError(f"{self._path} gives no more frames")
        stamp_ns = self._captured_ns()
        start_s = self._clock.monotonic_s()
        ok, raw = self._video.retrieve()
        self._number += 1
        if not ok or raw is None:
            raise BrokenFrameError(f"{self._path} sent a frame that cannot be read")
        pixels = image_of(np.asarray(raw), self._format, color=self._color)
        return Frame(self._number, stamp_ns, pixels, (self._clock.monotonic_s() - start_s) * 1e3)

    def close(self) -> None:
        self._video.release()

    def _captured_ns(self) -> int:
        """Wall clock of the capture: the driver stamps buffers with the monotonic clock when their first byte comes."""
        now_ns, now_s = self._clock.now_ns(), self._clock.monotonic_s()
        age_s = now_s - self._video.get(cv2.CAP_PROP_POS_MSEC) * 1e-3
        return now_ns - round(age_s * 1e9) if 0.0 <= age_s < _OLDEST_S else now_ns


def _present() -> str:
    found = sorted(str(path) for path in Path("/dev").glob("video*"))
    return f"there are {', '.join(found)}" if found else "this machine has no camera"
