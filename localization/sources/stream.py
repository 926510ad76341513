"""A camera whose stream OpenCV's network backend (FFmpeg) reads: RTSP, and HTTP that is no MJPEG. Frames are stamped when
they arrive; the backend is told to hold none back."""

import os
import threading
from typing import Any

import cv2
import numpy as np

from localization.sources.base import BrokenFrameError, CaptureError
from protocol.clock import Clock
from protocol.frames import Frame
from protocol.lab.address import without_password

_OPEN_TIMEOUT_MS = 5000
_READ_TIMEOUT_MS = 3000
"""The network backend would otherwise wait half a minute for a camera that was unplugged."""
_OPTIONS = "rtsp_transport;tcp|fflags;nobuffer|flags;low_delay"
"""TCP, because lost UDP packets smear every frame up to the next key frame; no buffer for reordering, no frames held back.
OpenCV takes FFmpeg's options from the environment alone; what is set there already is the user's own wish."""
_VARIABLE = "OPENCV_FFMPEG_CAPTURE_OPTIONS"


class _StreamOptions:
    """The options are in the environment only while streams are being opened: a file that is read with them loses its first
    frame."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._opening = 0
        self._ours = False

    def __enter__(self) -> None:
        with self._lock:
            if self._opening == 0 and _VARIABLE not in os.environ:
                os.environ[_VARIABLE], self._ours = _OPTIONS, True
            self._opening += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._opening -= 1
            if self._opening == 0 and self._ours:
                os.environ.pop(_VARIABLE, None)
                self._ours = False


_stream_options = _StreamOptions()


class StreamCapture:
    """CaptureError, also from the constructor, when nothing comes within seconds."""

    def __init__(self, url: str, clock: Clock) -> None:
        self._name, self._clock = without_password(url), clock
        timeouts: list[Any] = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, _OPEN_TIMEOUT_MS]
        timeouts += [cv2.CAP_PROP_READ_TIMEOUT_MSEC, _READ_TIMEOUT_MS]
        try:
            with _stream_options:
                self._video = cv2.VideoCapture(url, cv2.CAP_FFMPEG, timeouts)
        except cv2.error as error:
            raise CaptureError(f"{self._name} cannot be opened: {error.err}") from error
        if not self._video.isOpened():
            self._video.release()
            raise CaptureError(f"{self._name} cannot be opened")
        self._number = 0

    def read(self) -> Frame:
        grabbed = self._video.grab()
        stamp_ns = self._clock.now_ns()
        if not grabbed:
            raise CaptureError(f"{self._name} gives no more frames")
        ok, image = self._video.retrieve()
        self._number += 1
        if not ok:
            raise BrokenFrameError(f"{self._name} sent a frame that cannot be decoded")
        return Frame(self._number, stamp_ns, image.astype(np.uint8, copy=False))

    def close(self) -> None:
        self._video.release()
