"""What a camera is to the rest: newest frame wins, and how it does (spec localization, "Inputs").

A `Capture` talks to one device, file or ring and may block or fail; a `Source` wraps one so that neither reaches its user.
"""

from dataclasses import dataclass
from typing import Protocol

from protocol.frames import Frame


class SourceError(Exception):
    """Base of the errors of captures; the text says what happened to which source."""


class CaptureError(SourceError):
    """The capture is over (it ended, broke down, was unplugged): close it and open another."""


class BrokenFrameError(SourceError):
    """One frame is unusable; the next may be fine."""


class Capture(Protocol):
    """A device being read, by one thread."""

    def read(self) -> Frame | None:
        """The next frame, or None when none came within a fraction of a second. May block. CaptureError, BrokenFrameError."""
        ...

    def close(self) -> None:
        """Lets the device go."""
        ...


@dataclass(frozen=True, slots=True)
class SourceState:
    """How a source does. `error` says what is wrong now, None when frames arrive as they should; `error_since_ns` is when it
    last was well (wall clock; when it was opened, if it never was). `received` counts good frames, `broken` unusable ones,
    `skipped` good ones that newer ones replaced before they were asked for."""

    connected: bool
    error: str | None
    received: int
    broken: int
    skipped: int
    error_since_ns: int | None = None


class Source(Protocol):
    """Frames of one camera, the newest first and each at most once."""

    def newest(self, timeout_s: float) -> Frame | None:
        """The newest frame not given before; waits up to `timeout_s` for one, None when none came. Never raises for what the
        camera does; never blocks longer, even when the device hangs."""
        ...

    @property
    def state(self) -> SourceState: ...

    def close(self) -> None:
        """Ends reading; a device that hangs is left behind."""
        ...
