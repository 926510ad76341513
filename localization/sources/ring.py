"""A simulated camera: frames that the lab renders into shared memory (`protocol.frames`)."""

from pathlib import Path

from localization.sources.base import CaptureError
from protocol.clock import Clock
from protocol.errors import DecodeError
from protocol.frames import Frame, FrameReader

_POLL_S = 0.002
_WAIT_S = 0.25
_QUIET_SHARE = 0.6
"""Of the time between two frames, the part in which none is looked for."""


class RingCapture:
    """Reads the newest frame of a ring; CaptureError while there is none, and when another took its place."""

    def __init__(self, path: Path, rate_hz: float, clock: Clock) -> None:
        self._path, self._clock = path, clock
        self._quiet_s = min(_WAIT_S, _QUIET_SHARE / rate_hz)
        try:
            self._reader = FrameReader(path)
        except FileNotFoundError as error:
            raise CaptureError("the simulated lab gives no frames yet") from error
        except (DecodeError, OSError) as error:
            raise CaptureError(str(error)) from error
        self._last_frame_s: float | None = None

    def read(self) -> Frame | None:
        start_s = self._clock.monotonic_s()
        if self._last_frame_s is not None:
            self._clock.wait(self._last_frame_s + self._quiet_s - start_s)
        while True:
            frame = self._reader.newest()
            now_s = self._clock.monotonic_s()
            if frame is not None:
                self._last_frame_s = now_s
                return frame
            if now_s - start_s >= _WAIT_S:
                if self._reader.replaced():
                    raise CaptureError("the simulated lab ended or restarted")
                return None
            self._clock.wait(_POLL_S)

    def close(self) -> None:
        self._reader.close()
