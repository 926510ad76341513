"""Where frames come from: one `Source` protocol, one module per kind of camera, one line each in `sources.registry`.

`open_source` chooses by the lab description's `source`: `sim`, a device number, a URL, a video file or a folder of pictures.
"""

from pathlib import Path

from localization.sources.base import BrokenFrameError, Capture, CaptureError, Source, SourceError, SourceState
from localization.sources.folder import PICTURE_SUFFIXES
from localization.sources.live import LiveSource, Patience
from localization.sources.registry import SOURCES, SourceKind, kind_of, recorded_capture
from localization.sources.ring_buffer import FrameRing
from protocol.clock import Clock
from protocol.lab import CameraSpec

__all__ = [
    "PICTURE_SUFFIXES",
    "SOURCES",
    "BrokenFrameError",
    "Capture",
    "CaptureError",
    "FrameRing",
    "LiveSource",
    "Patience",
    "Source",
    "SourceError",
    "SourceKind",
    "SourceState",
    "kind_of",
    "open_source",
    "recorded_capture",
]


def open_source(spec: CameraSpec, state: Path, clock: Clock, patience: Patience | None = None) -> LiveSource:
    """The camera's frames; opening happens in the background and is repeated until it works."""
    kind = kind_of(spec.source)
    return LiveSource(spec, lambda: kind.open(spec, state, clock), clock, patience)
