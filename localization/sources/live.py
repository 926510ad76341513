"""Reads a capture in a thread of its own: newest wins, a freeze holds nobody up, what fails is opened again.

The reader puts frames into a ring (`sources.ring_buffer`) and never waits for who takes them. A reader that hangs inside its
device is abandoned after a while and another one started.
"""

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import cast

import cv2
import numpy as np

from localization.sources.base import BrokenFrameError, Capture, CaptureError, SourceState
from localization.sources.ring_buffer import FrameRing
from protocol.clock import Clock
from protocol.frames import Frame
from protocol.lab import CameraSpec

_logger = logging.getLogger(__name__)

_STARTING_S = 5.0
"""What goes wrong before a first frame, this early, is a lab that is still starting: no warning yet."""
_BREATH_S = 0.005
"""After a broken frame, so that a device that sends nothing else does not take a whole core."""
_MOST_ABANDONED = 3
"""Hanging readers that are waited for at most; each holds its device and a stack."""


@dataclass(frozen=True, slots=True)
class Patience:
    """`stall_s`: silence that is reported; `abandon_s`: silence after which a hanging reader is given up, clearly longer than
    any capture may take to open or to read (OpenCV waits 10 s for a V4L2 device); `first_retry_s`, `last_retry_s`: pauses
    before opening again, doubling in between."""

    stall_s: float = 1.0
    abandon_s: float = 20.0
    first_retry_s: float = 0.1
    last_retry_s: float = 5.0


class LiveSource:
    """A `Source` over captures that `open_capture` makes (it may block and raise CaptureError)."""

    def __init__(
        self,
        spec: CameraSpec,
        open_capture: Callable[[], Capture],
        clock: Clock,
        patience: Patience | None = None,
    ) -> None:
        self._spec, self._open, self._clock = spec, open_capture, clock
        given = patience or Patience()
        # A slow camera is not a stalled one.
        self._patience = Patience(
            max(given.stall_s, 5.0 / spec.rate_hz), given.abandon_s, given.first_retry_s, given.last_retry_s
        )
        self._ring = FrameRing()
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._connected = False
        self._error: str | None = "no frame yet"
        self._received = self._broken = 0
        self._well_ns = clock.now_ns()
        self._started_s = self._last_sign_s = self._last_frame_s = clock.monotonic_s()
        self._readers: list[threading.Thread] = []
        self._start_reader()

    @property
    def state(self) -> SourceState:
        with self._lock:
            silence_s = self._clock.monotonic_s() - self._last_frame_s
            silent = silence_s > self._patience.stall_s
            # A broken frame between good ones is counted, but no reason for alarm.
            error = self._error if silent or not self._connected or not self._received else None
            if error is None and silent:
                error = f"no frame for {silence_s:.1f} s"
            return SourceState(
                connected=self._connected and not silent,
                error=error,
                received=self._received,
                broken=self._broken,
                skipped=self._ring.skipped,
                error_since_ns=None if error is None else self._well_ns,
            )

    def newest(self, timeout_s: float) -> Frame | None:
        return self._taken(self._ring.newest(timeout_s))

    def oldest(self, timeout_s: float) -> Frame | None:
        """The oldest frame that is still there: for who wants every one (the ring forgives a short delay)."""
        return self._taken(self._ring.oldest(timeout_s))

    def close(self) -> None:
        self._ended.set()
        self._ring.close()
        self._readers[-1].join(timeout=0.5)

    def _taken(self, frame: Frame | None) -> Frame | None:
        if frame is None:
            self._replace_hanging_reader()
        return frame

    def _start_reader(self) -> None:
        name = f"reader-{self._spec.id}-{len(self._readers)}"
        reader = threading.Thread(target=self._read, name=name, daemon=True)
        self._readers.append(reader)
        reader.start()

    def _replace_hanging_reader(self) -> None:
        with self._lock:
            silence_s = self._clock.monotonic_s() - self._last_sign_s
            if self._ended.is_set() or silence_s < self._patience.abandon_s:
                return
            self._readers = [reader for reader in self._readers if reader.is_alive()]
            self._connected = False
            self._error = f"the device hangs: no sign of it for {silence_s:.0f} s"
            if len(self._readers) > _MOST_ABANDONED:
                return
            self._last_sign_s = self._clock.monotonic_s()
        _logger.warning("camera %s: %s, opening it again", self._spec.id, self._error)
        self._start_reader()

    def _in_charge(self) -> bool:
        return not self._ended.is_set() and self._readers[-1] is threading.current_thread()

    def _read(self) -> None:
        delay_s = self._patience.first_retry_s
        while self._in_charge():
            before = self._received
            try:
                self._read_one_capture()
            except CaptureError as error:
                self._report(str(error), connected=False)
            except Exception as error:
                # A driver's surprise costs this capture, not the camera.
                _logger.exception("camera %s: reading failed", self._spec.id)
                self._report(f"reading failed: {error}", connected=False)
            if self._received > before:
                delay_s = self._patience.first_retry_s
            self._ended.wait(delay_s)
            delay_s = min(self._patience.last_retry_s, 2 * delay_s)

    def _read_one_capture(self) -> None:
        """Opens one and reads until this reader is no longer in charge; CaptureError when the capture is over."""
        with self._lock:  # the pause before is no sign of a hanging device
            if not self._in_charge():
                return
            self._last_sign_s = self._clock.monotonic_s()
        capture = self._open()
        try:
            while self._in_charge():
                try:
                    raw = capture.read()
                    frame = None if raw is None else self._made_usable(raw)
                except BrokenFrameError as error:
                    self._report(str(error), connected=True, broken=True)
                    self._ended.wait(_BREATH_S)
                    continue
                self._take(frame)
        finally:
            capture.close()

    def _made_usable(self, raw: Frame) -> Frame:
        start_s = self._clock.monotonic_s()
        frame = checked(raw, self._spec)
        if frame is raw:
            return raw
        return replace(frame, decode_ms=frame.decode_ms + (self._clock.monotonic_s() - start_s) * 1e3)

    def _take(self, frame: Frame | None) -> None:
        with self._lock:
            if not self._in_charge():
                return
            self._last_sign_s = self._clock.monotonic_s()
            if frame is None:
                return
            self._last_frame_s, self._well_ns = self._last_sign_s, self._clock.now_ns()
            self._connected, self._error = True, None
            self._received += 1
            self._ring.put(frame)

    def _report(self, error: str, *, connected: bool, broken: bool = False) -> None:
        with self._lock:
            if not self._in_charge():
                return
            if error != self._error:
                starting = not self._received and self._clock.monotonic_s() - self._started_s < _STARTING_S
                _logger.log(logging.INFO if starting else logging.WARNING, "camera %s: %s", self._spec.id, error)
            self._last_sign_s = self._clock.monotonic_s()
            self._connected, self._error = connected, error
            self._broken += broken


def checked(frame: Frame, spec: CameraSpec) -> Frame:
    """The frame in the shape that the lab description promises: its size, grey unless the camera is in colour.

    BrokenFrameError for everything else: a frame of another size would be undistorted with the wrong numbers.
    """
    pixels = frame.pixels
    if pixels.dtype != np.uint8 or pixels.ndim not in (2, 3) or (pixels.ndim == 3 and pixels.shape[2] != 3):
        raise BrokenFrameError(f"a frame is {pixels.dtype} of shape {pixels.shape}, not an 8-bit grey or BGR image")
    height, width = pixels.shape[:2]
    if (width, height) != (spec.width, spec.height):
        raise BrokenFrameError(
            f"a frame is {width} x {height}, the lab description says {spec.width} x {spec.height}; it is not used"
        )
    if pixels.ndim == 3 and not spec.color:
        grey = cast("np.ndarray[tuple[int, int], np.dtype[np.uint8]]", cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY))
        return replace(frame, pixels=grey)
    return frame
