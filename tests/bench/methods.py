"""Ours and the published methods behind one interface, so that the same loops measure all of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from launcher.experiments.cameras import FrameClock
from localization.pipeline import CameraPipeline
from localization.tracking import Tracker
from protocol.codec import decode, encode
from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import FrameDetections, TrackedPose
from tests.bench.baselines import Baseline, GulliView2023, GulliView2024, GulliView2025

PUBLISHED_K = {"fullhd": 16, "uhd": 8}
"""The full search's interval that worked best (GulliView 2024, 3.1.5)."""


class CameraMethod(Protocol):
    """One camera's share of the work."""

    def prepare(self, frame: Frame) -> None:
        """Calibration from a single frame, for those that need it before the first."""
        ...

    def process(self, frame: Frame, told: Mapping[str, TrackedPose]) -> bytes:
        """The encoded message of a frame. `told` are the newest tracks that this camera has heard of."""
        ...


class OurCamera:
    """The camera process's way of a frame, without its I/O."""

    def __init__(self, lab: Lab, camera_id: str) -> None:
        self._clock = FrameClock()
        self._pipeline = CameraPipeline(lab, camera_id, clock=self._clock)

    def prepare(self, frame: Frame) -> None:
        """Nothing: it calibrates itself over its first frames."""

    def process(self, frame: Frame, told: Mapping[str, TrackedPose]) -> bytes:
        self._clock.stamp_ns = frame.stamp_ns
        return encode(self._pipeline.process(frame, told))


class Fusion:
    """The tracker process's way of a message, without its I/O."""

    def __init__(self, lab: Lab) -> None:
        self._tracker = Tracker(lab)
        self.poses: dict[str, TrackedPose] = {}
        self.changed: tuple[str, ...] = ()
        """The vehicles whose poses the newest message changed."""

    def fuse(self, message: bytes) -> list[bytes]:
        """One camera's message to those that tell of the poses it changed."""
        changed = self._tracker.update(decode(FrameDetections, message))
        self.poses.update({pose.vehicle: pose for pose in changed})
        self.changed = tuple(pose.vehicle for pose in changed)
        return [encode(pose) for pose in changed]


class PublishedCamera:
    """A baseline, encoding its messages as ours are."""

    def __init__(self, baseline: Baseline) -> None:
        self._baseline = baseline

    def prepare(self, frame: Frame) -> None:
        self._baseline.calibrate(frame)

    def process(self, frame: Frame, told: Mapping[str, TrackedPose]) -> bytes:
        return encode(self._baseline.process(frame))


@dataclass(frozen=True, slots=True)
class Method:
    """`camera` makes one camera's part for a lab, a camera's id and a number of threads. With `fuses` a tracker belongs to it."""

    name: str
    camera: Callable[[Lab, str, int], CameraMethod]
    fuses: bool = False


def methods(resolution: str) -> dict[str, Method]:
    """All, by name; ours is called `ours`."""
    every = PUBLISHED_K[resolution]
    known = (
        Method("ours", lambda lab, camera, _threads: OurCamera(lab, camera), fuses=True),
        Method("gulliview2023", lambda lab, camera, threads: PublishedCamera(GulliView2023(lab, camera, threads))),
        Method(
            "gulliview2024", lambda lab, camera, threads: PublishedCamera(GulliView2024(lab, camera, threads, every))
        ),
        Method(
            "gulliview2025", lambda lab, camera, threads: PublishedCamera(GulliView2025(lab, camera, threads, every))
        ),
    )
    return {method.name: method for method in known}
