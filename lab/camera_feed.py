"""One simulated camera at its rate: frames are drawn by a worker thread and put into the camera's ring.

At most one frame of a camera is on its way. When the machine cannot keep up, the next one is left out: all cameras lose
frames alike, none falls behind, and the achieved rate is logged.
"""

import logging
from concurrent.futures import Executor, Future
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lab.camera_faults import covered_window, random_pixels, renderer_for
from lab.rendering import CameraRenderer
from lab.snapshot import Snapshot
from lab.world import World
from protocol.frames import FrameWriter
from protocol.lab import Lab
from protocol.messages import CameraFault, FaultKind

_REPORT_PERIOD_NS = 10_000_000_000
_NOTEWORTHY_SHARE = 0.05
"""A smaller share of frames left out is the scheduling of a busy machine."""
_logger = logging.getLogger(__name__)


class CameraFeed:
    """`phase` in [0, 1) staggers the cameras within a period, so that they do not all draw at once."""

    def __init__(self, lab: Lab, renderer: CameraRenderer, ring: Path, phase: float, executor: Executor) -> None:
        spec = renderer.spec
        self.camera_id = spec.id
        self.renderer = renderer
        self.fault: CameraFault | None = None
        self.drawn = 0
        self.skipped = 0
        self._rate_hz = spec.rate_hz
        self._period_ns = round(1e9 / spec.rate_hz)
        self._phase_ns = round(phase * self._period_ns)
        self._lab, self._ring = lab, ring
        self._suffered: CameraFault | None = None
        self._writer: FrameWriter | None = FrameWriter(ring, spec.width, spec.height, color=spec.color)
        self._pixels = np.zeros(renderer.shape, dtype=np.uint8)
        self._executor = executor
        self._pending: Future[None] | None = None
        self._next_ns: int | None = None
        self._report_ns = 0
        self._reported = (0, 0)

    def tick(self, world: World) -> None:
        """To be called after every step of the world: has a frame drawn when it is time. Raises what drawing raised."""
        stamp_ns = world.stamp_ns
        if self._next_ns is None or abs(stamp_ns - self._next_ns) > 2 * self._period_ns:
            behind_ns = (stamp_ns - self._phase_ns) % self._period_ns
            self._next_ns = stamp_ns - behind_ns + self._period_ns  # the first, or the world's time was set
        if stamp_ns >= self._next_ns:
            self._next_ns += self._period_ns
            self._expose(world.snapshot())
        self._report(stamp_ns)

    def close(self) -> None:
        """Waits for the frame on its way (some milliseconds) and removes the ring."""
        if self._pending is not None and not self._pending.cancel():
            self._pending.exception()
        if self._writer is not None:
            self._writer.close()

    def _expose(self, snapshot: Snapshot) -> None:
        if self._pending is not None:
            if not self._pending.done():
                self.skipped += 1
                return
            self._pending.result()
        self.drawn += 1
        self._pending = self._executor.submit(self._draw, snapshot, self.drawn)

    def _draw(self, snapshot: Snapshot, number: int) -> None:
        fault = self.fault
        if fault != self._suffered:
            self._suffer(fault)
        kind = None if fault is None else fault.kind
        if self._writer is None or kind is FaultKind.STALL:
            return
        if kind is FaultKind.NOISE:
            self._pixels[...] = random_pixels(self._pixels.shape, self.camera_id, number)
        else:
            self.renderer.render(snapshot, number, self._pixels)
        self._writer.write(_halved(self._pixels) if kind is FaultKind.RESIZE else self._pixels, snapshot.stamp_ns)

    def _suffer(self, fault: CameraFault | None) -> None:
        """Makes the camera and its ring as the new fault, or its end, has them."""
        kind = None if fault is None else fault.kind
        kinds = {kind, None if self._suffered is None else self._suffered.kind}
        _logger.info("camera %s: %s", self.camera_id, "well again" if kind is None else f"made to suffer: {kind}")
        self._suffered = fault
        if FaultKind.BUMP in kinds:
            try:
                self.renderer = renderer_for(self._lab, self.camera_id, fault)
            except ValueError as error:
                _logger.warning("camera %s stays where it is: %s", self.camera_id, error)
        spec = self.renderer.spec
        self.renderer.covered = covered_window(fault, spec.width, spec.height)
        if kinds & {FaultKind.UNPLUG, FaultKind.RESIZE}:
            if self._writer is not None:
                self._writer.close()
            self._writer = None
            if kind is not FaultKind.UNPLUG:
                height, width = (_halved(self._pixels) if kind is FaultKind.RESIZE else self._pixels).shape[:2]
                self._writer = FrameWriter(self._ring, width, height, color=spec.color)

    def _report(self, stamp_ns: int) -> None:
        if stamp_ns - self._report_ns < _REPORT_PERIOD_NS:
            return
        seconds = (stamp_ns - self._report_ns) / 1e9
        drawn, skipped = self.drawn - self._reported[0], self.skipped - self._reported[1]
        if self._report_ns and skipped > _NOTEWORTHY_SHARE * (drawn + skipped):
            _logger.warning(
                "camera %s: %.1f of %.1f frames per second, %d left out because the machine is too slow",
                self.camera_id,
                drawn / seconds,
                self._rate_hz,
                skipped,
            )
        self._report_ns, self._reported = stamp_ns, (self.drawn, self.skipped)


def _halved(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return pixels[::2, ::2]
