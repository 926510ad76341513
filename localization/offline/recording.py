"""Recordings: a folder with one video file or one sub-folder of pictures per camera (design, "Recordings").

Pictures are named by their capture time in nanoseconds; beside a video `cam0.mp4` lies a text `cam0.stamps` (or
`cam0.mp4.stamps`) with the capture time of each frame, one per line. What is missing or does not belong is a warning as long
as one camera can be used.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

from localization.offline.errors import RecordingError
from localization.offline.frames import PictureFolder, RecordedCamera, VideoFile, opened_video
from localization.sources import PICTURE_SUFFIXES
from protocol.lab import CameraSpec, Lab

LAB_FILE = "lab.yaml"
VIDEO_SUFFIXES = frozenset({".mp4", ".m4v", ".avi", ".mkv", ".mov", ".webm", ".mjpg", ".mjpeg", ".ogv", ".mpg", ".ts"})
_STAMPS_SUFFIX = ".stamps"


@dataclass(frozen=True, slots=True)
class Recording:
    """The cameras found, in the lab file's order, and what people should know about the rest."""

    path: Path
    cameras: tuple[RecordedCamera, ...]
    warnings: tuple[str, ...]

    @property
    def frames(self) -> int:
        """Of all cameras together."""
        return sum(len(camera.stamps_ns) for camera in self.cameras)

    @property
    def rate_hz(self) -> float:
        """Frames per second of the fastest camera (by the median interval); 0 when no camera has two frames."""
        return max((_rate_hz(camera.stamps_ns) for camera in self.cameras), default=0.0)

    @property
    def slowest_hz(self) -> float:
        """Frames per second of the slowest camera; 1 when no camera has two frames."""
        return min((rate for camera in self.cameras if (rate := _rate_hz(camera.stamps_ns)) > 0), default=1.0)

    @property
    def seconds(self) -> float:
        """From the first capture time to the last, over all cameras."""
        first = min(camera.stamps_ns[0] for camera in self.cameras)
        return (max(camera.stamps_ns[-1] for camera in self.cameras) - first) * 1e-9


def open_recording(path: Path, lab: Lab) -> Recording:
    """Looks through the folder for the lab's cameras. RecordingError when it holds none of them, and for what cannot be
    meant: a camera recorded twice, a video that does not open, stamps that are no numbers."""
    entries = _entries(path)
    warnings: list[str] = []
    found: list[RecordedCamera] = []
    unstamped: list[str] = []
    for spec in lab.cameras:
        camera = _camera(path, spec, entries, warnings, unstamped)
        if camera is not None:
            found.append(camera)
    known = {spec.id for spec in lab.cameras}
    strangers = sorted(entry.name for entry in entries if _camera_of(entry) not in known)
    if not found:
        raise RecordingError(
            f"{path} holds no frames of a camera of this lab: looked for a video or a folder of pictures named by their"
            f" capture time in ns for each of {', '.join(sorted(known)) or 'no camera at all'}"
            f"; found {', '.join(strangers) or 'nothing'}{''.join(f'; {warning}' for warning in warnings)}"
        )
    if strangers:
        warnings.append(f"not cameras of this lab, ignored: {', '.join(strangers)}")
    return Recording(path, tuple(_on_one_time(found, unstamped, warnings)), tuple(warnings))


def _entries(path: Path) -> list[Path]:
    """Everything that could be a camera: folders and videos."""
    if not path.exists():
        raise RecordingError(f"{path} does not exist")
    try:
        entries = sorted(entry for entry in path.iterdir() if not entry.name.startswith("."))
    except OSError as error:
        raise RecordingError(f"{path} cannot be read as a recording's folder: {error.strerror}") from error
    return [entry for entry in entries if entry.is_dir() or entry.suffix.lower() in VIDEO_SUFFIXES]


def _camera_of(entry: Path) -> str:
    return entry.name if entry.is_dir() else entry.stem


def _camera(
    path: Path, spec: CameraSpec, entries: Sequence[Path], warnings: list[str], unstamped: list[str]
) -> RecordedCamera | None:
    mine = [entry for entry in entries if _camera_of(entry) == spec.id]
    if len(mine) > 1:
        raise RecordingError(f"{path} has {spec.id} more than once: {', '.join(entry.name for entry in mine)}")
    if not mine:
        warnings.append(f"{spec.id} is not in the recording")
        return None
    if mine[0].is_dir():
        return _folder(spec, mine[0], warnings)
    return _video(spec, mine[0], warnings, unstamped)


def _folder(spec: CameraSpec, path: Path, warnings: list[str]) -> PictureFolder | None:
    try:
        files = sorted(file for file in path.iterdir() if file.suffix.lower() in PICTURE_SUFFIXES)
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror}") from error
    by_stamp: dict[int, Path] = {}
    for file in files:
        if file.stem.isascii() and file.stem.isdigit():
            by_stamp.setdefault(int(file.stem), file)
    if not by_stamp:
        warnings.append(f"{path} holds no pictures named by their capture time in nanoseconds")
        return None
    if len(by_stamp) < len(files):
        count = len(files) - len(by_stamp)
        warnings.append(f"{path}: {count} pictures ignored whose names are no capture time in nanoseconds of their own")
    ordered = sorted(by_stamp.items())
    return PictureFolder(spec, tuple(stamp for stamp, _ in ordered), tuple(file for _, file in ordered))


def _video(spec: CameraSpec, path: Path, warnings: list[str], unstamped: list[str]) -> VideoFile | None:
    video = opened_video(path)
    try:
        claimed, rate_hz = int(video.get(cv2.CAP_PROP_FRAME_COUNT)), float(video.get(cv2.CAP_PROP_FPS))
        if claimed <= 0:
            claimed = _counted(video)
    finally:
        video.release()
    if claimed == 0:
        warnings.append(f"{path} holds no frames")
        return None
    stamps = _stamps_beside(path)
    if stamps is None:
        if not rate_hz > 0:
            raise RecordingError(f"{path} has no stamps beside it and does not say how many frames per second it has")
        unstamped.append(spec.id)
        warnings.append(
            f"{path} has no {path.stem}{_STAMPS_SUFFIX} beside it: taken at {rate_hz:g} frames per second, as the video"
            " says; if that is not when they were captured, speeds and the fusion of cameras are wrong"
        )
        return VideoFile(spec, tuple(round(i * 1e9 / rate_hz) for i in range(claimed)), tuple(range(claimed)), path)
    if len(stamps) != claimed:
        warnings.append(f"{path} has {claimed} frames and {len(stamps)} stamps: the first of both are used")
    frames = _increasing(stamps[:claimed])
    if not frames:
        warnings.append(f"{path}: its stamps are empty")
        return None
    if len(frames) < min(len(stamps), claimed):
        warnings.append(f"{path}: {min(len(stamps), claimed) - len(frames)} frames ignored, their stamps go backwards")
    return VideoFile(spec, tuple(stamps[i] for i in frames), tuple(frames), path)


def _counted(video: cv2.VideoCapture) -> int:
    """Raw streams do not say how many frames they have."""
    count = 0
    while video.grab():
        count += 1
    return count


def _stamps_beside(path: Path) -> list[int] | None:
    for file in (path.with_suffix(_STAMPS_SUFFIX), path.with_name(path.name + _STAMPS_SUFFIX)):
        if file.exists():
            try:
                words = file.read_text(encoding="utf-8").split()
            except (OSError, UnicodeDecodeError) as error:
                raise RecordingError(f"{file} cannot be read: {error}") from error
            odd = next((word for word in words if not (word.isascii() and word.isdigit())), None)
            if odd is not None:
                raise RecordingError(f"{file} should hold one capture time in ns per line, not {odd[:40]!r}")
            return [int(word) for word in words]
    return None


def _increasing(stamps: Sequence[int]) -> list[int]:
    """Indices of the stamps that are later than all before them."""
    kept: list[int] = []
    for index, stamp in enumerate(stamps):
        if not kept or stamp > stamps[kept[-1]]:
            kept.append(index)
    return kept


def _on_one_time(found: list[RecordedCamera], unstamped: list[str], warnings: list[str]) -> Iterable[RecordedCamera]:
    """Videos that know no capture times begin together with the first camera that does."""
    stamped = [camera for camera in found if camera.spec.id not in unstamped]
    if not stamped or not unstamped:
        return found
    start_ns = min(camera.stamps_ns[0] for camera in stamped)
    warnings.append(f"{', '.join(unstamped)}: assumed to begin together with the cameras that have stamps")
    return [
        replace(camera, stamps_ns=tuple(start_ns + stamp for stamp in camera.stamps_ns))
        if isinstance(camera, VideoFile) and camera.spec.id in unstamped
        else camera
        for camera in found
    ]


def _rate_hz(stamps_ns: Sequence[int]) -> float:
    intervals = [after - before for before, after in pairwise(stamps_ns)]
    return 1e9 / float(np.median(intervals)) if intervals else 0.0
