"""Extrinsics from floor tags: right, robust, checked; a moved camera notices."""

import math

import cv2
import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from geometry import SE2, SE3
from localization.calibration import ExtrinsicsError, SelfCalibration
from localization.calibration.extrinsics import initial_pose
from localization.detection import TagObservation
from localization.projection import extrinsics_pose
from localization.tags import KnownTags
from protocol.lab import Accuracy
from protocol.messages import CameraExtrinsics
from tests.localization.synthetic import MOUNTS, mount, small_lab

LAB = small_lab()
MODEL = LAB.camera("left").model()
KNOWN = KnownTags.of(LAB)
TRUTH = MOUNTS["left"]
CORNERS = {key[1]: KNOWN.floor_corners(key) for key in KNOWN.floor}
IN_VIEW = (0, 1, 2, 3)


def seen_from(T: SE3, noise_px: float = 0.0, seed: int = 0) -> dict[int, NDArray[np.float64]]:
    """Corners in the image of the floor tags in view."""
    rng = np.random.default_rng(seed)
    T_camera_map = T.inverse()
    seen: dict[int, NDArray[np.float64]] = {}
    for tag in IN_VIEW:
        points = np.column_stack([CORNERS[tag], np.zeros(4)])
        pixels, _ = cv2.projectPoints(
            points, T_camera_map.rotvec(), np.array(T_camera_map.translation), MODEL.matrix(), MODEL.distortion_array()
        )
        seen[tag] = np.asarray(pixels, dtype=np.float64).reshape(4, 2) + rng.normal(0.0, noise_px, (4, 2))
    return seen


def observations(
    T: SE3, seed: int = 0, noise_px: float = 0.05, only: tuple[int, ...] = IN_VIEW
) -> list[TagObservation]:
    seen = seen_from(T, noise_px, seed)
    return [TagObservation("tag36h11", tag, seen[tag], 80.0, 0) for tag in only]


def watch(T: SE3, calibration: SelfCalibration, frames: int, seed: int = 0) -> list[CameraExtrinsics]:
    found = (calibration.observe(observations(T, seed + k), k) for k in range(frames))
    return [extrinsics for extrinsics in found if extrinsics is not None]


def calibrated() -> SelfCalibration:
    calibration = SelfCalibration("left", MODEL, KNOWN)
    assert len(watch(TRUTH, calibration, 10)) == 1
    return calibration


def off(extrinsics: CameraExtrinsics | None, T: SE3) -> tuple[float, float]:
    """Metres and degrees."""
    assert extrinsics is not None
    pose = extrinsics_pose(extrinsics)
    return float(np.linalg.norm(pose.translation - T.translation)), math.degrees(pose.angle_to(T))


@given(
    st.builds(
        mount,
        st.floats(-0.3, 1.8),
        st.floats(-0.3, 1.3),
        st.floats(2.0, 4.0),
        st.floats(-3.1, 3.1),
        st.floats(-0.2, 0.2),
        st.floats(-0.2, 0.2),
    )
)
def test_the_pose_comes_back_from_exact_corners(T: SE3) -> None:
    pose = initial_pose(MODEL, seen_from(T), CORNERS, IN_VIEW)
    assert np.linalg.norm(pose.translation - T.translation) < 1e-4
    assert pose.angle_to(T) < 1e-4


def test_one_tag_is_not_enough() -> None:
    seen = seen_from(TRUTH)
    with pytest.raises(ExtrinsicsError, match="sees floor tag 2, needs 2"):
        initial_pose(MODEL, seen, CORNERS, [2])
    calibration = SelfCalibration("left", MODEL, KNOWN)
    assert calibration.observe(observations(TRUTH, only=(2,)), 1) is None
    assert calibration.problem == "not calibrated: sees 1 floor tags, needs 2"


def test_averaging_beats_a_single_frame() -> None:
    metres, degrees = off(calibrated().extrinsics, TRUTH)
    assert metres < 0.0015
    assert degrees < 0.05


def test_the_noise_of_the_corners_is_measured_on_the_floor_tags() -> None:
    calibration = SelfCalibration("left", MODEL, KNOWN, frames=40)
    for k in range(40):
        calibration.observe(observations(TRUTH, k, noise_px=0.2), k)
    assert calibration.noise.corner_px == pytest.approx(0.2, rel=0.15)


@pytest.mark.parametrize("floor_tag_m", [0.0005, 0.003])
def test_what_a_calibration_leaves_open_follows_from_how_the_room_was_measured(floor_tag_m: float) -> None:
    accuracy = Accuracy(floor_tag_m=floor_tag_m)
    calibration = SelfCalibration("left", MODEL, KNOWN, accuracy=accuracy)
    watch(TRUTH, calibration, 10)
    px_per_m = MODEL.fx / TRUTH.translation[2]
    assert calibration.noise.calibration_px == pytest.approx(floor_tag_m * px_per_m, rel=0.4)


def test_a_wrong_yaw_in_the_lab_file_is_refused_with_a_hint() -> None:
    text = small_lab().model_dump()
    text["floor_tags"]["poses"] = {tag: (x, y, yaw + 1.5708) for tag, (x, y, yaw) in LAB.floor_tags.poses.items()}
    turned = KnownTags.of(type(LAB).model_validate(text))
    calibration = SelfCalibration("left", MODEL, turned)
    assert watch(TRUTH, calibration, 10) == []
    assert calibration.extrinsics is None
    assert calibration.problem is not None
    assert "ids" in calibration.problem


def test_a_stored_result_that_holds_is_used_at_once_and_kept() -> None:
    stored = calibrated().extrinsics
    calibration = SelfCalibration("left", MODEL, KNOWN, stored=stored)
    assert calibration.extrinsics is stored
    assert watch(TRUTH, calibration, 10, seed=50) == []
    assert calibration.extrinsics is stored
    assert not calibration.eager


def test_a_stored_result_of_another_place_is_replaced() -> None:
    stored = calibrated().extrinsics
    moved = mount(0.80, 0.5, 2.2, 0.02, 0.015, -0.01)
    calibration = SelfCalibration("left", MODEL, KNOWN, stored=stored)
    (found,) = watch(moved, calibration, 10)
    assert off(found, moved)[0] < 0.002


def test_a_moved_camera_says_so_and_finds_its_place_again() -> None:
    calibration = calibrated()
    bumped = mount(0.77, 0.5, 2.2, 0.02, 0.015, -0.01)
    assert watch(bumped, calibration, 1) == []
    assert calibration.eager, "it looks again at once"
    watch(bumped, calibration, 2)
    assert calibration.extrinsics is None
    assert calibration.problem is not None
    assert "the camera moved: floor tags are" in calibration.problem
    (found,) = watch(bumped, calibration, 10)
    assert off(found, bumped)[0] < 0.002
    assert calibration.problem is None


@pytest.mark.parametrize(
    "bumped",
    [
        mount(0.77, 0.5, 2.2, 0.02, 0.015, -0.01),
        mount(0.75, 0.5, 2.18, 0.02, 0.015, -0.01),
        mount(0.75, 0.5, 2.2, 0.03, 0.015, -0.01),
        mount(0.75, 0.5, 2.2, 0.02, 0.015 + math.radians(0.15), -0.01),
    ],
    ids=["2 cm aside", "2 cm down", "turned 0.6 degrees", "tilted 0.15 degrees"],
)
def test_small_bumps_are_noticed_within_three_looks_however_badly_the_tags_were_measured(bumped: SE3) -> None:
    rng = np.random.default_rng(5)
    text = small_lab().model_dump()
    text["floor_tags"]["poses"] = {
        tag: (x + rng.uniform(-0.005, 0.005), y + rng.uniform(-0.005, 0.005), yaw)
        for tag, (x, y, yaw) in LAB.floor_tags.poses.items()
    }
    measured = KnownTags.of(type(LAB).model_validate(text))
    calibration = SelfCalibration("left", MODEL, measured, accuracy=Accuracy(floor_tag_m=0.003))
    assert len(watch(TRUTH, calibration, 10)) == 1
    watch(TRUTH, calibration, 100, seed=100)
    assert calibration.extrinsics is not None
    watch(bumped, calibration, 3, seed=300)
    assert calibration.extrinsics is None
    assert calibration.problem is not None
    assert calibration.problem.startswith("the camera moved")


def test_one_tag_that_was_kicked_is_named_and_does_not_move_the_camera() -> None:
    calibration = calibrated()
    px_per_m = MODEL.fx / TRUTH.translation[2]
    for k in range(5):
        tags = observations(TRUTH, k)
        kicked = TagObservation("tag36h11", 3, tags[3].corners + np.array([0.04 * px_per_m, 0.0]), 80.0, 0)
        calibration.observe([*tags[:3], kicked], k)
    assert calibration.extrinsics is not None
    assert calibration.problem is None
    assert list(calibration.displaced_m) == [3]
    assert calibration.displaced_m[3] == pytest.approx(0.04, rel=0.05)
    assert calibration.notice in {f"floor tag 3 is {mm} mm off where it was" for mm in (39, 40, 41)}
    watch(TRUTH, calibration, 1)
    assert calibration.notice is None, "somebody put it back"


def test_covered_floor_tags_are_no_alarm() -> None:
    calibration = calibrated()
    for k in range(30):
        calibration.observe(observations(TRUTH, k, only=(1, 2)), k)
    assert not calibration.eager
    for k in range(30):
        calibration.observe(observations(TRUTH, k, only=(2,)), k)
    assert not calibration.eager, "it looked again for a while, in vain"
    assert calibration.extrinsics is not None
    assert calibration.problem is None


def test_a_camera_that_lost_its_floor_tags_looks_at_the_whole_picture() -> None:
    calibration = calibrated()
    calibration.observe([], 1)
    assert calibration.eager


def test_what_is_adopted_holds_at_once() -> None:
    calibration = calibrated()
    own = calibration.extrinsics
    assert own is not None
    assert calibration.sighting is not None
    x, y, z = own.translation
    better = msgspec.structs.replace(own, translation=(x + 0.001, y, z), stamp_ns=99)
    calibration.adopt(better)
    assert calibration.extrinsics is better
    assert calibration.view is not None
    assert calibration.view.T_map_camera.translation[0] == pytest.approx(x + 0.001)
    assert not calibration.eager
    watch(TRUTH, calibration, 20)
    assert calibration.extrinsics is better


def test_adopting_what_the_newest_picture_contradicts_is_checked_and_corrected() -> None:
    calibration = calibrated()
    own = calibration.extrinsics
    assert own is not None
    x, y, z = own.translation
    calibration.adopt(msgspec.structs.replace(own, translation=(x + 0.1, y, z), stamp_ns=99))
    assert calibration.eager
    (found,) = watch(TRUTH, calibration, 10)
    assert off(found, TRUTH)[0] < 0.002


def test_adopted_floor_tags_are_where_later_calibrations_expect_them() -> None:
    calibration = calibrated()
    own = calibration.extrinsics
    assert own is not None
    moved = {tag: SE2(x + 0.5, y - 0.25, yaw) for tag, (x, y, yaw) in LAB.floor_tags.poses.items()}
    x, y, z = own.translation
    calibration.adopt(msgspec.structs.replace(own, translation=(x + 0.5, y - 0.25, z)), moved)
    assert not calibration.eager, "picture, place and floor tags agree"
    calibration.restart()
    assert calibration.extrinsics is None
    (found,) = watch(TRUTH, calibration, 10)
    np.testing.assert_allclose(found.translation, TRUTH.translation + np.array([0.5, -0.25, 0.0]), atol=0.002)


def test_looking_again_gives_a_new_sighting_and_keeps_a_calibration_that_holds() -> None:
    calibration = calibrated()
    own, first = calibration.extrinsics, calibration.sighting
    calibration.look_again()
    assert calibration.extrinsics is own
    assert watch(TRUTH, calibration, 10, seed=70) == []
    assert calibration.extrinsics is own
    assert calibration.sighting is not first


def test_a_shaking_picture_is_not_calibrated_from() -> None:
    calibration = SelfCalibration("left", MODEL, KNOWN)
    for k in range(10):
        swaying = mount(0.75 + 0.02 * (k % 2), 0.5, 2.2)
        assert calibration.observe(observations(swaying, k), k) is None
    assert calibration.problem is not None
    assert "shakes" in calibration.problem


def test_a_floor_tag_seen_twice_is_believed_in_neither_place() -> None:
    calibration = SelfCalibration("left", MODEL, KNOWN)
    tags = observations(TRUTH)
    twin = TagObservation("tag36h11", 0, tags[0].corners + 100.0, 80.0, 0)
    calibration.observe([*tags, twin], 0)
    assert calibration.floor_tags_seen == (1, 2, 3)


def test_without_floor_tags_there_is_no_hurry() -> None:
    calibration = SelfCalibration("left", MODEL, KNOWN)
    assert calibration.eager
    for k in range(10):
        calibration.observe([], k)
    assert not calibration.eager
    calibration.observe(observations(TRUTH), 11)
    assert calibration.eager
