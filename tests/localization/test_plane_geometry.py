"""Rays, planes and poses: against OpenCV's projection, numeric derivatives and Monte Carlo."""

import math

import cv2
import msgspec
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from geometry import SE2, SE3, CameraModel
from localization.projection import CameraView, PointsAtInfinityError, undistort
from localization.tag_pose import (
    NotATagError,
    PoseNoise,
    TagPose,
    extrinsics_covariance,
    from_upper,
    tag_pose,
    tag_poses,
    upper,
    vehicle_pose,
)
from localization.tags import tag_corners
from protocol.messages import CameraExtrinsics
from tests.localization.synthetic import mount

MODEL = CameraModel(1920, 1080, 1145.0, 1140.0, 955.0, 545.0, (-0.12, 0.04, 0.001, -0.0008, -0.003))
NOISE = PoseNoise(calibration_px=0.0, height_m=0.0)

mounts = st.builds(
    mount,
    st.floats(-5, 5),
    st.floats(-5, 5),
    st.floats(2.0, 6.0),
    st.floats(-math.pi, math.pi),
    st.floats(-0.4, 0.4),
    st.floats(-0.4, 0.4),
)
pixels = st.lists(st.tuples(st.floats(0, 1919), st.floats(0, 1079)), min_size=1, max_size=8).map(np.array)


def project(T_map_camera: SE3, points: NDArray[np.float64]) -> NDArray[np.float64]:
    T_camera_map = T_map_camera.inverse()
    projected, _ = cv2.projectPoints(
        points, T_camera_map.rotvec(), np.array(T_camera_map.translation), MODEL.matrix(), MODEL.distortion_array()
    )
    return np.asarray(projected, dtype=np.float64).reshape(-1, 2)


def corners_of(pose: SE2, size_m: float, height_m: float) -> NDArray[np.float64]:
    return np.column_stack([pose.apply(tag_corners(size_m)), np.full(4, height_m)])


@given(mounts, pixels, st.floats(0.0, 1.0))
def test_a_pixel_s_ray_meets_the_plane_where_the_point_projects_to_the_pixel(
    T: SE3, image: NDArray[np.float64], height: float
) -> None:
    view = CameraView(MODEL, T)
    hits = view.hits(undistort(MODEL, image), height)
    points = np.column_stack([hits.points, np.full(len(image), height)])
    assert project(T, points) == pytest.approx(image, abs=1e-4)
    again, meant = view.project(points)
    assert meant.all()
    assert again == pytest.approx(image, abs=1e-4)


@given(mounts, pixels, st.floats(0.0, 1.0))
def test_jacobians_are_derivatives(T: SE3, image: NDArray[np.float64], height: float) -> None:
    view = CameraView(MODEL, T)
    plane = undistort(MODEL, image)
    jacobians = view.hits(plane, height).jacobians
    step = 1e-6
    for axis in range(2):
        shift = np.eye(2)[axis] * step
        numeric = (view.hits(plane + shift, height).points - view.hits(plane - shift, height).points) / (2 * step)
        assert jacobians[:, :, axis] == pytest.approx(numeric, rel=1e-4, abs=1e-5)


def test_rays_that_miss_the_plane_are_refused() -> None:
    view = CameraView(MODEL, mount(0, 0, 3))
    with pytest.raises(PointsAtInfinityError):
        view.hits(np.zeros((1, 2)), 3.5)
    level = CameraView(MODEL, mount(0, 0, 3, tilt_x=math.pi / 2 - math.pi))
    with pytest.raises(PointsAtInfinityError):
        level.hits(np.array([[0.0, 0.5], [0.0, -0.5]]), 0.0)


def test_points_behind_or_far_beside_the_camera_have_no_pixel() -> None:
    view = CameraView(MODEL, mount(0, 0, 3))
    _, meant = view.project(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 5.0], [60.0, 0.0, 0.0], [0.0, 60.0, 0.0]]))
    assert meant.tolist() == [True, False, False, False]


@given(
    mounts,
    st.floats(200, 1700),
    st.floats(200, 900),
    st.floats(-math.pi, math.pi),
    st.floats(0.05, 0.3),
    st.floats(0.0, 1.0),
)
def test_a_tag_s_pose_comes_back_from_its_corners(
    T: SE3, u: float, v: float, yaw: float, size: float, height: float
) -> None:
    view = CameraView(MODEL, T)
    (centre,) = view.hits(undistort(MODEL, np.array([[u, v]])), height).points
    truth = SE2(float(centre[0]), float(centre[1]), yaw)
    found = tag_pose(view, undistort(MODEL, project(T, corners_of(truth, size, height))), size, height, NOISE)
    assert truth.distance_to(found.pose) < 1e-6
    assert abs(math.remainder(found.pose.yaw - truth.yaw, math.tau)) < 1e-5
    assert found.misfit_m < 1e-6
    assert np.linalg.eigvalsh(found.covariance)[0] > 0


def test_the_axis_runs_from_left_bottom_to_right_bottom() -> None:
    """By hand: a camera looks straight down, image x along map x, so image y runs along map -y. AprilTag's left-bottom corner
    is the second of OpenCV's four, right-bottom the first. A tag whose bottom edge runs along map +y has yaw 90 degrees."""
    view = CameraView(CameraModel(1000, 1000, 500.0, 500.0, 500.0, 500.0), mount(0, 0, 2))
    side = 0.1 * 500 / 2
    left_bottom, right_bottom = (525.0, 500.0), (525.0, 500.0 - side)
    right_top, left_top = (525.0 - side, 500.0 - side), (525.0 - side, 500.0)
    corners = np.array([right_bottom, left_bottom, left_top, right_top])
    found = tag_pose(view, undistort(view.model, corners), 0.1, 0.0, NOISE)
    assert found.pose.yaw == pytest.approx(math.pi / 2)
    assert (found.pose.x, found.pose.y) == pytest.approx((0.05, 0.05))


def test_the_covariance_is_that_of_noisy_corners() -> None:
    T = mount(0.3, -0.2, 2.8, 0.4, 0.15, -0.1)
    view = CameraView(MODEL, T)
    truth, size, height = SE2(1.2, 0.4, 0.7), 0.16, 0.35
    corners = project(T, corners_of(truth, size, height))
    rng = np.random.default_rng(5)
    noise = PoseNoise(corner_px=0.3, calibration_px=0.0, height_m=0.0)
    errors: list[list[float]] = []
    for _ in range(4000):
        noisy = undistort(MODEL, corners + rng.normal(0.0, noise.corner_px, (4, 2)))
        pose = tag_pose(view, noisy, size, height, noise).pose
        errors.append([pose.x - truth.x, pose.y - truth.y, pose.yaw - truth.yaw])
    predicted = tag_pose(view, undistort(MODEL, corners), size, height, noise).covariance
    sampled = np.cov(np.array(errors).T)
    assert np.sqrt(np.diag(predicted)) == pytest.approx(np.sqrt(np.diag(sampled)), rel=0.04)


def test_a_wrong_calibration_moves_poses_as_its_covariance_says() -> None:
    """Against Monte Carlo through the whole chain: pixels of the true camera, read with a camera that is off."""
    T = mount(0.3, -0.2, 2.8, 0.4, 0.15, -0.1)
    truth, size, height = SE2(1.2, 0.4, 0.7), 0.16, 0.35
    corners = project(T, corners_of(truth, size, height))
    rng = np.random.default_rng(11)
    mixed = rng.normal(0.0, 1.0, (10, 10)) / 3
    sigmas = np.array([1e-3, 1e-3, 1e-3, 2e-3, 2e-3, 2e-3, 1.0, 1.0, 1.0, 1.0])
    covariance = sigmas[:, None] * (mixed @ mixed.T) * sigmas
    errors: list[list[float]] = []
    for _ in range(2000):
        *turn, dx, dy, dz, dfx, dfy, dcx, dcy = rng.multivariate_normal(np.zeros(10), covariance)
        wrong = CameraModel(
            1920, 1080, MODEL.fx + dfx, MODEL.fy + dfy, MODEL.cx + dcx, MODEL.cy + dcy, MODEL.distortion
        )
        turned = (SE3.from_rotvec(turn, [0, 0, 0]) @ SE3(T.rotation, np.zeros(3))).rotation
        view = CameraView(wrong, SE3(turned, T.translation + np.array([dx, dy, dz])))
        pose = tag_pose(view, undistort(wrong, corners), size, height, NOISE).pose
        errors.append([pose.x - truth.x, pose.y - truth.y, pose.yaw - truth.yaw])
    noise = PoseNoise(corner_px=0.0, height_m=0.0, calibration=covariance)
    predicted = tag_pose(CameraView(MODEL, T), undistort(MODEL, corners), size, height, noise)
    assert predicted.covariance == pytest.approx(predicted.systematic)
    whitened = np.linalg.solve(np.linalg.cholesky(predicted.systematic), np.array(errors).T)
    assert np.cov(whitened) == pytest.approx(np.eye(3), abs=0.12)


@given(mounts, st.lists(st.tuples(st.floats(300, 1600), st.floats(200, 900)), min_size=1, max_size=5))
def test_tags_done_together_are_as_tags_done_alone(T: SE3, places: list[tuple[float, float]]) -> None:
    view, noise = CameraView(MODEL, T), PoseNoise(calibration=1e-6 * np.eye(10))
    sizes = [0.1 + 0.02 * k for k in range(len(places))]
    heights = [0.1 * k for k in range(len(places))]
    planes: list[NDArray[np.float64]] = []
    for k, (place, size, height) in enumerate(zip(places, sizes, heights, strict=True)):
        (centre,) = view.hits(undistort(MODEL, np.array([place])), height).points
        tag = SE2(float(centre[0]), float(centre[1]), 0.5 * k)
        planes.append(undistort(MODEL, project(T, corners_of(tag, size, height))))
    planes[-1] = planes[-1][::-1]  # mirrored: no tag
    together = tag_poses(view, np.array(planes), sizes, heights, noise)
    assert isinstance(together[-1], NotATagError)
    for found, plane, size, height in zip(together[:-1], planes, sizes, heights, strict=False):
        alone = tag_pose(view, plane, size, height, noise)
        assert isinstance(found, TagPose)
        assert found.pose == alone.pose
        assert found.covariance == pytest.approx(alone.covariance)
        assert found.systematic == pytest.approx(alone.systematic)


def test_a_tag_above_the_horizon_does_not_spoil_the_others() -> None:
    T = mount(0, 0, 3)
    plane = undistort(MODEL, project(T, corners_of(SE2(0.3, 0.2, 0.5), 0.16, 0.1)))
    good, bad = tag_poses(CameraView(MODEL, T), np.array([plane, plane]), [0.16, 0.16], [0.1, 3.5], PoseNoise())
    assert isinstance(good, TagPose)
    assert isinstance(bad, PointsAtInfinityError)
    assert tag_poses(CameraView(MODEL, T), np.empty((0, 4, 2)), [], [], PoseNoise()) == []


def test_the_covariance_of_extrinsics_comes_out_of_the_message_symmetric() -> None:
    half = np.random.default_rng(2).normal(size=(10, 10))
    full = half @ half.T
    plain = CameraExtrinsics("cam", 0, (0.0, 0.0, 0.0), (0.0, 0.0, 3.0), 0.1, (1, 2))
    assert extrinsics_covariance(plain) is None
    told = msgspec.structs.replace(plain, covariance=tuple(float(v) for v in full[np.triu_indices(10)]))
    assert extrinsics_covariance(told) == pytest.approx(full)
    with pytest.raises(ValueError, match="cam: a covariance has 55 numbers, not 3"):
        extrinsics_covariance(msgspec.structs.replace(plain, covariance=(1.0, 2.0, 3.0)))


def test_doubt_grows_with_distance_and_obliqueness() -> None:
    def doubt(T: SE3, x: float) -> float:
        plane = undistort(MODEL, project(T, corners_of(SE2(x, 0.0, 0.2), 0.16, 0.0)))
        return float(np.trace(tag_pose(CameraView(MODEL, T), plane, 0.16, 0.0, NOISE).covariance[:2, :2]))

    below, higher = doubt(mount(0, 0, 3), 0.0), doubt(mount(0, 0, 6), 0.0)
    assert higher == pytest.approx(4 * below, rel=0.05)
    # Looking along the floor, away from the camera's foot, stretches errors along the ray.
    assert doubt(mount(0, 0, 2, tilt_y=0.9), 3.0) > 2 * doubt(mount(0, 0, math.hypot(2, 3)), 0.0)


def test_a_calibration_error_counts_whatever_the_tag_s_size() -> None:
    """A pixel at 3 m is 3 / 1145 m; four corners do not average it away."""
    T = mount(0, 0, 3)
    plane = undistort(MODEL, project(T, corners_of(SE2(0.1, 0.0, 0.2), 0.16, 0.0)))
    noise = PoseNoise(corner_px=0.0, calibration_px=1.0, height_m=0.0)
    sigmas = np.sqrt(np.diag(tag_pose(CameraView(MODEL, T), plane, 0.16, 0.0, noise).covariance))
    assert sigmas == pytest.approx([3 / 1145, 3 / 1140, 3 / 1142], rel=0.01)


def test_a_height_measured_wrongly_counts_away_from_the_camera_s_foot() -> None:
    T = mount(0, 0, 3)
    size, height, error_m = 0.16, 0.5, 0.004
    truth = SE2(2.0, 0.0, 0.2)
    corners = undistort(MODEL, project(T, corners_of(truth, size, height + error_m)))
    found = tag_pose(CameraView(MODEL, T), corners, size, height, PoseNoise(0.0, 0.0, height_m=error_m))
    off = abs(found.pose.x - truth.x)
    assert off == pytest.approx(error_m * 2.0 / 2.5, rel=0.02)
    assert math.sqrt(float(found.covariance[0, 0])) == pytest.approx(off, rel=0.02)
    assert float(found.covariance[1, 1]) < 1e-9


def test_corners_that_are_no_square_of_that_size_are_refused() -> None:
    T = mount(0, 0, 3)
    view = CameraView(MODEL, T)
    corners = project(T, corners_of(SE2(0.3, 0.2, 0.5), 0.16, 0.0))
    with pytest.raises(NotATagError, match="mm off a square of 100 mm"):
        tag_pose(view, undistort(MODEL, corners), 0.10, 0.0, NOISE)
    bent = corners + np.array([[0, 0], [0, 0], [30, 0], [0, 0]])
    with pytest.raises(NotATagError):
        tag_pose(view, undistort(MODEL, bent), 0.16, 0.0, NOISE)
    mirrored = corners[::-1]
    with pytest.raises(NotATagError):
        tag_pose(view, undistort(MODEL, mirrored), 0.16, 0.0, NOISE)


offsets = st.builds(SE2, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3, 3))
poses = st.builds(SE2, st.floats(-9, 9), st.floats(-9, 9), st.floats(-3.1, 3.1))


@given(poses, offsets)
def test_a_vehicle_stands_where_its_tag_says(vehicle: SE2, T_vehicle_tag: SE2) -> None:
    found, _ = vehicle_pose(vehicle @ T_vehicle_tag, np.eye(3), T_vehicle_tag)
    assert vehicle.distance_to(found) < 1e-9
    assert abs(math.remainder(found.yaw - vehicle.yaw, math.tau)) < 1e-9


@given(poses, offsets)
def test_yaw_noise_moves_the_rotation_centre_by_its_lever(tag: SE2, T_vehicle_tag: SE2) -> None:
    assume(math.hypot(T_vehicle_tag.x, T_vehicle_tag.y) > 1e-3)
    _, covariance = vehicle_pose(tag, np.diag([0.0, 0.0, 1e-4]), T_vehicle_tag)
    lever = math.hypot(T_vehicle_tag.x, T_vehicle_tag.y)
    assert float(np.trace(covariance[:2, :2])) == pytest.approx(lever**2 * 1e-4, rel=1e-6)
    assert from_upper(upper(covariance)) == pytest.approx(covariance)
