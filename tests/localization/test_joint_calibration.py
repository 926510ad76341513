"""All cameras calibrated together: right, honest about what it leaves open, and not to be bent by wrong floor tags."""

from pathlib import Path

import numpy as np
import pytest

from geometry import SE2
from localization.calibration import ExtrinsicsError, FloorSighting, JointCalibration, refine_jointly
from localization.calibration_jacobians import calibration_jacobians
from localization.projection import CameraView, extrinsics_pose, undistort
from localization.tag_pose import extrinsics_covariance
from protocol.lab import Lab, load_lab
from tests.localization.floor_room import sightings, spread_places, surveyed, true_cameras

GULLIVER = load_lab(Path("labs/gulliver.yaml"))
EXACT = surveyed(GULLIVER, 0.0)
HAND_MEASURED = surveyed(GULLIVER, 0.001, 0.0005, 0.5)
SEED = 3


def described(lab: Lab) -> dict[int, SE2]:
    return {tag: SE2(*pose) for tag, pose in lab.floor_tags.poses.items()}


def floor_errors_m(lab: Lab, found: JointCalibration, seed: int, height_m: float = 0.3) -> np.ndarray:
    """How far off points at that height are put, over all cameras."""
    rng = np.random.default_rng(seed)
    errors: list[float] = []
    for name, camera in true_cameras(lab, seed).items():
        points = spread_places(camera, height_m, rng, 20)
        model = lab.camera(name).model()
        view = CameraView(model, extrinsics_pose(found.extrinsics[name]))
        hits = view.hits(undistort(model, camera.project(points)), height_m).points
        errors += list(np.linalg.norm(hits - points[:, :2], axis=1))
    return np.array(errors)


def test_an_exactly_measured_room_comes_back() -> None:
    found = refine_jointly(EXACT, sightings(EXACT, SEED))
    assert floor_errors_m(EXACT, found, SEED).max() < 0.0004
    assert max(found.floor_tag_shift_m.values()) < 0.0003
    assert all(not left for left in found.left_out.values())
    assert found.extrinsics["cam1"].floor_tags == (2, 3, 4, 5)
    assert found.extrinsics["cam1"].reprojection_px == found.reprojection_px["cam1"] < 0.08


def test_neighbours_help_each_other() -> None:
    alone, together = list[float](), list[float]()
    for seed in range(8):
        seen = sightings(HAND_MEASURED, seed)
        joint = refine_jointly(HAND_MEASURED, seen)
        extrinsics = {s.camera: refine_jointly(HAND_MEASURED, [s]).extrinsics[s.camera] for s in seen}
        single = JointCalibration(extrinsics, {}, {}, {}, {})
        together.extend(floor_errors_m(HAND_MEASURED, joint, seed))
        alone.extend(floor_errors_m(HAND_MEASURED, single, seed))
    assert np.sqrt(np.square(together).mean()) < 0.85 * np.sqrt(np.square(alone).mean())
    assert np.median(together) < 0.0008


@pytest.mark.parametrize("joint", [True, False])
def test_the_covariance_is_honest_at_the_height_of_tags(joint: bool) -> None:
    """NEES of the mean over rooms: points of one room share its errors, so each camera of a room counts once; its mean over
    points varies like a chi-square of 2 degrees of freedom at most (variance 4)."""
    rng = np.random.default_rng(0)
    nees: list[float] = []
    rooms = 40
    for seed in range(rooms):
        seen = sightings(HAND_MEASURED, seed)
        if joint:
            extrinsics = refine_jointly(HAND_MEASURED, seen).extrinsics
        else:
            extrinsics = {s.camera: refine_jointly(HAND_MEASURED, [s]).extrinsics[s.camera] for s in seen}
        of_room: list[float] = []
        for name, camera in true_cameras(HAND_MEASURED, seed).items():
            covariance = extrinsics_covariance(extrinsics[name])
            assert covariance is not None
            model = HAND_MEASURED.camera(name).model()
            view = CameraView(model, extrinsics_pose(extrinsics[name]))
            for height_m in (0.25, 0.35):
                points = spread_places(camera, height_m, rng, 6)
                pixels = camera.project(points)
                off = view.hits(undistort(model, pixels), height_m).points - points[:, :2]
                for offset, slope in zip(off, calibration_jacobians(view, pixels, height_m), strict=True):
                    of_room.append(float(offset @ np.linalg.solve(slope @ covariance @ slope.T, offset)))
        nees.append(float(np.mean(of_room)))
    band = 1.96 * 2.0 / np.sqrt(rooms)
    assert abs(np.mean(nees) - 2.0) < band, f"NEES {np.mean(nees):.2f}, 2 expected"


@pytest.mark.parametrize("wrong", [0, 3, 4, 9])
def test_a_tag_entered_ten_centimetres_off_is_found_and_left_out(wrong: int) -> None:
    poses = dict(HAND_MEASURED.floor_tags.poses)
    x, y, yaw = poses[wrong]
    poses[wrong] = (x + 0.06, y - 0.08, yaw)
    entered = HAND_MEASURED.model_copy(
        update={"floor_tags": HAND_MEASURED.floor_tags.model_copy(update={"poses": poses})}
    )
    found = refine_jointly(entered, sightings(HAND_MEASURED, SEED))
    assert {tag for tags in found.left_out.values() for tag in tags} == {wrong}
    assert floor_errors_m(HAND_MEASURED, found, SEED).max() < 0.006
    assert found.floor_tag_shift_m[wrong] == pytest.approx(0.1, abs=0.006)
    assert found.floor_tags[wrong].distance_to(SE2(x, y, yaw)) < 0.006


@pytest.mark.parametrize("swapped", [(2, 5), (0, 1), (3, 4)])
def test_swapped_ids_are_found(swapped: tuple[int, int]) -> None:
    poses = dict(HAND_MEASURED.floor_tags.poses)
    a, b = swapped
    poses[a], poses[b] = poses[b], poses[a]
    entered = HAND_MEASURED.model_copy(
        update={"floor_tags": HAND_MEASURED.floor_tags.model_copy(update={"poses": poses})}
    )
    found = refine_jointly(entered, sightings(HAND_MEASURED, SEED))
    assert {tag for tags in found.left_out.values() for tag in tags} == set(swapped)
    assert floor_errors_m(HAND_MEASURED, found, SEED).max() < 0.006


def test_a_tag_that_one_camera_misreads_is_left_out_there_alone() -> None:
    seen = sightings(HAND_MEASURED, SEED)
    misread = FloorSighting("cam1", 1, 10, {**seen[1].corners, 4: seen[1].corners[4] + (60.0, -45.0)}, 0.01)
    found = refine_jointly(HAND_MEASURED, [seen[0], misread, *seen[2:]])
    assert found.left_out == {"cam0": (), "cam1": (4,), "cam2": (), "cam3": ()}
    assert floor_errors_m(HAND_MEASURED, found, SEED).max() < 0.006


def test_tags_wrong_by_five_millimetres_are_measuring_errors() -> None:
    lab = surveyed(GULLIVER, 0.005 / 3**0.5)
    for seed in range(6):
        rng = np.random.default_rng(seed)
        true = {
            tag: SE2(pose.x + rng.uniform(-0.005, 0.005), pose.y + rng.uniform(-0.005, 0.005), pose.yaw)
            for tag, pose in described(lab).items()
        }
        found = refine_jointly(lab, sightings(lab, seed, true))
        assert all(not left for left in found.left_out.values())
        assert np.median(floor_errors_m(lab, found, seed)) < 0.004


def test_cameras_without_a_common_tag_are_independent() -> None:
    seen = sightings(HAND_MEASURED, SEED)
    left, right = seen[0], seen[3]
    together = refine_jointly(HAND_MEASURED, [left, right])
    alone = refine_jointly(HAND_MEASURED, [right])
    np.testing.assert_allclose(together.extrinsics["cam3"].translation, alone.extrinsics["cam3"].translation)
    assert together.floor_tag_shift_m[4] == 0.0, "what nobody saw stays as described"
    assert together.floor_tags[4] == described(HAND_MEASURED)[4]


def test_two_tags_per_camera_are_enough() -> None:
    seen = sightings(EXACT, SEED)
    few = [
        FloorSighting(s.camera, 1, 10, {tag: s.corners[tag] for tag in tags}, 0.01)
        for s, tags in zip(seen, [(0, 3), (3, 4), (4, 7), (7, 8)], strict=True)
    ]
    found = refine_jointly(EXACT, few)
    assert np.median(floor_errors_m(EXACT, found, SEED)) < 0.002


def test_of_two_sightings_the_newer_counts() -> None:
    old, new = sightings(EXACT, SEED)[0], sightings(EXACT, SEED + 1)[0]
    new = FloorSighting(new.camera, old.stamp_ns + 1, 10, new.corners, 0.01)
    both = refine_jointly(EXACT, [new, old])
    assert both.extrinsics["cam0"] == refine_jointly(EXACT, [new]).extrinsics["cam0"]
    assert both.extrinsics["cam0"].stamp_ns == new.stamp_ns


def test_what_stands_in_the_way_is_said() -> None:
    with pytest.raises(ExtrinsicsError, match="no camera has seen its floor tags yet"):
        refine_jointly(EXACT, [])
    seen = sightings(EXACT, SEED)[2]
    one = FloorSighting("cam2", 1, 10, {6: seen.corners[6], 99: seen.corners[5]}, 0.01)
    with pytest.raises(ExtrinsicsError, match="camera cam2 sees floor tag 6, needs 2"):
        refine_jointly(EXACT, [one])
    text = EXACT.floor_tags.model_copy(update={"size_m": 0.2})
    with pytest.raises(ExtrinsicsError, match="size"):
        refine_jointly(EXACT.model_copy(update={"floor_tags": text}), sightings(EXACT, SEED))
    with pytest.raises(KeyError):
        refine_jointly(EXACT, [FloorSighting("cam9", 1, 10, seen.corners, 0.01)])
