"""Sustained rate: one process per camera, fed as fast as it consumes, and one that fuses, as deployed, on this machine's cores.

Pipes stand in for Redis. The film's time must go on at the same pace for all cameras, else tracks of one are no help to
another: nobody may be more than LEAD frames ahead of the slowest, which the fusing process tells with the newest poses.
"""

import multiprocessing
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path

import cv2

from protocol.codec import decode, encode
from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import TrackedPose
from tests.bench.follow import BASELINE_WARM_UP_FRAMES, POSES_EVERY, START_NS, WARM_UP_FRAMES
from tests.bench.methods import Fusion, methods
from tests.bench.scene import decoded, read_recording

LEAD = 3
_STARTUP_S = 300.0
_END_S = 10.0


@dataclass(frozen=True, slots=True)
class Sustained:
    """Frames per second of all cameras together; and, where there is a tracker, for what share of the tags that were wholly
    visible in those frames it gave a pose."""

    fps: float
    pose_share: float | None


class SustainedError(Exception):
    """A camera's process ended before it was told to."""


def sustained(
    lab: Lab, files: Sequence[Path], resolution: str, name: str, *, with_decode: bool, seconds: float
) -> Sustained:
    """Measures from the warm-up's end on, for about `seconds`. SustainedError."""
    context = multiprocessing.get_context("spawn")
    pipes = [context.Pipe() for _ in files]
    workers = [
        context.Process(target=_camera, args=(theirs, lab, file, resolution, name, with_decode), daemon=True)
        for (_, theirs), file in zip(pipes, files, strict=True)
    ]
    for worker in workers:
        worker.start()
    for _, theirs in pipes:
        theirs.close()
    ours = [mine for mine, _ in pipes]
    try:
        fuses = methods(resolution)[name].fuses
        visible = [_visible(lab, file) for file in files] if fuses else None
        return _conduct(lab, ours, visible, seconds)
    except (EOFError, OSError) as error:
        raise SustainedError(f"a camera process of {name} ended early ({type(error).__name__})") from error
    finally:
        for connection in ours:
            connection.close()  # which ends the workers
        for worker in workers:
            worker.join(_END_S)
            if worker.is_alive():
                worker.terminate()


def _visible(lab: Lab, file: Path) -> list[frozenset[str]]:
    """The vehicles whose whole tag each frame of a film shows."""
    names = {vehicle.tag.id: vehicle.id for vehicle in lab.vehicles}
    return [frozenset(names[tag] for tag in frame.truth) for frame in read_recording(file).frames]


def _conduct(
    lab: Lab, cameras: Sequence[Connection], visible: list[list[frozenset[str]]] | None, seconds: float
) -> Sustained:
    """Takes the messages in, fuses them where somebody does, and lets the cameras go on. `visible`: by camera, the vehicles in
    each frame of the film."""
    for camera in cameras:
        if not camera.poll(_STARTUP_S):
            raise EOFError
        camera.recv_bytes()  # it has its frames in memory
    fusion = None if visible is None else Fusion(lab)
    done = dict.fromkeys(cameras, 0)
    before = dict(done)
    warm_up = BASELINE_WARM_UP_FRAMES if fusion is None else WARM_UP_FRAMES
    told = expected = posed = 0
    films = None if visible is None else dict(zip(cameras, visible, strict=True))
    begun_s: float | None = None
    for camera in cameras:
        camera.send((LEAD, []))
    while begun_s is None or time.perf_counter() - begun_s < seconds:
        for camera in wait(cameras, timeout=_STARTUP_S):
            assert isinstance(camera, Connection)
            message = camera.recv_bytes()
            if fusion is not None and films is not None:
                fusion.fuse(message)
                shown = films[camera][done[camera] % len(films[camera])]
                expected, posed = expected + len(shown), posed + len(shown.intersection(fusion.changed))
            done[camera] += 1
        slowest = min(done.values())
        if slowest > told:
            told = slowest
            news = [encode(pose) for pose in fusion.poses.values()] if fusion and told % POSES_EVERY == 0 else []
            for camera in cameras:
                camera.send((told + LEAD, news))
        if begun_s is None and slowest >= warm_up:
            begun_s, before, expected, posed = time.perf_counter(), dict(done), 0, 0
    fps = (sum(done.values()) - sum(before.values())) / (time.perf_counter() - begun_s)
    return Sustained(fps, posed / expected if expected else None)


def _camera(
    connection: Connection, lab: Lab, file: Path, resolution: str, name: str, with_decode: bool
) -> None:  # pragma: no cover  # runs in a process of its own
    """A camera's process: frame n when n is allowed, until the pipe is closed."""
    cv2.setNumThreads(1)
    recording = read_recording(file)
    camera = methods(resolution)[name].camera(lab, recording.camera, 1)
    pictures = None if with_decode else [decoded(frame.jpeg) for frame in recording.frames]
    camera.prepare(Frame(0, START_NS, decoded(recording.floor)))
    told: Mapping[str, TrackedPose] = {}
    number, allowed = 0, 0
    try:
        connection.send_bytes(b"ready")
        while True:
            while number >= allowed or connection.poll():
                allowed, poses = connection.recv()
                if poses:
                    told = {pose.vehicle: pose for pose in (decode(TrackedPose, each) for each in poses)}
            index = number % len(recording.frames)
            pixels = decoded(recording.frames[index].jpeg) if pictures is None else pictures[index].copy()
            frame = Frame(number + 1, recording.stamp_ns(number, START_NS), pixels)
            connection.send_bytes(camera.process(frame, told))
            number += 1
    except (EOFError, OSError):
        return
