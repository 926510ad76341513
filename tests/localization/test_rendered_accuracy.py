"""Against the simulated lab's rendered frames, which share no projection code with the estimator: numeric budgets.

Two of the report room's four cameras, vehicles driving from one view into the other.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from geometry import SE2
from lab.rendering import CameraRenderer
from lab.world import World
from localization.pipeline import CameraPipeline
from localization.projection import extrinsics_pose
from localization.tracking import Tracker
from protocol.frames import Frame
from protocol.lab import Lab, load_lab
from protocol.messages import FrameDetections, TrackedPose

GULLIVER = Path(__file__).resolve().parents[2] / "labs/gulliver.yaml"
CAMERAS = ("cam1", "cam2")
STARTS = {
    "wifibot-14": SE2(3.1, 0.9, 0.05),
    "wifibot-15": SE2(3.4, 3.3, -0.2),
    "turtlebot-16": SE2(4.9, 1.6, 3.0),
    "turtlebot-17": SE2(5.3, 2.7, -2.9),
}
FRAMES = 30


class Drive:
    """Errors of tracks and detections over a short drive."""

    def __init__(self, lab: Lab) -> None:
        self.position_mm: list[float] = []
        self.heading_deg: list[float] = []
        self.jumps_mm: list[float] = []
        self.normalised: list[float] = []
        self.cameras: set[tuple[str, ...]] = set()
        self.visible = self.given = 0
        world = World(lab, seed=3)
        for vehicle, pose in STARTS.items():
            world.place(vehicle, pose)
        renderers = {camera: CameraRenderer(lab, camera) for camera in CAMERAS}
        self.pipelines = {camera: CameraPipeline(lab, camera) for camera in CAMERAS}
        self._lab, self._tracker = lab, Tracker(lab)
        poses: dict[str, TrackedPose] = {}
        last: dict[str, tuple[float, float, tuple[str, ...]]] = {}
        for number in range(FRAMES):
            for index, vehicle in enumerate(lab.vehicles):
                turn = 0.7 * math.sin(0.15 * number + index)
                world.set_drive(vehicle.id, 0.9 * vehicle.limits.speed_mps, turn)
            world.run(0.07)
            snapshot, truth = world.snapshot(), world.truth()
            for camera, pipeline in self.pipelines.items():
                frame = Frame(number, snapshot.stamp_ns, renderers[camera].render(snapshot, number))
                found = pipeline.process(frame, poses)
                for pose in self._tracker.update(found):
                    poses[pose.vehicle] = pose
                    exact = truth.vehicles[pose.vehicle]
                    self._score(pose, SE2(exact.x, exact.y, exact.yaw), last)
                if pipeline.extrinsics is not None:
                    truths = {name: SE2(v.x, v.y, v.yaw) for name, v in truth.vehicles.items()}
                    self._score_detections(pipeline, found, truths)

    def _score(self, pose: TrackedPose, exact: SE2, last: dict[str, tuple[float, float, tuple[str, ...]]]) -> None:
        dx, dy = pose.x - exact.x, pose.y - exact.y
        self.position_mm.append(1e3 * math.hypot(dx, dy))
        self.heading_deg.append(math.degrees(abs(math.remainder(pose.yaw - exact.yaw, math.tau))))
        self.cameras.add(pose.cameras)
        if pose.vehicle in last and last[pose.vehicle][2] != pose.cameras:
            self.jumps_mm.append(1e3 * math.dist((dx, dy), last[pose.vehicle][:2]))
        last[pose.vehicle] = (dx, dy, pose.cameras)

    def _score_detections(self, pipeline: CameraPipeline, found: FrameDetections, truths: dict[str, SE2]) -> None:
        by_id = {detection.tag_id: detection for detection in found.detections}
        for vehicle in self._lab.vehicles:
            exact = truths[vehicle.id] @ vehicle.tag.pose_on_vehicle()
            if not _wholly_visible(pipeline, exact, vehicle.tag.height_m, 0.75 * vehicle.tag.size_m):
                continue
            self.visible += 1
            detection = by_id.get(vehicle.tag.id)
            if detection is None:
                continue
            self.given += 1
            error = np.array(
                [detection.x - exact.x, detection.y - exact.y, math.remainder(detection.yaw - exact.yaw, math.tau)]
            )
            a, b, c, d, e, f = detection.covariance
            self.normalised.append(float(error @ np.linalg.solve([[a, b, c], [b, d, e], [c, e, f]], error)))


def _wholly_visible(pipeline: CameraPipeline, tag: SE2, height_m: float, reach_m: float) -> bool:
    """By the true mount; well inside, so that the answer does not hang on a pixel."""
    spec = pipeline.spec
    assert pipeline.extrinsics is not None
    T_camera_map = extrinsics_pose(pipeline.extrinsics).inverse()
    corners = tag.apply(reach_m * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]))
    x, y, z = T_camera_map.apply(np.column_stack([corners, np.full(4, height_m)])).T
    u = spec.intrinsics.fx * x / z + spec.intrinsics.cx
    v = spec.intrinsics.fy * y / z + spec.intrinsics.cy
    return bool((u > 15).all() and (u < spec.width - 15).all() and (v > 15).all() and (v < spec.height - 15).all())


def surveyed(**errors: float) -> Lab:
    """The report's room, measured with these standard deviations (`simulation.survey`), and saying so; none: without error."""
    data = load_lab(GULLIVER).model_dump()
    data["simulation"]["survey"] = errors
    if not errors:
        data["accuracy"] = {
            "floor_tag_m": 1e-4,
            "floor_tag_rad": 1e-3,
            "tag_height_m": 1e-4,
            "focal": 1e-5,
            "center_px": 0.01,
        }
    return Lab.model_validate(data)


@pytest.fixture(scope="module")
def exact() -> Drive:
    return Drive(surveyed())


@pytest.fixture(scope="module")
def by_hand() -> Drive:
    """Floor tags to a millimetre, the lens to half a pixel and half a per mille, tags' heights to a millimetre."""
    return Drive(surveyed(floor_tag_m=0.001, focal=0.0005, center_px=0.5, tag_height_m=0.001))


def test_in_a_room_measured_exactly_only_the_pixels_limit(exact: Drive) -> None:
    assert len(exact.position_mm) > 60
    assert float(np.median(exact.position_mm)) <= 0.2
    assert float(np.percentile(exact.position_mm, 99)) <= 1.0
    assert float(np.median(exact.heading_deg)) <= 0.05
    assert max(exact.jumps_mm) <= 1.0


def test_in_a_room_measured_by_hand_the_budget_is_kept(by_hand: Drive) -> None:
    assert float(np.median(by_hand.position_mm)) <= 5.0
    assert float(np.percentile(by_hand.position_mm, 99)) <= 20.0
    assert float(np.median(by_hand.heading_deg)) <= 0.5


def test_cameras_agree_at_the_hand_over(by_hand: Drive) -> None:
    assert {("cam1",), ("cam2",), ("cam1", "cam2")} <= by_hand.cameras
    assert max(by_hand.jumps_mm) <= 10.0


def test_every_wholly_visible_tag_gives_its_pose(exact: Drive, by_hand: Drive) -> None:
    for drive in (exact, by_hand):
        assert drive.visible > 60
        assert drive.given / drive.visible >= 0.99


def test_the_covariance_is_of_the_errors_size(exact: Drive, by_hand: Drive) -> None:
    """Three degrees of freedom: three would be exact. One survey is one draw: its errors are shared by all frames."""
    assert float(np.mean(exact.normalised)) <= 3.0
    assert 0.3 <= float(np.mean(by_hand.normalised)) <= 9.0


@pytest.mark.parametrize("camera", CAMERAS)
def test_extrinsics_are_those_of_the_true_mount(exact: Drive, camera: str) -> None:
    mounts = load_lab(GULLIVER).simulation.mounts
    extrinsics = exact.pipelines[camera].extrinsics
    assert extrinsics is not None
    assert len(extrinsics.floor_tags) == 4
    assert extrinsics.reprojection_px < 0.2
    off = extrinsics_pose(extrinsics).translation - np.array(mounts[camera].position)
    assert float(np.abs(off).max()) < 0.001
