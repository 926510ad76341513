"""Does memory stay flat? Half an hour of simulated frames at the pace of the machine: through rings in shared memory, sources,
pipelines, the eye on the floor and the tracker, as the deployed processes use them, all in this one."""

import argparse
import statistics
import tempfile
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from lab.rendering import CameraRenderer
from lab.world import START_NS, World
from launcher.errors import LauncherError, UsageError
from launcher.lab_file import add_lab_file_argument, read_lab
from launcher.output import Result, progress
from localization.camera_state import CameraStatistics
from localization.floor import FloorObserver
from localization.pipeline import CameraPipeline
from localization.preview import preview_jpeg
from localization.sources import LiveSource
from localization.sources.ring import RingCapture
from localization.tracking import Tracker
from protocol.clock import SystemClock
from protocol.frames import Frame, FrameWriter
from protocol.lab import Lab
from protocol.messages import TrackedPose

FRAMES_PER_CAMERA = 27_000
"""30 minutes at 15 Hz."""
WARM_UP_SHARE = 0.1
PUBLISHED_GROWTH_MB_PER_MINUTE = 215.0
"""The code of 2025 leaked 200 to 230 MB per minute (spec localization-measurements)."""
_PICTURES = 16
"""Rendered once and shown to and fro, so that vehicles never jump."""
_SAMPLES = 200
_STEP_M = 0.03
_POLLS_HZ = 1000.0
"""The ring is asked as often as it can be: frames come as fast as they are taken, not at the camera's rate."""
_WITHIN_S = 10.0


class FilmClock(SystemClock):
    """The wall clock of the film; durations are the machine's."""

    def __init__(self) -> None:
        self.stamp_ns = START_NS

    def now_ns(self) -> int:
        return self.stamp_ns


@dataclass(frozen=True, slots=True)
class Memory:
    """Resident memory (MB) over the run, from after the warm-up, and the simulated minutes between first and last."""

    resident_mb: tuple[float, ...]
    minutes: float
    poses: int

    @property
    def growth_mb(self) -> float:
        """By the medians of the first and the last fifth: one that grows shows, one that breathes does not."""
        fifth = max(1, len(self.resident_mb) // 5)
        return statistics.median(self.resident_mb[-fifth:]) - statistics.median(self.resident_mb[:fifth])

    @property
    def growth_mb_per_minute(self) -> float:
        """Slope of the least-squares line, per simulated minute."""
        at = np.linspace(0.0, self.minutes, len(self.resident_mb))
        return float(np.polyfit(at, self.resident_mb, 1)[0])


class Camera:
    """One camera from its ring to its messages."""

    def __init__(self, lab: Lab, camera_id: str, folder: Path, clock: FilmClock, stack: ExitStack) -> None:
        spec, self._clock = lab.camera(camera_id), clock
        path = folder / f"{camera_id}.frames"
        self._writer = FrameWriter(path, spec.width, spec.height, color=spec.color)
        stack.callback(self._writer.close)
        self._source = LiveSource(spec, lambda: RingCapture(path, _POLLS_HZ, clock), clock)
        stack.callback(self._source.close)
        self._pipeline = CameraPipeline(lab, camera_id, clock=clock)
        self._floor = FloorObserver(lab, camera_id)
        self._statistics = CameraStatistics(0.0)
        self._names = {(v.tag.family, v.tag.id): v.id for v in lab.vehicles}
        self.pictures: tuple[NDArray[np.uint8], ...] = ()

    def show(self, picture: int) -> None:
        """The camera takes that picture."""
        self._writer.write(self.pictures[picture], self._clock.now_ns())

    def see(self, tracker: Tracker, poses: dict[str, TrackedPose]) -> int:
        """All that the camera's process and the tracker do with the newest frame; how many poses came of it."""
        frame = self._source.newest(_WITHIN_S)
        if frame is None:
            raise LauncherError(f"no frame came through the ring: {self._source.state.error}")
        detections = self._pipeline.process(frame, poses)
        updated = tracker.update(detections)
        poses.update({pose.vehicle: pose for pose in updated})
        now_s = frame.stamp_ns * 1e-9
        self._statistics.add(detections, now_s)
        self._statistics.state(self._source.state, self._pipeline, now_s, frame.stamp_ns)
        self._look_at_floor(frame, poses)
        return len(updated)

    def _look_at_floor(self, frame: Frame, poses: dict[str, TrackedPose]) -> None:
        if self._pipeline.extrinsics is not None:
            self._floor.observe(frame, self._pipeline.extrinsics, poses)
            self._floor.picture()
        if frame.number % 4 == 0:
            preview_jpeg(frame.pixels, self._pipeline.tags, self._names)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_file_argument(parser)
    parser.add_argument("--frames", type=int, default=FRAMES_PER_CAMERA, help="per camera (default: half an hour)")


def run(arguments: argparse.Namespace) -> Result:
    path, lab = read_lab(arguments.lab)
    if arguments.frames < 100:
        raise UsageError(f"--frames must be at least 100, not {arguments.frames}")
    if not lab.cameras or any(camera.id not in lab.simulation.mounts for camera in lab.cameras):
        raise UsageError(f"{path} has no simulated cameras to look through")
    memory = measure(lab, arguments.frames)
    figures = {
        "growth_mb": memory.growth_mb,
        "growth_mb_per_minute": memory.growth_mb_per_minute,
        "resident_after_warm_up_mb": memory.resident_mb[0],
        "resident_most_mb": max(memory.resident_mb),
        "minutes": memory.minutes,
        "poses": memory.poses,
    }
    first = lab.cameras[0]
    settings = {
        "lab": lab.name,
        "cameras": len(lab.cameras),
        "frames_per_camera": arguments.frames,
        "width": first.width,
        "height": first.height,
        "rate_hz": first.rate_hz,
    }
    return Result("memory", figures, {"growth_mb_per_minute": PUBLISHED_GROWTH_MB_PER_MINUTE}, settings)


def measure(lab: Lab, frames: int) -> Memory:
    """Runs that many frames per camera through everything, and watches this process."""
    clock, tracker, poses = FilmClock(), Tracker(lab), dict[str, TrackedPose]()
    period_ns = round(1e9 / lab.cameras[0].rate_hz)
    warm, every = round(WARM_UP_SHARE * frames), max(1, round(frames / _SAMPLES))
    resident: list[float] = []
    count = 0
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="lilliput-memory-")))
        cameras = [Camera(lab, camera.id, folder, clock, stack) for camera in lab.cameras]
        _take_pictures(lab, cameras)
        for number in range(frames):
            clock.stamp_ns += period_ns
            to_and_fro = number % (2 * _PICTURES - 2)
            for camera in cameras:
                camera.show(min(to_and_fro, 2 * _PICTURES - 2 - to_and_fro))
            count += sum(camera.see(tracker, poses) for camera in cameras)
            if number >= warm and number % every == 0:
                resident.append(_resident_mb())
            if number % max(1, frames // 20) == 0:
                progress(f"{number / frames:4.0%}  {_resident_mb():.0f} MB")
    return Memory(tuple(resident), (frames - warm) * period_ns / 60e9, count)


def _take_pictures(lab: Lab, cameras: list[Camera]) -> None:
    """Every vehicle moves ahead by a little from picture to picture."""
    world = World(lab)
    starts = world.truth().vehicles
    for camera, spec in zip(cameras, lab.cameras, strict=True):
        renderer = CameraRenderer(lab, spec.id)
        pictures: list[NDArray[np.uint8]] = []
        for number in range(_PICTURES):
            for vehicle, start in starts.items():
                ahead = SE2(start.x, start.y, start.yaw) @ SE2(_STEP_M * number, 0.0, 0.0)
                world.place(vehicle, ahead)
            pictures.append(renderer.render(world.snapshot(), number + 1))
        camera.pictures = tuple(pictures)


def _resident_mb() -> float:
    """This process's memory by the kernel's account, anonymous pages alone: mapped files (the rings) come and go."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("RssAnon:"):
            return int(line.split()[1]) / 1024
    raise LauncherError("/proc/self/status has no RssAnon: memory can be measured on Linux alone")
