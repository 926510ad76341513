"""The reports' per-tag average: exact without noise, and worse than one pose from all corners with it."""

from pathlib import Path

import numpy as np
import pytest

from geometry import SE2
from localization.calibration import FloorSighting, PerTagAverage, refine_jointly
from localization.projection import CameraView, extrinsics_pose, undistort
from localization.tag_pose import PoseNoise, tag_pose
from localization.tags import tag_corners
from protocol.lab import load_lab
from tests.localization.floor_room import sightings, surveyed, true_cameras

LAB = surveyed(load_lab(Path("labs/gulliver.yaml")), 0.0)
CAMERA = true_cameras(LAB, 1)["cam1"]
PLACES = {tag: SE2(*pose) for tag, pose in LAB.floor_tags.poses.items()}
HEIGHT_M = 0.35


def corners_of(pose: SE2) -> np.ndarray:
    return CAMERA.project(np.column_stack([pose.apply(tag_corners(0.16)), np.full(4, HEIGHT_M)]))


def exact_sighting() -> FloorSighting:
    seen = sightings(LAB, 1)[1]
    square = tag_corners(0.16)
    exact = {tag: CAMERA.project(np.column_stack([PLACES[tag].apply(square), np.zeros(4)])) for tag in seen.corners}
    return FloorSighting("cam1", 1, 10, exact, 0.0)


@pytest.mark.parametrize("pose", [SE2(3.0, 2.0, 0.3), SE2(2.4, 0.8, -2.0), SE2(3.6, 3.6, 3.0)])
def test_exact_corners_give_the_exact_place(pose: SE2) -> None:
    method = PerTagAverage.calibrated(CAMERA.model, exact_sighting(), PLACES, 0.16)
    found = method.pose(corners_of(pose), 0.16)
    assert found.distance_to(pose) < 1e-4
    assert abs(found.between(pose).yaw) < 1e-4


def test_all_corners_together_beat_it() -> None:
    rng = np.random.default_rng(4)
    seen = sightings(LAB, 1)
    method = PerTagAverage.calibrated(CAMERA.model, seen[1], PLACES, 0.16)
    extrinsics = refine_jointly(LAB, seen).extrinsics["cam1"]
    view = CameraView(CAMERA.model, extrinsics_pose(extrinsics))
    theirs, ours = list[float](), list[float]()
    for _ in range(30):
        pose = SE2(rng.uniform(2.2, 3.8), rng.uniform(0.8, 3.4), rng.uniform(-3, 3))
        corners = corners_of(pose) + rng.normal(0.0, 0.1, (4, 2))
        theirs.append(method.pose(corners, 0.16).distance_to(pose))
        plane = undistort(CAMERA.model, corners)
        ours.append(tag_pose(view, plane, 0.16, HEIGHT_M, PoseNoise()).pose.distance_to(pose))
    assert np.median(ours) < 0.0005
    assert np.median(theirs) > 5 * np.median(ours)


def test_without_floor_tags_it_says_so() -> None:
    with pytest.raises(ValueError, match="needs a floor tag"):
        PerTagAverage.calibrated(CAMERA.model, FloorSighting("cam1", 1, 1, {}, 0.0), PLACES, 0.16)
