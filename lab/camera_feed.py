"""One simulated camera at its rate: frames are drawn by a worker thread and put into the camera's ring.

At most one frame of a camera is on its way. When the machine cannot keep up, the next one is left out: all cameras lose
frames alike, none falls behind, and the achieved rate is logged.
"""

import logging
from concurrent.futures import Executor, Future
from pathlib import Path

import numpy as np

from lab.rendering import CameraRenderer
from lab.snapshot import Snapshot
from lab.world import World
from protocol.frames import FrameWriter

_REPORT_PERIOD_NS = 10_000_000_000
_NOTEWORTHY_SHARE = 0.05
"""A smaller share of frames left out is the scheduling of a busy machine."""
_logger = logging.getLogger(__name__)


class CameraFeed:
    """`phase` in [0, 1) staggers the cameras within a period, so that they do not all draw at once."""

    def __init__(self, renderer: CameraRenderer, ring: Path, phase: float, executor: Executor) -> None:
        spec = renderer.spec
        self.camera_id = spec.id
        self.renderer = renderer
        self.drawn = 0
        self.skipped = 0
        self._rate_hz = spec.rate_hz
        self._period_ns = round(1e9 / spec.rate_hz)
        self._phase_ns = round(phase * self._period_ns)
        self._writer = FrameWriter(ring, spec.width, spec.height, color=spec.color)
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
        self.renderer.render(snapshot, number, self._pixels)
        self._writer.write(self._pixels, snapshot.stamp_ns)

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
