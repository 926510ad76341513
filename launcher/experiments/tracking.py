"""Localization against the truth: four vehicles on the infinity course and a rectangle, Full HD rendered frames."""

import argparse
import statistics
import sys

import numpy as np

from geometry import SE2
from lab.rendering import CameraRenderer
from lab.rendering.optics import Optics
from lab.truth import true_camera_model, true_vehicle
from lab.world import World
from launcher.errors import LauncherError, UsageError
from launcher.experiments.courses import CourseFollower, infinity, rectangle
from launcher.experiments.tracking_score import TrackingScore
from launcher.lab_file import add_lab_file_argument, read_lab
from launcher.output import Result
from localization.pipeline import CameraPipeline, PipelineOptions
from localization.tracking import Tracker
from protocol.clock import SystemClock
from protocol.frames import Frame
from protocol.lab import Lab, VehicleSpec
from protocol.messages import GroundTruth, TrackedPose

SPEED_MPS = 0.5
SPEED_SHARE = 0.95
"""Of a vehicle's own limit, so that it can catch up when its course asks for it."""
SETTLE_S = 2.0
"""Time to calibrate from the floor tags, the vehicles standing; not judged."""
QUIET_ZONE = 10 / 8
"""A tag36h11 with its white border is ten cells wide, `size_m` measures the eight inside."""


class WorldClock(SystemClock):
    """Stamps are the simulated world's; durations are measured for real."""

    def __init__(self, world: World) -> None:
        self._world = world

    def now_ns(self) -> int:
        return self._world.stamp_ns


class Camera:
    """One simulated camera with its pipeline, and the optics that say which tags it must see."""

    def __init__(
        self, lab: Lab, world: World, index: int, seed: int | None, options: PipelineOptions | None = None
    ) -> None:
        self.spec = lab.cameras[index]
        self._lab = lab
        self._renderer = CameraRenderer(lab, self.spec.id, seed)
        self._seed = lab.simulation.seed if seed is None else seed
        self._optics = Optics(true_camera_model(lab, self.spec, self._seed), lab.simulation.mounts[self.spec.id])
        self.pipeline = CameraPipeline(lab, self.spec.id, clock=WorldClock(world), options=options)
        self._world = world
        self._frames = 0
        self._start_ns = world.stamp_ns + round(index / len(lab.cameras) / self.spec.rate_hz * 1e9)

    def next_frame(self) -> Frame | None:
        """The frame of this instant when one is due: cameras take turns within a period, as free-running ones do."""
        due_ns = self._start_ns + round(self._frames / self.spec.rate_hz * 1e9)
        if self._world.stamp_ns < due_ns:
            return None
        self._frames += 1
        pixels = self._renderer.render(self._world.snapshot(), self._frames)
        return Frame(self._frames, self._world.stamp_ns, pixels)

    def sees(self, vehicle: VehicleSpec, truth: GroundTruth) -> bool:
        """Whether the vehicle's whole tag, white border included, lies inside the image."""
        true = truth.vehicles[vehicle.id]
        tag = SE2(true.x, true.y, true.yaw) @ vehicle.tag.pose_on_vehicle()
        half = vehicle.tag.size_m * QUIET_ZONE / 2
        corners = tag.apply([[-half, -half], [half, -half], [half, half], [-half, half]])
        height_m = true_vehicle(self._lab, vehicle, self._seed).tag.height_m
        pixels = self._optics.project(np.column_stack([corners, np.full(4, height_m)]))
        limits = np.array([self.spec.width - 1, self.spec.height - 1])
        return pixels is not None and bool(((pixels >= 0) & (pixels <= limits)).all())


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_file_argument(parser)
    parser.add_argument("--seconds", type=float, default=30.0, help="how long to drive (default: 30)")
    parser.add_argument("--seed", type=int, help="of noise, slip and texture (default: the lab file's)")


def run(arguments: argparse.Namespace) -> Result:
    path, lab = read_lab(arguments.lab)
    if not 0 < arguments.seconds <= 3600:
        raise UsageError(f"--seconds must be more than 0 and at most 3600, not {arguments.seconds:g}")
    if not lab.cameras or any(camera.id not in lab.simulation.mounts for camera in lab.cameras):
        raise UsageError(f"{path} has no simulated cameras to track with")
    if not any(vehicle.driver == "sim" for vehicle in lab.vehicles):
        raise UsageError(f"{path} has no simulated vehicles to track")
    score, durations_ms = measure(lab, arguments.seconds, arguments.seed)
    if not score.has_figures:
        raise LauncherError(
            f"nothing was tracked in {arguments.seconds:g} s: {score.visible_tags} times a vehicle's tag was wholly in a "
            f"camera's view and {len(score.position_errors_m)} poses came out; drive for longer, or look at the cameras' "
            f"places and the floor tags in {path}"
        )
    figures = {
        **score.figures(),
        "frame_median_ms": statistics.median(durations_ms),
        "frame_p99_ms": float(np.percentile(durations_ms, 99)),
    }
    settings = {
        "lab": lab.name,
        "seconds": arguments.seconds,
        "seed": lab.simulation.seed if arguments.seed is None else arguments.seed,
        "cameras": len(lab.cameras),
        "width": lab.cameras[0].width,
        "height": lab.cameras[0].height,
        "rate_hz": lab.cameras[0].rate_hz,
        "speed_mps": SPEED_MPS,
    }
    return Result("tracking", figures, settings=settings)


def measure(
    lab: Lab, seconds: float, seed: int | None = None, options: PipelineOptions | None = None
) -> tuple[TrackingScore, list[float]]:
    """Drives for `seconds`; the score, and how long each frame took from pixels to detections (ms, without rendering).

    How soon a newcomer is found depends on the machine, unless `options` fix how often whole frames are searched.
    """
    world = World(lab, seed)
    followers = start_vehicles(lab, world)
    vehicles = [vehicle for vehicle in lab.vehicles if vehicle.id in followers]
    cameras = [Camera(lab, world, index, seed, options) for index in range(len(lab.cameras))]
    tracker, poses = Tracker(lab), dict[str, TrackedPose]()
    score, durations_ms = TrackingScore(), list[float]()
    steps = round((SETTLE_S + seconds) / world.step_s)
    for step in range(steps):
        driving = step * world.step_s >= SETTLE_S
        for camera in cameras:
            frame = camera.next_frame()
            if frame is None:
                continue
            detections = camera.pipeline.process(frame, poses)
            updated = tracker.update(detections)
            poses.update({pose.vehicle: pose for pose in updated})
            if not driving:
                continue
            truth = world.truth()
            durations_ms.append(sum(ms for stage, ms in detections.timings_ms.items() if stage != "wait"))
            score.tags(
                visible=[v.tag.id for v in vehicles if camera.sees(v, truth)],
                found=[detection.tag_id for detection in detections.detections],
            )
            for pose in updated:
                if pose.stamp_ns == frame.stamp_ns:
                    score.pose(pose, truth.vehicles[pose.vehicle])
        if driving:
            now = world.truth()
            for vehicle_id, follower in followers.items():
                world.set_drive(vehicle_id, *follower.twist(now.vehicles[vehicle_id]))
        world.step()
        if step % round(1 / world.step_s) == 0:
            _show_progress(step / steps)
    _show_progress(1.0)
    return score, durations_ms


def start_vehicles(lab: Lab, world: World) -> dict[str, CourseFollower]:
    """Puts the simulated vehicles on two courses that fill the lab's bounds, alternating, as far apart as the courses let
    them: on the infinity a quarter of a lap, so that they do not meet where it crosses itself."""
    min_x, min_y, max_x, max_y = lab.bounds()
    center = ((min_x + max_x) / 2, (min_y + max_y) / 2)
    courses = (
        infinity(center, 0.36 * (max_x - min_x), 0.24 * (max_y - min_y)),
        rectangle(min_x + 0.75, min_y + 0.65, max_x - 0.75, max_y - 0.65, 0.6),
    )
    followers: dict[str, CourseFollower] = {}
    for index, vehicle_id in enumerate(world.vehicle_ids):
        course, place = courses[index % 2], index // 2
        apart = 0.25 if course.name == "infinity" else 0.5
        start_m = (0.125 + place * apart) * course.length_m
        speed = min(SPEED_MPS, SPEED_SHARE * lab.vehicle(vehicle_id).limits.speed_mps)
        world.place(vehicle_id, SE2(*course.at(start_m)))
        followers[vehicle_id] = CourseFollower(course, start_m, speed)
    return followers


def _show_progress(share: float) -> None:
    if sys.stderr.isatty():
        print(f"\rtracking {share:4.0%}", end="\n" if share >= 1.0 else "", file=sys.stderr, flush=True)
