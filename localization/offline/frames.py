"""The frames of one recorded camera in the order of their capture times (design, "Recordings").

A `RecordedCamera` is what was found on disk: nothing is decoded yet, but every capture time is known. It can be opened as
often as needed; a `FrameReader` decodes one frame at a time, in grey, so memory does not grow with the recording.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.detection import to_grey
from localization.offline.errors import RecordingError
from localization.sources import BrokenFrameError
from protocol.lab import CameraSpec

Grey = NDArray[np.uint8]

_AS_RECORDED = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
"""Eight bits, grey; a camera's pictures lie as its sensor does."""


class FrameReader(Protocol):
    """Reads a recorded camera's frames once, by one thread at a time."""

    @property
    def next_ns(self) -> int | None:
        """Capture time of the frame that `read` gives next; None after the last."""
        ...

    def read(self) -> Grey | None:
        """The next frame, shape (height, width); None when there is none after all. BrokenFrameError, naming it, for one
        that cannot be decoded (the next may be fine); RecordingError for one of another size than the lab file's."""
        ...

    def skip(self) -> None:
        """Passes over the next frame."""
        ...

    def close(self) -> None: ...


class RecordedCamera(Protocol):
    """One camera of a recording."""

    @property
    def spec(self) -> CameraSpec: ...

    @property
    def stamps_ns(self) -> Sequence[int]:
        """Capture times, increasing; for a video without stamps of as many frames as the container claims to have."""
        ...

    def open(self) -> FrameReader:
        """Begins with the first frame. RecordingError when it cannot be opened any more."""
        ...


@dataclass(frozen=True, slots=True)
class PictureFolder:
    """A camera recorded as pictures; `files` belong to `stamps_ns`."""

    spec: CameraSpec
    stamps_ns: tuple[int, ...]
    files: tuple[Path, ...]

    def open(self) -> "PictureReader":
        return PictureReader(self)


class PictureReader:
    """A `FrameReader` of a folder."""

    def __init__(self, camera: PictureFolder) -> None:
        self._camera = camera
        self._index = 0

    @property
    def next_ns(self) -> int | None:
        stamps = self._camera.stamps_ns
        return stamps[self._index] if self._index < len(stamps) else None

    def read(self) -> Grey | None:
        if self.next_ns is None:
            return None
        file = self._camera.files[self._index]
        self._index += 1
        try:
            data = np.frombuffer(file.read_bytes(), dtype=np.uint8)
            image = cv2.imdecode(data, _AS_RECORDED) if data.size else None
        except (OSError, cv2.error) as error:
            raise BrokenFrameError(f"{file} cannot be read: {error}") from error
        if image is None:
            raise BrokenFrameError(f"{file} is not a picture")
        return _of_size(image.astype(np.uint8, copy=False), self._camera.spec, str(file))

    def skip(self) -> None:
        self._index += 1

    def close(self) -> None:
        self._index = len(self._camera.stamps_ns)


@dataclass(frozen=True, slots=True)
class VideoFile:
    """A camera recorded as a video. `frames` are the numbers (from 0) of the frames that `stamps_ns` belong to: those in
    between, whose stamps go backwards, are passed over."""

    spec: CameraSpec
    stamps_ns: tuple[int, ...]
    frames: tuple[int, ...]
    path: Path

    def open(self) -> "VideoReader":
        return VideoReader(self)


class VideoReader:
    """A `FrameReader` of a video."""

    def __init__(self, camera: VideoFile) -> None:
        self._camera = camera
        self._video = opened_video(camera.path)
        self._index = 0
        self._frame = 0

    @property
    def next_ns(self) -> int | None:
        stamps = self._camera.stamps_ns
        return stamps[self._index] if self._index < len(stamps) else None

    def read(self) -> Grey | None:
        if not self._grab():
            return None
        ok, image = self._video.retrieve()
        name = f"frame {self._frame} of {self._camera.path}"
        if not ok:
            raise BrokenFrameError(f"{name} cannot be decoded")
        return _of_size(to_grey(image.astype(np.uint8, copy=False)), self._camera.spec, name)

    def skip(self) -> None:
        self._grab()

    def close(self) -> None:
        self._video.release()

    def _grab(self) -> bool:
        """Goes on to the next frame that has a stamp; a video that is shorter than it claims ends here."""
        if self.next_ns is None:
            return False
        wanted = self._camera.frames[self._index]
        self._index += 1
        while self._frame <= wanted:
            if not self._video.grab():
                self._index = len(self._camera.stamps_ns)
                return False
            self._frame += 1
        return True


def opened_video(path: Path) -> cv2.VideoCapture:
    """RecordingError when OpenCV finds no video in the file."""
    try:
        video = cv2.VideoCapture(str(path))
    except cv2.error as error:
        raise RecordingError(f"{path} cannot be opened as a video: {error}") from error
    if not video.isOpened():
        video.release()
        raise RecordingError(f"{path} cannot be opened as a video")
    return video


def _of_size(grey: Grey, spec: CameraSpec, name: str) -> Grey:
    height, width = grey.shape
    if (width, height) != (spec.width, spec.height):
        raise RecordingError(
            f"{name} is {width} x {height}, the lab description of {spec.id} says {spec.width} x {spec.height}"
        )
    return grey
