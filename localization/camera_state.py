"""How a camera does, counted over the last seconds: rate, latency, stage timings, what is wrong."""

from collections import deque
from dataclasses import dataclass
from statistics import median

from localization.pipeline import CameraPipeline
from localization.sources import SourceState
from protocol.messages import CameraState, FrameDetections

_WINDOW_S = 3.0
_BLIND_S = 2.0
"""No floor tag for so long, where there were some: longer than full searches are apart."""
_BLIND = "none of its floor tags is seen any more: is it covered, dark, or disturbed?"


@dataclass(frozen=True, slots=True)
class _Done:
    at_s: float
    latency_ms: float
    timings_ms: dict[str, float]


class CameraStatistics:
    """Remembers what the frames of the last seconds took."""

    def __init__(self, start_s: float) -> None:
        self._done: deque[_Done] = deque()
        self._start_s = start_s
        self._problem_since_ns: int | None = None
        self._saw_floor_ns: int | None = None
        self.frames = 0

    def add(self, detections: FrameDetections, now_s: float) -> None:
        """A frame was processed and sent at the (monotonic) time `now_s`."""
        latency_ms = (detections.sent_ns - detections.stamp_ns) * 1e-6
        self._done.append(_Done(now_s, latency_ms, detections.timings_ms))
        self.frames += 1

    def state(self, source: SourceState, pipeline: CameraPipeline, now_s: float, now_ns: int) -> CameraState:
        """The message; its `error` is the source's, or else what is wrong with the calibration. To be called often: since when
        a calibration is wrong is known from the calls."""
        while self._done and now_s - self._done[0].at_s > _WINDOW_S:
            self._done.popleft()
        span_s = min(_WINDOW_S, max(0.1, now_s - self._start_s))
        stages = {stage for done in self._done for stage in done.timings_ms}
        extrinsics, problem = pipeline.extrinsics, pipeline.problem
        if pipeline.floor_tags_seen:
            self._saw_floor_ns = now_ns
        if problem is None and self._saw_floor_ns is not None and now_ns - self._saw_floor_ns > _BLIND_S * 1e9:
            problem, self._problem_since_ns = _BLIND, self._saw_floor_ns
        # A problem's words change with its numbers, not its beginning.
        self._problem_since_ns = None if problem is None else self._problem_since_ns or now_ns
        return CameraState(
            camera=pipeline.spec.id,
            stamp_ns=now_ns,
            connected=source.connected,
            error=source.error or problem,
            error_since_ns=source.error_since_ns if source.error else self._problem_since_ns,
            width=pipeline.spec.width,
            height=pipeline.spec.height,
            rate_hz=len(self._done) / span_s,
            latency_ms=median(done.latency_ms for done in self._done) if self._done else 0.0,
            frames=self.frames,
            broken=source.broken,
            skipped=source.skipped,
            floor_tags_seen=pipeline.floor_tags_seen,
            reprojection_px=None if extrinsics is None else extrinsics.reprojection_px,
            timings_ms={
                stage: median(done.timings_ms[stage] for done in self._done if stage in done.timings_ms)
                for stage in sorted(stages)
            },
        )
