"""What a calibration changes, against what is known by construction."""

import numpy as np
import pytest

from geometry import SE2, SE3
from localization.calibration import JointCalibration, refine_jointly
from localization.comparison import InUse, compare_cameras, compare_floor_tags, floor_shift_m, floor_std_m
from localization.projection import CameraView, undistort
from protocol.messages import CameraExtrinsics
from tests.localization.sightings import LAB, sighting
from tests.localization.synthetic import MOUNTS

MODEL = LAB.camera("left").model()
POSE = MOUNTS["left"]
DESCRIBED = {tag: SE2(*pose) for tag, pose in LAB.floor_tags.poses.items()}


def extrinsics(pose: SE3, covariance: np.ndarray | None = None) -> CameraExtrinsics:
    rx, ry, rz = (float(v) for v in pose.rotvec())
    x, y, z = (float(v) for v in pose.translation)
    upper = () if covariance is None else tuple(float(v) for v in covariance[np.triu_indices(10)])
    return CameraExtrinsics("left", 1, (rx, ry, rz), (x, y, z), 0.1, (0, 1, 2, 3), upper)


def test_a_camera_pushed_sideways_shifts_every_point_by_as_much() -> None:
    pushed = SE3(POSE.rotation, POSE.translation + np.array([0.012, -0.005, 0.0]))
    assert floor_shift_m(MODEL, POSE, pushed) == pytest.approx((0.013, 0.013), rel=1e-6)


def test_a_camera_that_looks_at_the_wall_shifts_nothing() -> None:
    sideways = SE3.from_rotvec([-np.pi / 2, 0, 0], [0, 0, 2])
    assert floor_shift_m(MODEL, sideways, sideways) == (0.0, 0.0)
    assert floor_std_m(MODEL, extrinsics(SE3.from_rotvec([0, 0, 0], [0, 0, 2]), np.eye(10))) is None


def test_the_floor_s_standard_deviation_is_that_of_sampled_calibrations() -> None:
    rng = np.random.default_rng(3)
    factor = rng.normal(size=(10, 10)) * np.array([2e-4] * 3 + [5e-4] * 3 + [0.3] * 4)[:, None]
    covariance = factor @ factor.T / 10
    predicted = floor_std_m(MODEL, extrinsics(POSE, covariance))
    pixels = np.array([[u, v] for v in np.linspace(0, 539, 7) for u in np.linspace(0, 959, 9)])
    truth = CameraView(MODEL, POSE).hits(undistort(MODEL, pixels), 0.0).points
    squares: list[float] = []
    for change in rng.multivariate_normal(np.zeros(10), covariance, size=300):
        turned = SE3.from_rotvec(change[:3], [0, 0, 0]).rotation @ POSE.rotation
        model = type(MODEL)(
            960,
            540,
            MODEL.fx + change[6],
            MODEL.fy + change[7],
            MODEL.cx + change[8],
            MODEL.cy + change[9],
            MODEL.distortion,
        )
        view = CameraView(model, SE3(turned, POSE.translation + change[3:6]))
        points = view.hits(undistort(model, pixels), 0.0).points
        squares.append(float(np.square(points - truth).sum(axis=1).mean()))
    assert predicted == pytest.approx(np.sqrt(np.mean(squares)), rel=0.08)


def test_an_unknown_covariance_says_nothing() -> None:
    assert floor_std_m(MODEL, extrinsics(POSE)) is None


def test_a_camera_without_calibration_has_no_before() -> None:
    seen = [sighting("left", 1), sighting("right", 2)]
    joint = refine_jointly(LAB, seen)
    found = compare_cameras(LAB, seen, {"right"}, InUse({}, DESCRIBED), joint)
    assert set(found) == {"left", "right"}
    assert (found["left"].is_new, found["right"].is_new) == (False, True)
    assert found["left"].reprojection_before_px is None
    assert found["left"].floor_shift_max_m is None
    assert 0 < found["left"].reprojection_after_px < 0.3


def test_floor_tags_tell_how_far_they_are_moved_and_who_saw_them() -> None:
    seen = [sighting("left", 1), sighting("right", 2)]
    moved = DESCRIBED | {2: SE2(1.503, 0.004, 0.3)}
    joint = JointCalibration({}, moved, {}, {}, {})
    found = compare_floor_tags(seen, InUse({}, DESCRIBED), joint)
    assert found[2].shift_m == pytest.approx(0.005)
    assert found[2].cameras == ("left", "right")
    assert found[0].shift_m == 0
    assert found[4].cameras == ("right",)
