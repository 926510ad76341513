"""How many frames per second of every camera a machine works off: one process per camera and one for the tracker, all at once.

Each camera's process draws its frames beforehand and keeps them in memory; then all begin together and go through them as
fast as they can. What stands between the processes in deployment (messages on the bus) and in front of them (decoding) is
not part of it.
"""

import multiprocessing
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing.synchronize import Barrier

import cv2
import numpy as np

from geometry import SE2
from lab.rendering import CameraRenderer
from lab.snapshot import Snapshot
from launcher.experiments.cameras import FrameClock
from launcher.experiments.crowd_drive import CrowdDrive, Look
from localization.pipeline import CameraPipeline
from localization.tracking import Tracker
from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import CameraExtrinsics, FrameDetections

_READY_S = 300.0


@dataclass(frozen=True, slots=True)
class CrowdRate:
    """`camera_rate_hz`: frames per second of each camera, from the common beginning until the last process was done. Times
    are of one frame: pixels to detections, and detections to tracks."""

    camera_rate_hz: float
    frame_median_ms: float
    frame_p99_ms: float
    track_median_ms: float


@dataclass(frozen=True, slots=True)
class _Times:
    """When a process began and ended its work (monotonic s, the same clock for all), and how long each frame took (ms)."""

    began_s: float
    ended_s: float
    frames_ms: list[float]


def measure_rate(drive: CrowdDrive, frames: int) -> CrowdRate:
    """From the first `frames` looks of every camera."""
    room = drive.room
    by_camera = {
        camera.id: [look for look in drive.looks if look.camera == camera.id][:frames] for camera in room.cameras
    }
    count = min(map(len, by_camera.values()))
    if count == 0:
        raise ValueError("a camera has no frame to take the time of: drive for longer")
    context = multiprocessing.get_context("spawn")
    barrier = context.Barrier(len(by_camera) + 1)
    with ProcessPoolExecutor(len(by_camera) + 1, context, initializer=_begin_worker, initargs=(barrier,)) as pool:
        cameras = [
            pool.submit(
                _time_camera,
                room.lab,
                room.seed,
                camera,
                room.calibration.extrinsics[camera],
                room.calibration.floor_tags,
                looks[:count],
            )
            for camera, looks in by_camera.items()
        ]
        together = sorted(
            (look for looks in by_camera.values() for look in looks[:count]), key=lambda look: look.stamp_ns
        )
        tracker = pool.submit(_time_tracker, room.lab, [look.detections for look in together])
        times = [future.result() for future in cameras]
        tracked = tracker.result()
    everybody = [*times, tracked]
    span_s = max(each.ended_s for each in everybody) - min(each.began_s for each in everybody)
    frames_ms = [ms for each in times for ms in each.frames_ms]
    return CrowdRate(
        camera_rate_hz=count / span_s,
        frame_median_ms=float(np.median(frames_ms)),
        frame_p99_ms=float(np.percentile(frames_ms, 99)),
        track_median_ms=float(np.median(tracked.frames_ms)),
    )


_barriers: list[Barrier] = []
"""The one that a worker process was given when it was started: barriers do not travel with the work."""


def _begin_worker(barrier: Barrier) -> None:
    cv2.setNumThreads(1)
    _barriers.append(barrier)


def _time_camera(
    lab: Lab,
    seed: int,
    camera_id: str,
    extrinsics: CameraExtrinsics,
    floor_tags: Mapping[int, SE2],
    looks: Sequence[Look],
) -> _Times:
    clock = FrameClock()
    renderer = CameraRenderer(lab, camera_id, seed)
    pipeline = CameraPipeline(lab, camera_id, clock=clock)
    # A camera that has just begun looks at its floor tags first: that is not what is timed.
    warm_up = 2 * pipeline.options.calibration_frames
    for number in range(-warm_up, 0):
        clock.stamp_ns = looks[0].stamp_ns + round(number / pipeline.spec.rate_hz * 1e9)
        empty = renderer.render(Snapshot(clock.stamp_ns, (), ()), warm_up + number)
        pipeline.process(Frame(warm_up + number, clock.stamp_ns, empty), {})
    pipeline.adopt(extrinsics, floor_tags)
    frames = [
        Frame(number, look.stamp_ns, renderer.render(Snapshot(look.stamp_ns, look.vehicles, ()), number))
        for number, look in enumerate(looks, start=warm_up)
    ]
    _barriers[0].wait(_READY_S)
    began_s, frames_ms = clock.monotonic_s(), list[float]()
    for frame, look in zip(frames, looks, strict=True):
        clock.stamp_ns = frame.stamp_ns
        start_s = clock.monotonic_s()
        pipeline.process(frame, look.predicted)
        frames_ms.append((clock.monotonic_s() - start_s) * 1e3)
    return _Times(began_s, clock.monotonic_s(), frames_ms)


def _time_tracker(lab: Lab, detections: Sequence[FrameDetections]) -> _Times:
    clock, tracker = FrameClock(), Tracker(lab)
    _barriers[0].wait(_READY_S)
    began_s, frames_ms = clock.monotonic_s(), list[float]()
    for frame in detections:
        start_s = clock.monotonic_s()
        tracker.update(frame)
        frames_ms.append((clock.monotonic_s() - start_s) * 1e3)
    return _Times(began_s, clock.monotonic_s(), frames_ms)
