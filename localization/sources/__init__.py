"""Where frames come from: one `Source` protocol, one module per kind of camera.

`open_source` chooses by the lab description's `source`: `sim`, a device number, a URL, a video file or a folder of pictures.
"""

from collections.abc import Callable
from pathlib import Path

from localization.sources.base import BrokenFrameError, Capture, CaptureError, Source, SourceError, SourceState
from localization.sources.folder import FolderCapture
from localization.sources.live import LiveSource, Patience
from localization.sources.replay import ReplayCapture
from localization.sources.ring import RingCapture
from localization.sources.video import DeviceCapture, VideoFileCapture
from protocol.clock import Clock
from protocol.lab import CameraSpec
from protocol.settings import frame_ring

__all__ = [
    "BrokenFrameError",
    "Capture",
    "CaptureError",
    "LiveSource",
    "Patience",
    "Source",
    "SourceError",
    "SourceState",
    "open_source",
    "recorded_capture",
]


def open_source(spec: CameraSpec, state: Path, clock: Clock, patience: Patience | None = None) -> Source:
    """The camera's frames; opening happens in the background and is repeated until it works."""
    return LiveSource(spec, _opener(spec, state, clock), clock, patience)


def recorded_capture(path: Path) -> Capture:
    """A recording, frame by frame, with the capture times it was recorded with. CaptureError when it is none."""
    return FolderCapture(path) if path.is_dir() else VideoFileCapture(path)


def _opener(spec: CameraSpec, state: Path, clock: Clock) -> Callable[[], Capture]:
    source = spec.source
    if source == "sim":
        ring = frame_ring(state, spec.id)
        return lambda: RingCapture(ring, spec.rate_hz, clock)
    if isinstance(source, int) or source.isdecimal():
        return lambda: DeviceCapture(int(source), spec, clock)
    if "://" in source or source.startswith("/dev/"):
        return lambda: DeviceCapture(source, spec, clock)
    path = Path(source)
    return lambda: ReplayCapture(recorded_capture(path), clock)
