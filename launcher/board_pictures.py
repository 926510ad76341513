"""The pictures of a calibration board that a person recorded: a folder of images or a video, in grey."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from launcher.errors import UsageError
from localization.offline.recording import VIDEO_SUFFIXES
from localization.sources import PICTURE_SUFFIXES

_AS_RECORDED = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
"""A lens belongs to its sensor: turned by their EXIF data, pictures would have its centre elsewhere."""


class BoardPictures:
    """Iterates over every `every`-th picture, shape (height, width), in the order of names or of time. Pictures that cannot be
    read are left out and counted in `unreadable`; `taken` says how many were looked for so far, of `total` if that is known
    beforehand. UsageError for a path that holds no pictures."""

    def __init__(self, path: Path, every: int = 1) -> None:
        if not path.exists():
            raise UsageError(f"{path} does not exist")
        self._path, self._every = path, every
        self._files = _pictures_in(path)[::every] if path.is_dir() else None
        self.total = None if self._files is None else len(self._files)
        self.taken = self.unreadable = 0

    def __iter__(self) -> Iterator[NDArray[np.uint8]]:
        self.taken = self.unreadable = 0
        for picture in _read(self._files) if self._files is not None else _decode(self._path, self._every):
            self.taken += 1
            if picture is None:
                self.unreadable += 1
            else:
                yield picture


def of_camera(recording: Path, camera: str) -> Path:
    """Where a recording with a folder or video per camera (docs/recordings.md) has this one's. UsageError when it has none, or
    two."""
    if not recording.is_dir():
        raise UsageError(
            f"{recording} is no folder with a video or pictures per camera; leave --camera out for a single video"
        )
    recorded = {entry: name for entry in _entries(recording) if (name := _camera_in(entry)) is not None}
    mine = [entry for entry, name in recorded.items() if name == camera]
    if not mine:
        raise UsageError(
            f"{recording} has no camera {camera!r}; it has {', '.join(recorded.values()) or 'none at all'}"
        )
    if len(mine) > 1:
        raise UsageError(f"{recording} has {camera} more than once: {', '.join(entry.name for entry in mine)}")
    return mine[0]


def _entries(folder: Path) -> list[Path]:
    """By name, without hidden ones."""
    try:
        return sorted(entry for entry in folder.iterdir() if not entry.name.startswith("."))
    except OSError as error:
        raise UsageError(f"{folder} cannot be read: {error.strerror}") from error


def _camera_in(entry: Path) -> str | None:
    if entry.is_dir():
        return entry.name
    return entry.stem if entry.suffix.lower() in VIDEO_SUFFIXES else None


def _pictures_in(folder: Path) -> list[Path]:
    entries = _entries(folder)
    files = [file for file in entries if file.suffix.lower() in PICTURE_SUFFIXES]
    if files:
        return files
    cameras = [name for entry in entries if (name := _camera_in(entry)) is not None]
    if cameras:
        raise UsageError(f"{folder} holds no pictures itself: choose one of {', '.join(cameras)} with --camera")
    raise UsageError(f"{folder} holds no pictures ({', '.join(sorted(PICTURE_SUFFIXES))})")


def _read(files: list[Path]) -> Iterator[NDArray[np.uint8] | None]:
    for file in files:
        picture = cv2.imread(str(file), _AS_RECORDED)
        yield None if picture is None else picture.astype(np.uint8, copy=False)


def _decode(path: Path, every: int) -> Iterator[NDArray[np.uint8] | None]:
    video = cv2.VideoCapture(str(path))
    try:
        number = 0
        while video.grab():
            if number % every == 0:
                read, picture = video.retrieve()
                yield _grey(picture) if read else None
            number += 1
        if number == 0:
            raise UsageError(f"{path} is neither a folder of pictures nor a video that can be decoded")
    finally:
        video.release()


def _grey(picture: cv2.typing.MatLike) -> NDArray[np.uint8]:
    grey = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    return grey.astype(np.uint8, copy=False)
