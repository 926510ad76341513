"""Kinds of camera sources: one line each. A new kind is a module with a `Capture` and its line here."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from localization.sources.base import Capture
from localization.sources.device import DeviceCapture
from localization.sources.folder import FolderCapture
from localization.sources.mjpeg import MjpegCapture, NotMjpegError
from localization.sources.replay import ReplayCapture
from localization.sources.ring import RingCapture
from localization.sources.stream import StreamCapture
from localization.sources.video import VideoFileCapture
from protocol.clock import Clock
from protocol.lab import CameraSpec
from protocol.settings import frame_ring

_NO_VIDEO = ("text/", "image/")


@dataclass(frozen=True, slots=True)
class SourceKind:
    """`fits` says whether a lab description's `source` (as text) is of this kind; `open` may block and raises CaptureError. It
    gets the camera, the state folder and the clock."""

    name: str
    fits: Callable[[str], bool]
    open: Callable[[CameraSpec, Path, Clock], Capture]


def _open_ring(spec: CameraSpec, state: Path, clock: Clock) -> Capture:
    return RingCapture(frame_ring(state, spec.id), spec.rate_hz, clock)


def _open_device(spec: CameraSpec, _state: Path, clock: Clock) -> Capture:
    return DeviceCapture(spec.source, spec, clock)


def _open_http(spec: CameraSpec, _state: Path, clock: Clock) -> Capture:
    """MJPEG by our own reader; other video (MPEG-TS, HLS, ...) by FFmpeg."""
    url = str(spec.source)
    try:
        return MjpegCapture(url, spec, clock)
    except NotMjpegError as error:
        if error.content_type.lower().startswith(_NO_VIDEO):
            raise
        return StreamCapture(url, clock)


def _open_stream(spec: CameraSpec, _state: Path, clock: Clock) -> Capture:
    return StreamCapture(str(spec.source), clock)


def _open_recording(spec: CameraSpec, _state: Path, clock: Clock) -> Capture:
    return ReplayCapture(recorded_capture(Path(str(spec.source))), clock)


def recorded_capture(path: Path) -> Capture:
    """A recording, frame by frame, with the capture times it was recorded with. CaptureError when it is none."""
    return FolderCapture(path) if path.is_dir() else VideoFileCapture(path)


SOURCES = (
    SourceKind("simulated camera", lambda source: source == "sim", _open_ring),
    SourceKind("V4L2 device", lambda source: source.isdecimal() or source.startswith("/dev/"), _open_device),
    SourceKind("HTTP stream", lambda source: source.lower().startswith(("http://", "https://")), _open_http),
    SourceKind("RTSP or other stream", lambda source: "://" in source, _open_stream),
    SourceKind("video file or folder of pictures", lambda _source: True, _open_recording),
)
"""The first that fits is taken."""


def kind_of(source: str | int) -> SourceKind:
    """The kind of a lab description's `source`."""
    return next(kind for kind in SOURCES if kind.fits(str(source)))
