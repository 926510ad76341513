"""A recording becomes poses: the live pipeline and tracker over its frames in the order of capture time.

Frames of one instant are searched side by side, all with what was known before it, and fused one after the other; so the
result is the same however many threads there are. A pose belongs to a vehicle and a capture time: when cameras share
that time to the nanosecond, all of them are in it.
"""

from collections import Counter
from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, field

from geometry import SE2
from localization.offline.following import Following
from localization.offline.instants import RecordedFrame, instants
from localization.offline.recording import Recording
from localization.pipeline import CameraPipeline, PipelineOptions
from protocol.clock import SystemClock
from protocol.lab import Lab
from protocol.messages import Calibration, FrameDetections, TrackedPose

_FULL_SEARCHES_HZ = 15.0
"""A newcomer costs at most this share of a second of its poses; quality goes before speed here."""
_TURN = 1.5
"""Within so many periods of the slowest camera every camera has taken a frame."""
_ODD_SHARE = 0.05
"""So many of a vehicle's sights without a pose are worth a word."""


@dataclass
class Statistics:
    """What happened: frames, broken ones and detections by camera; by vehicle the capture times at which it was seen and those at
    which that gave a pose; and sentences for people, each once."""

    frames: Counter[str] = field(default_factory=Counter[str])
    broken: Counter[str] = field(default_factory=Counter[str])
    detections: Counter[str] = field(default_factory=Counter[str])
    sights: Counter[str] = field(default_factory=Counter[str])
    poses: Counter[str] = field(default_factory=Counter[str])
    warnings: dict[str, str] = field(default_factory=dict[str, str])

    def warn_once(self, about: str, text: str) -> None:
        self.warnings.setdefault(about, text)


class Localization:
    """One run over a recording. `full_search_every` is K; None: every frame up to 15 Hz, as often at higher rates."""

    def __init__(
        self,
        lab: Lab,
        recording: Recording,
        calibration: Calibration,
        executor: Executor,
        full_search_every: int | None = None,
    ) -> None:
        self._cameras = [camera for camera in recording.cameras if camera.spec.id in calibration.cameras]
        self._executor = executor
        self.full_search_every = full_search_every or max(1, round(recording.rate_hz / _FULL_SEARCHES_HZ))
        self._lines = {
            camera.spec.id: _Line(lab, camera.spec.id, calibration, self.full_search_every) for camera in self._cameras
        }
        self._following = Following(lab, round(_TURN / recording.slowest_hz * 1e9))
        self.statistics = Statistics()

    @property
    def frames(self) -> int:
        """How many frames there are to go through, as far as the recording says."""
        return sum(len(camera.stamps_ns) for camera in self._cameras)

    def poses(self) -> Iterator[list[TrackedPose]]:
        """The poses of each instant, by capture time and vehicle, one per vehicle and time. RecordingError for frames that
        the lab file does not describe."""
        for instant in instants(self._cameras, self._executor):
            yield self._localized(instant)
        for vehicle, seen in self.statistics.sights.items():
            without = seen - self.statistics.poses[vehicle]
            if without > _ODD_SHARE * seen:
                self.statistics.warn_once(
                    f"sights {vehicle}",
                    f"{vehicle}: {without} of {seen} times it was seen where its track had no place for it; is its tag's"
                    " id there twice?",
                )
        for vehicle, times in self._following.begun_anew.items():
            self.statistics.warn_once(
                f"jumps {vehicle}",
                f"{vehicle}: {times} times it was where it could not have driven within its limits in the lab file; its"
                " track begins anew there",
            )

    def _localized(self, instant: list[RecordedFrame]) -> list[TrackedPose]:
        newest = self._following.newest
        pending = [
            self._executor.submit(self._lines[item.camera].process, item, newest)
            for item in instant
            if item.frame is not None
        ]
        for item in instant:
            self.statistics.frames[item.camera] += 1
            if item.frame is None:
                self.statistics.broken[item.camera] += 1
                self.statistics.warn_once(f"broken {item.camera}", f"{item.problem}; it is left out, and so are others")
        found = [task.result() for task in pending]
        updated: dict[tuple[int, str], TrackedPose] = {}
        seen: set[tuple[int, str]] = set()
        for detections in found:  # in the order of capture time
            self._note(detections)
            seen |= {(detections.stamp_ns, vehicle) for vehicle in self._following.seen(detections)}
            for pose in self._following.update(detections):
                updated[pose.stamp_ns, pose.vehicle] = pose
        for duplicate in self._following.take_duplicates():
            self.statistics.warn_once(f"duplicate {duplicate.vehicle}", f"at {duplicate.stamp_ns} ns: {duplicate}")
        ordered = [updated[key] for key in sorted(updated)]
        self.statistics.poses.update(pose.vehicle for pose in ordered)
        self.statistics.sights.update(vehicle for _, vehicle in seen)
        return ordered

    def _note(self, detections: FrameDetections) -> None:
        self.statistics.detections[detections.camera] += len(detections.detections)
        problem = self._lines[detections.camera].problem
        if problem is not None:
            text = f"{detections.camera}, at {detections.stamp_ns} ns: {problem}"
            self.statistics.warn_once(f"calibration {detections.camera}", text)


class _RecordedClock(SystemClock):
    """Now is the capture time of the frame being looked at: nothing waits in a recording. Durations are real."""

    def __init__(self) -> None:
        self.stamp_ns = 0

    def now_ns(self) -> int:
        return self.stamp_ns


class _Line:
    """One camera's pipeline; serves one thread at a time."""

    def __init__(self, lab: Lab, camera: str, calibration: Calibration, full_search_every: int) -> None:
        self._clock = _RecordedClock()
        extrinsics = calibration.cameras[camera].extrinsics(camera, calibration.stamp_ns)
        options = PipelineOptions(full_search_every=full_search_every)
        self._pipeline = CameraPipeline(lab, camera, clock=self._clock, options=options, extrinsics=extrinsics)
        floor_tags = {tag: SE2(place.x, place.y, place.yaw) for tag, place in calibration.floor_tags.items()}
        self._pipeline.adopt(extrinsics, floor_tags)

    @property
    def problem(self) -> str | None:
        return self._pipeline.problem

    def process(self, recorded: RecordedFrame, newest: dict[str, TrackedPose]) -> FrameDetections:
        assert recorded.frame is not None
        self._clock.stamp_ns = recorded.stamp_ns
        return self._pipeline.process(recorded.frame, newest)
