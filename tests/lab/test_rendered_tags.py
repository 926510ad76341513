"""Tags in rendered frames lie where an independent projection puts them, found by AprilTag's own detector."""

import math

import numpy as np
import pytest

from geometry import SE2
from lab.rendering import CameraRenderer
from lab.snapshot import Snapshot, VehicleSnapshot
from lab.truth import true_floor_tags
from protocol.lab import Lab, SimulatedSurvey
from tests.lab.oracle import detected, projected, rms
from tests.lab.rooms import gulliver, standing, tag_corners

CAMERAS = ["cam0", "cam1", "cam2", "cam3"]
EMPTY = standing()


@pytest.fixture(scope="module")
def renderers() -> dict[str, CameraRenderer]:
    """The shipped room's cameras: a frame depends on nothing but its instant and number, so tests may share them."""
    return {camera_id: CameraRenderer(gulliver(), camera_id) for camera_id in CAMERAS}


def vehicle_corners(
    lab: Lab, vehicle_id: str, pose: SE2, camera_id: str
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    tag = lab.vehicle(vehicle_id).tag
    return projected(lab, camera_id, tag_corners(pose @ SE2(*tag.offset), tag.size_m, tag.height_m))


@pytest.mark.parametrize("camera_id", CAMERAS)
def test_floor_tags_are_where_the_description_says(camera_id: str, renderers: dict[str, CameraRenderer]) -> None:
    lab = gulliver()
    index = int(camera_id[-1])
    found = detected(renderers[camera_id].render(EMPTY, 1))
    assert set(found) == {2 * index, 2 * index + 1, 2 * index + 2, 2 * index + 3}
    for tag_id, corners in found.items():
        pose = SE2(*lab.floor_tags.poses[tag_id])
        errors = corners - projected(lab, camera_id, tag_corners(pose, lab.floor_tags.size_m))
        assert rms(errors) < 0.1, f"floor tag {tag_id}"
        assert np.abs(errors.mean(axis=0)).max() < 0.05, f"floor tag {tag_id} is shifted"


@pytest.mark.parametrize("camera_id", CAMERAS)
def test_vehicle_tags_are_at_their_true_height(camera_id: str, renderers: dict[str, CameraRenderer]) -> None:
    lab = gulliver()
    x, y, _ = lab.simulation.mounts[camera_id].position
    poses = {
        "wifibot-14": SE2(x - 0.6, y - 1.5, 0.7),
        "wifibot-15": SE2(x + 0.65, y + 0.4, -2.0),
        "turtlebot-16": SE2(x + 0.5, y + 1.6, 3.0),
        "turtlebot-17": SE2(x - 0.1, y - 0.2, 1.57),
    }
    snapshot = standing(*((name, pose.x, pose.y, pose.yaw) for name, pose in poses.items()))
    found = detected(renderers[camera_id].render(snapshot, 1))
    for name, pose in poses.items():
        tag = lab.vehicle(name).tag
        errors = found[tag.id] - vehicle_corners(lab, name, pose, camera_id)
        assert rms(errors) < 0.1, name
        assert np.abs(errors.mean(axis=0)).max() < 0.05, f"the tag of {name} is shifted"
    on_floor = projected(lab, camera_id, tag_corners(poses["turtlebot-16"] @ SE2(-0.03, 0.0, 0.0), 0.16))
    assert rms(found[16] - on_floor) > 20.0, "parallax is not in the noise"


@pytest.mark.parametrize("tag_yaw", [0.0, math.pi / 2, 2.0])
def test_a_turned_vehicle_tag_is_drawn_turned(tag_yaw: float) -> None:
    lab = gulliver()
    spec = lab.vehicle("wifibot-14")
    tag = spec.tag.model_copy(update={"offset": (0.03, -0.04, tag_yaw)})
    lab = lab.model_copy(update={"vehicles": (spec.model_copy(update={"tag": tag}),)})
    found = detected(CameraRenderer(lab, "cam1").render(standing(("wifibot-14", 3.4, 1.3, 0.3)), 1))
    assert rms(found[14] - vehicle_corners(lab, "wifibot-14", SE2(3.4, 1.3, 0.3), "cam1")) < 0.1


def test_a_moving_tag_is_smeared_around_the_middle_of_the_exposure() -> None:
    lab = gulliver(image={"exposure_s": 0.008, "noise_std": 0.0})
    renderer = CameraRenderer(lab, "cam1")
    pose = SE2(3.4, 1.3, 0.3)
    fast = Snapshot(0, (VehicleSnapshot("wifibot-14", pose.x, pose.y, pose.yaw, 0.8, 0.6),), ())
    sharp = renderer.render(standing(("wifibot-14", pose.x, pose.y, pose.yaw)), 1)
    smeared = renderer.render(fast, 1)
    errors = detected(smeared)[14] - vehicle_corners(lab, "wifibot-14", pose, "cam1")
    assert np.abs(errors.mean(axis=0)).max() < 0.1
    x, y = vehicle_corners(lab, "wifibot-14", pose, "cam1").mean(axis=0).astype(int)
    window = np.s_[y - 25 : y + 25, x - 25 : x + 25]
    steepest = [np.abs(np.diff(frame[window].astype(int), axis=0)).max() for frame in (sharp, smeared)]
    assert steepest[1] < 0.8 * steepest[0]


def test_floor_tags_may_lie_elsewhere_than_described() -> None:
    lab = gulliver(survey=SimulatedSurvey(floor_tag_m=0.004))
    moved = true_floor_tags(lab, 7)
    offsets = np.array([[p.x, p.y] for p in moved.values()]) - [lab.floor_tags.poses[i][:2] for i in moved]
    assert 0.001 < offsets.std() < 0.008
    assert true_floor_tags(lab, 7) == moved
    found = detected(CameraRenderer(lab, "cam2", 7).render(EMPTY, 1))
    for tag_id in (4, 5, 6, 7):
        assert rms(found[tag_id] - projected(lab, "cam2", tag_corners(moved[tag_id], 0.16))) < 0.1
    assert rms(found[4] - projected(lab, "cam2", tag_corners(SE2(*lab.floor_tags.poses[4]), 0.16))) > 0.3
