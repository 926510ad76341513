"""Group axioms and round trips of the rigid transforms, and the wrapping of angles."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from geometry import SE2, SE3, angle_difference, mean_angle, wrap_angle

metres = st.floats(-100.0, 100.0)
angles = st.floats(-20.0, 20.0)
poses2 = st.builds(SE2, metres, metres, angles)
vectors = st.tuples(st.floats(-1.8, 1.8), st.floats(-1.8, 1.8), st.floats(-1.8, 1.8))
poses3 = st.builds(SE3.from_rotvec, vectors, st.tuples(metres, metres, metres))
points2 = st.lists(st.tuples(metres, metres), min_size=1, max_size=5)


def close2(a: SE2, b: SE2) -> bool:
    return a.distance_to(b) < 1e-6 and abs(angle_difference(a.yaw, b.yaw)) < 1e-9


def close3(a: SE3, b: SE3) -> bool:
    return bool(np.allclose(a.as_matrix(), b.as_matrix(), atol=1e-6))


@given(angles)
def test_wrapping_keeps_the_direction_and_stays_in_the_half_open_interval(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-9)


def test_minus_half_a_turn_is_plus_half_a_turn() -> None:
    assert wrap_angle(-math.pi) == math.pi
    assert wrap_angle(3 * math.pi) == pytest.approx(math.pi)


def test_mean_angle_crosses_the_seam_and_refuses_a_tie() -> None:
    assert abs(mean_angle([math.pi - 0.1, -math.pi + 0.1])) == pytest.approx(math.pi)
    with pytest.raises(ValueError, match="undefined"):
        mean_angle([0.0, math.pi])
    with pytest.raises(ValueError, match="undefined"):
        mean_angle([])


@given(poses2, poses2, poses2)
def test_se2_is_a_group(a: SE2, b: SE2, c: SE2) -> None:
    assert close2((a @ b) @ c, a @ (b @ c))
    assert close2(a @ SE2.identity(), a)
    assert close2(a @ a.inverse(), SE2.identity())
    assert close2(a @ a.between(b), b)


@given(poses2, poses2, points2)
def test_se2_acts_on_points_as_its_matrix_does(a: SE2, b: SE2, points: list[tuple[float, float]]) -> None:
    homogeneous = np.column_stack([points, np.ones(len(points))])
    expected = (homogeneous @ a.as_matrix().T)[:, :2]
    assert np.allclose(a.apply(points), expected, atol=1e-9)
    assert np.allclose((a @ b).apply(points), a.apply(b.apply(points)), atol=1e-6)


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3.1, 3.1))
def test_se2_log_inverts_exp(vx: float, vy: float, omega: float) -> None:
    assert np.allclose(SE2.exp(vx, vy, omega).log(), (vx, vy, omega), atol=1e-6)


def test_se2_exp_follows_a_circle() -> None:
    quarter = SE2.exp(math.pi / 2, 0.0, math.pi / 2)
    assert (quarter.x, quarter.y, quarter.yaw) == pytest.approx((1.0, 1.0, math.pi / 2))


@given(poses3, poses3, poses3)
def test_se3_is_a_group(a: SE3, b: SE3, c: SE3) -> None:
    assert close3((a @ b) @ c, a @ (b @ c))
    assert close3(a @ SE3.identity(), a)
    assert close3(a @ a.inverse(), SE3.identity())


@given(vectors)
def test_rotation_vectors_round_trip(rotvec: tuple[float, float, float]) -> None:
    assume(float(np.linalg.norm(rotvec)) < math.pi - 1e-3)
    assert np.allclose(SE3.from_rotvec(rotvec, (0, 0, 0)).rotvec(), rotvec, atol=1e-7)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0.8, 0.0)])
def test_rotation_vector_of_half_a_turn(axis: tuple[float, float, float]) -> None:
    rotvec = SE3.from_rotvec(np.array(axis) * math.pi, (0, 0, 0)).rotvec()
    assert np.allclose(np.abs(rotvec), np.abs(np.array(axis) * math.pi), atol=1e-6)


@given(poses2, st.floats(-3, 3))
def test_lifting_a_planar_pose_and_looking_from_above_gives_it_back(pose: SE2, z: float) -> None:
    assert close2(SE3.from_se2(pose, z).to_se2(), pose)


@given(poses3, poses3)
def test_angle_between_poses_is_symmetric_and_bounded(a: SE3, b: SE3) -> None:
    assert a.angle_to(b) == pytest.approx(b.angle_to(a), abs=1e-6)
    assert 0.0 <= a.angle_to(b) <= math.pi + 1e-9


def test_what_is_not_a_rigid_transform_is_refused() -> None:
    with pytest.raises(ValueError, match="not a rotation"):
        SE3(np.diag([1.0, 1.0, -1.0]), np.zeros(3))
    with pytest.raises(ValueError, match="shapes"):
        SE3(np.eye(2), np.zeros(3))
    with pytest.raises(ValueError, match="finite"):
        SE2(math.nan, 0.0, 0.0)
    with pytest.raises(ValueError, match="shape"):
        SE2.identity().apply([[1.0, 2.0, 3.0]])
