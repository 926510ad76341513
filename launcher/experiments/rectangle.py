"""The reports' rectangle of 6.0 m x 2.5 m: how long its sides are by the poses, beside the published errors."""

import argparse
import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import cv2
import numpy as np

from geometry import SE2
from lab.rendering import CameraRenderer
from lab.world import World
from launcher.errors import LauncherError, UsageError
from launcher.experiments.cameras import FrameClock
from launcher.experiments.corner_course import SEGMENTS_M, CornerDriver, corners
from launcher.lab_file import add_lab_file_argument, read_lab
from launcher.output import Result, progress
from localization.calibration import ExtrinsicsError, PerTagAverage, refine_jointly
from localization.pipeline import CameraPipeline
from localization.tracking import Tracker
from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import FrameDetections, TrackedPose

RUNS = 3
ROOMS = 8
HAND_ERROR_M = 0.005
"""Floor tags measured by hand are wrong by up to this in x and y, evenly."""
_START = SE2(1.0, 0.9, 0.0)
_START_SPREAD_M = 0.05
_CALIBRATION_FRAMES = 14
_MOST_STEPS = 20_000
_SETTLED_S = 0.4
"""Poses count from this long after the vehicle stands."""
_SIGHT_M = 1.9
"""Cameras whose foot is further than this along the room do not see the vehicle and are not rendered."""
_PUBLISHED = {
    "segment_1_error_mean_mm": 15.0,
    "segment_2_error_mean_mm": 61.0,
    "segment_3_error_mean_mm": 6.0,
    "segment_4_error_mean_mm": 20.0,
    "segment_error_mean_mm": 25.5,
    "segment_error_max_mm": 64.0,
}
"""GulliView 2025, table 2: means over three runs by segment, their mean, and the worst single one."""
_PUBLISHED_OTHERS = {
    "gulliview_2023_segments_mm": [524, 438, 470, 398],
    "robot_slam_segments_2023_mm": [212, 89, 348, 113],
    "robot_slam_segments_2025_mm": [250, 92, 397, 116],
}
"""The same course by the system of 2023 and by the robot's own SLAM (tables 1 and 2)."""


METHODS = ("joint", "single", "per_tag")
"""Cameras refined together, as deployed; each camera calibrated by itself; the reports' per-tag average."""


class Tracked:
    """Pipelines with a tracker, as deployed."""

    def __init__(self, lab: Lab, vehicle: str, pipelines: Mapping[str, CameraPipeline]) -> None:
        self._vehicle, self._pipelines = vehicle, pipelines
        self._tracker = Tracker(lab)
        self._poses: dict[str, TrackedPose] = {}

    def look(self, camera: str, frame: Frame) -> tuple[FrameDetections, tuple[float, float] | None]:
        """What the camera found, and the vehicle's place (m) when the frame showed it."""
        detections = self._pipelines[camera].process(frame, self._poses)
        updated = {pose.vehicle: pose for pose in self._tracker.update(detections)}
        self._poses.update(updated)
        pose = updated.get(self._vehicle)
        return detections, None if pose is None else (pose.x, pose.y)


class Room:
    """A room with its cameras: `true` is what is rendered, `described` what the estimators are told. Cameras calibrate
    themselves from their first frames, and are then refined together; ExtrinsicsError when that fails."""

    def __init__(self, true: Lab, described: Lab, seed: int) -> None:
        self.described, self.seed = described, seed
        self.vehicle = described.vehicles[0].id
        self._true = true
        self._frames = 0
        self._clock = FrameClock()
        self._renderers = {camera.id: CameraRenderer(true, camera.id, seed) for camera in true.cameras}
        self.joint, self.single = self._pipelines(), self._pipelines()
        self._calibrate()

    def _pipelines(self) -> dict[str, CameraPipeline]:
        return {c.id: CameraPipeline(self.described, c.id, clock=self._clock) for c in self.described.cameras}

    def _calibrate(self) -> None:
        world = self.world(0)
        world.place(self.vehicle, _START)
        for camera in self._renderers:
            for _ in range(_CALIBRATION_FRAMES):
                frame = self._frame(camera, world)
                self.joint[camera].process(frame)
                self.single[camera].process(frame)
                world.step()
        sightings = [pipeline.sighting for pipeline in self.joint.values() if pipeline.sighting is not None]
        result = refine_jointly(self.described, sightings)
        for camera, extrinsics in result.extrinsics.items():
            self.joint[camera].adopt(extrinsics, result.floor_tags)
        places = {tag: SE2(*pose) for tag, pose in self.described.floor_tags.poses.items()}
        self._per_tag = {
            sighting.camera: PerTagAverage.calibrated(
                self.described.camera(sighting.camera).model(), sighting, places, self.described.floor_tags.size_m
            )
            for sighting in sightings
        }

    def world(self, run: int) -> World:
        """The world of a run: another way of slipping, the same room."""
        return World(self._true, 1000 * self.seed + run)

    def _frame(self, camera: str, world: World) -> Frame:
        self._frames += 1
        self._clock.stamp_ns = world.stamp_ns
        return Frame(self._frames, world.stamp_ns, self._renderers[camera].render(world.snapshot(), self._frames))

    def drive(self, run: int) -> dict[str, list[float]]:
        """Errors of the four segments (m) by method. LauncherError when the vehicle was not seen at a corner."""
        world = self.world(run)
        rng = np.random.default_rng([self.seed, run])
        dx, dy = (float(v) for v in rng.uniform(-_START_SPREAD_M, _START_SPREAD_M, 2))
        start = SE2(_START.x + dx, _START.y + dy, 0.0)
        world.place(self.vehicle, start)
        driver = CornerDriver(world, self.vehicle, corners(start))
        ways = {"joint": Tracked(self.described, self.vehicle, self.joint)}
        ways["single"] = Tracked(self.described, self.vehicle, self.single)
        halts: dict[str, dict[int, list[tuple[float, float]]]] = {method: {} for method in (*METHODS, "truth")}
        period = round(1.0 / (self.described.cameras[0].rate_hz * world.step_s))
        steps = 0
        while not driver.is_done:
            if steps % period == 0:
                truth = world.truth().vehicles[self.vehicle]
                settled = driver.halt if driver.halted_s > _SETTLED_S else None
                for camera in self._near(truth.x):
                    seen = self._look(camera, world, ways)
                    if settled is not None:
                        seen["truth"] = (truth.x, truth.y)
                        for method, place in seen.items():
                            halts[method].setdefault(settled, []).append(place)
            driver.steer()
            world.step()
            steps += 1
            if steps > _MOST_STEPS:
                raise LauncherError(f"the vehicle did not come around the rectangle in {_MOST_STEPS} steps")
        true_m = _segments(halts.pop("truth"), "truth")
        return {
            method: [abs(a - b) for a, b in zip(_segments(places, method), true_m, strict=True)]
            for method, places in halts.items()
        }

    def _near(self, x: float) -> list[str]:
        mounts = self._true.simulation.mounts
        return [camera for camera in self._renderers if abs(mounts[camera].position[0] - x) < _SIGHT_M]

    def _look(self, camera: str, world: World, ways: Mapping[str, Tracked]) -> dict[str, tuple[float, float]]:
        """The vehicle's place by method, from one frame of one camera that all of them get."""
        frame = self._frame(camera, world)
        found: dict[str, tuple[float, float]] = {}
        for method, way in ways.items():
            detections, place = way.look(camera, frame)
            if place is not None:
                found[method] = place
            if method == "joint":
                found.update(self._by_tags(detections))
        return found

    def _by_tags(self, seen: FrameDetections) -> dict[str, tuple[float, float]]:
        tag = self.described.vehicle(self.vehicle).tag
        for detection in seen.detections:
            if detection.tag_id == tag.id:
                pose = self._per_tag[seen.camera].pose(np.array(detection.corners_px), tag.size_m)
                at = pose @ tag.pose_on_vehicle().inverse()
                return {"per_tag": (at.x, at.y)}
        return {}


def _segments(halts: Mapping[int, Sequence[tuple[float, float]]], method: str) -> list[float]:
    """The sides' lengths (m) between the mean places of consecutive halts."""
    missing = [corner for corner in range(len(SEGMENTS_M) + 1) if not halts.get(corner)]
    if missing:
        raise LauncherError(f"{method}: the vehicle was not seen at corner {missing[0]}")
    places = [np.mean(halts[corner], axis=0) for corner in range(len(SEGMENTS_M) + 1)]
    return [float(np.hypot(*(b - a))) for a, b in pairwise(places)]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_file_argument(parser)
    parser.add_argument("--runs", type=int, default=RUNS, help=f"rounds in the room as described (default: {RUNS})")
    parser.add_argument(
        "--rooms", type=int, default=ROOMS, help=f"rooms with hand-measured floor tags, a round each (default: {ROOMS})"
    )
    parser.add_argument("--seed", type=int, help="of noise, slip and errors of measuring (default: the lab file's)")


def run(arguments: argparse.Namespace) -> Result:
    path, lab = read_lab(arguments.lab)
    if not (1 <= arguments.runs <= 100 and 1 <= arguments.rooms <= 100):
        raise UsageError("--runs and --rooms must be from 1 to 100")
    if not lab.cameras or any(camera.id not in lab.simulation.mounts for camera in lab.cameras):
        raise UsageError(f"{path} has no simulated cameras to measure with")
    simulated = [vehicle for vehicle in lab.vehicles if vehicle.driver == "sim"]
    if not simulated:
        raise UsageError(f"{path} has no simulated vehicle to drive")
    cv2.setNumThreads(1)
    lab = lab.model_copy(update={"vehicles": (simulated[0],)})
    seed = lab.simulation.seed if arguments.seed is None else arguments.seed
    try:
        as_described = _as_described(lab, seed, arguments.runs)
        by_hand = _by_hand(lab, seed, arguments.rooms)
    except ExtrinsicsError as error:
        raise LauncherError(f"the cameras of {path} cannot be calibrated: {error}") from error
    settings = {"lab": lab.name, "seed": seed, "runs": arguments.runs, "rooms": arguments.rooms}
    settings |= {"hand_error_mm": HAND_ERROR_M * 1e3, "segments_m": list(SEGMENTS_M), **_PUBLISHED_OTHERS}
    return Result("rectangle", figures(as_described, by_hand), published=_PUBLISHED, settings=settings)


def figures(
    as_described: Sequence[Mapping[str, Sequence[float]]], by_hand: Sequence[Mapping[str, Sequence[float]]]
) -> dict[str, float]:
    """Flat figures (mm) from the errors of the segments (m) by method: rounds in the room as described, and rounds in rooms
    whose floor tags were measured by hand."""
    errors_mm = np.array([each["joint"] for each in as_described]) * 1e3
    found = {
        "segment_error_mean_mm": float(errors_mm.mean()),
        "segment_error_max_mm": float(errors_mm.max()),
    }
    for k, column in enumerate(errors_mm.T, start=1):
        found[f"segment_{k}_error_mean_mm"] = float(column.mean())
    for k, row in enumerate(errors_mm, start=1):
        for segment, error_mm in enumerate(row, start=1):
            found[f"run_{k}_segment_{segment}_error_mm"] = float(error_mm)
    as_reports = np.array([each["per_tag"] for each in as_described]) * 1e3
    found["described_segment_error_per_tag_mean_mm"] = float(as_reports.mean())
    for method in METHODS:
        errors_mm = np.array([each[method] for each in by_hand]) * 1e3
        found[f"segment_error_{method}_mean_mm"] = float(errors_mm.mean())
        found[f"segment_error_{method}_max_mm"] = float(errors_mm.max())
    return found


def _as_described(lab: Lab, seed: int, runs: int) -> list[dict[str, list[float]]]:
    progress("the room as described: calibrating")
    room = Room(lab, lab, seed)
    found: list[dict[str, list[float]]] = []
    for number in range(1, runs + 1):
        progress(f"run {number} of {runs}")
        found.append(room.drive(number))
    return found


def _by_hand(lab: Lab, seed: int, rooms: int) -> list[dict[str, list[float]]]:
    found: list[dict[str, list[float]]] = []
    for number in range(1, rooms + 1):
        progress(f"floor tags measured by hand: room {number} of {rooms}")
        true, described = measured_by_hand(lab, seed + number)
        found.append(Room(true, described, seed + number).drive(1))
    return found


def measured_by_hand(lab: Lab, seed: int) -> tuple[Lab, Lab]:
    """The room as it is, with floor tags where the lab file has them, and as somebody described it who measured each floor tag
    wrongly by up to HAND_ERROR_M in x and y, and knows it."""
    rng = np.random.default_rng([seed, 2025])
    survey = lab.simulation.survey.model_copy(update={"floor_tag_m": 0.0})
    true = lab.model_copy(update={"simulation": lab.simulation.model_copy(update={"survey": survey})})
    poses = {
        tag: (
            x + float(rng.uniform(-HAND_ERROR_M, HAND_ERROR_M)),
            y + float(rng.uniform(-HAND_ERROR_M, HAND_ERROR_M)),
            yaw,
        )
        for tag, (x, y, yaw) in sorted(lab.floor_tags.poses.items())
    }
    described = true.model_copy(
        update={
            "floor_tags": lab.floor_tags.model_copy(update={"poses": poses}),
            "accuracy": lab.accuracy.model_copy(update={"floor_tag_m": HAND_ERROR_M / math.sqrt(3.0)}),
        }
    )
    return true, described
