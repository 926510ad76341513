"""The Kalman filter's formulas: Jacobians and slopes against finite differences."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from agents.estimation import mean_nis_band
from agents.estimation.ekf_belief import Belief, innovation, predicted, updated
from agents.estimation.ekf_model import SIZE, YAW, Motion, Sight, motion_jacobians, moved, velocity
from agents.estimation.ekf_noise import NoiseConfig, NoiseModel
from geometry import SE2, angle_difference

Array = NDArray[np.float64]
_STEP = 1e-6

STATE = st.tuples(
    st.floats(-10, 10),
    st.floats(-10, 10),
    st.floats(-math.pi, math.pi),
    st.floats(0.8, 1.2),
    st.floats(0.8, 1.2),
    st.floats(-0.1, 0.1),
    st.floats(-0.2, 0.3),
).map(lambda values: np.array(values))
MOTION = st.builds(
    Motion,
    st.floats(-0.5, 0.5),
    st.floats(-0.1, 0.1),
    st.floats(-2.0, 2.0) | st.floats(-1e-3, 1e-3),
    st.floats(0.01, 1.0),
)


def slope(function: Callable[[Array], Array], at: Array) -> Array:
    """Central differences (outputs, inputs); the third output is an angle."""
    columns: list[Array] = []
    for axis in range(len(at)):
        step = np.zeros(len(at))
        step[axis] = _STEP
        above, below = function(at + step), function(at - step)
        difference = above - below
        difference[YAW] = angle_difference(float(above[YAW]), float(below[YAW]))
        columns.append(difference / (2 * _STEP))
    return np.column_stack(columns)


@settings(deadline=None)
@given(STATE, MOTION)
def test_motion_jacobian_by_state(state: Array, motion: Motion) -> None:
    by_state, _ = motion_jacobians(state, motion)
    np.testing.assert_allclose(by_state, slope(lambda x: moved(x, motion), state), atol=2e-7)


@settings(deadline=None)
@given(STATE, MOTION)
def test_motion_jacobian_by_twist(state: Array, motion: Motion) -> None:
    """At factors of one and no curvature the corrected twist is the measured one."""
    state[3:6] = 1.0, 1.0, 0.0

    def pose_after(twist: Array) -> Array:
        return moved(state, Motion(float(twist[0]), float(twist[1]), float(twist[2]), motion.dt_s))[:3]

    _, by_twist = motion_jacobians(state, motion)
    twist = np.array([motion.forward_m, motion.left_m, motion.turn_rad])
    np.testing.assert_allclose(by_twist, slope(pose_after, twist), atol=2e-7)


@settings(deadline=None)
@given(STATE, MOTION, STATE)
def test_sight_jacobian(state: Array, motion: Motion, seen: Array) -> None:
    sight = Sight(seen[:3], np.eye(3), 0.05, velocity(state, motion))
    np.testing.assert_allclose(sight.jacobian(), -slope(sight.innovation, state), atol=1e-6)


@settings(deadline=None)
@given(STATE, MOTION)
def test_moves_as_se2_does(state: Array, motion: Motion) -> None:
    state[3:6] = 1.0, 1.0, 0.0
    expected = SE2(*(float(value) for value in state[:3])) @ SE2.exp(motion.forward_m, motion.left_m, motion.turn_rad)
    after = moved(state, motion)
    np.testing.assert_allclose(after[:2], [expected.x, expected.y], atol=1e-9)
    assert abs(angle_difference(float(after[YAW]), expected.yaw)) < 1e-9


def test_late_stamps_look_back_along_the_way() -> None:
    """Driving along x at 1 m/s, a pose whose stamp is 0.1 s late is 0.1 m behind where the stamp is looked up."""
    state = np.array([5.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.1])
    sight = Sight(np.array([4.9, 0.0, 0.0]), np.eye(3), 0.0, velocity(state, Motion(0.05, 0.0, 0.0, 0.05)))
    np.testing.assert_allclose(sight.innovation(state), 0.0, atol=1e-12)


def with_scales(logarithms: Array) -> NoiseModel:
    noise = NoiseModel(NoiseConfig())
    noise.scales = np.exp(logarithms)
    return noise


def filtered(logarithms: Array, learner: NoiseModel | None = None, *, winding: bool = True) -> tuple[float, Array]:
    """The log-likelihood of a short drive under these scales, and its slope by the terms that learning uses."""
    rng = np.random.default_rng(5)
    noise = with_scales(logarithms)
    constants = np.array([1.0, 1.0, 0.0, 0.0])
    belief = Belief.at(np.array([1.0, 2.0, 0.5]), 1e-4 * np.eye(3), constants, np.diag(noise.constants()))
    total, gradient = 0.0, np.zeros(3)
    truth = belief.mean.copy()
    covariance = np.diag([1e-4, 1e-4, 4e-4])
    for step in range(40):
        motion = Motion(0.05, 0.0, winding * 0.08 * math.sin(step / 3.0), 0.1)
        truth = moved(truth, Motion(0.052, 0.001, motion.turn_rad + winding * float(rng.normal(0.0, 0.02)), 0.1))
        belief = predicted(belief, motion, noise)
        seen = truth[:3] + rng.standard_normal(3) * np.sqrt(np.diag(covariance))
        sight = Sight(seen, covariance, 0.0, velocity(belief.mean, motion))
        found = innovation(belief, sight, noise)
        total -= 0.5 * (float(np.linalg.slogdet(found.covariance)[1]) + found.nis)
        inverse = np.linalg.inv(found.covariance)
        whitened = inverse @ found.difference
        gradient += 0.5 * np.einsum("i,kij,j->k", whitened, found.slopes, whitened)
        gradient -= 0.5 * np.einsum("ij,kji->k", inverse, found.slopes) + found.difference_slopes @ whitened
        if learner is not None:
            learner.learn(found.difference, found.covariance, found.difference_slopes, found.slopes)
        belief = updated(belief, sight, noise)
    return total, gradient


@pytest.mark.parametrize("at", [(0.0, 0.0, 0.0), (1.0, -1.0, 0.3)])
@pytest.mark.parametrize(("winding", "off"), [(False, 0.06), (True, 0.4)])
def test_the_slopes_of_the_likelihood_by_the_noises(
    at: tuple[float, float, float], *, winding: bool, off: float
) -> None:
    """Through mean, gain and covariance. They are those of the linearized filter: straight on the same as the differences, in
    curves, where they are up to 28, as much as 0.32 off."""
    logarithms, step = np.array(at), 1e-4
    _, gradient = filtered(logarithms, winding=winding)
    for axis in range(3):
        moved_by = np.zeros(3)
        moved_by[axis] = step
        above, below = (filtered(logarithms + sign * moved_by, winding=winding)[0] for sign in (1.0, -1.0))
        assert gradient[axis] == pytest.approx((above - below) / (2 * step), rel=0.02, abs=off)


def test_learning_goes_uphill() -> None:
    learner = NoiseModel(NoiseConfig())
    before, _ = filtered(np.zeros(3), learner)
    after, _ = filtered(np.log(learner.scales))
    assert after > before


def test_covariances_stay_symmetric_and_positive() -> None:
    noise = NoiseModel(NoiseConfig())
    constants = np.array([1.0, 1.0, 0.0, 0.0])
    belief = Belief.at(np.zeros(3), 1e-6 * np.eye(3), constants, np.diag(noise.constants()))
    rng = np.random.default_rng(1)
    for _ in range(2000):
        dx, dy, dyaw = rng.normal(0.0, 0.1, 3).tolist()
        belief = predicted(belief, Motion(dx, dy, dyaw, 0.05), noise)
        seen = belief.mean[:3] + rng.normal(0.0, 1e-3, 3)
        belief = updated(belief, Sight(seen, 1e-12 * np.eye(3), 0.0, rng.normal(0.0, 1.0, 3)), noise)
        assert np.array_equal(belief.covariance, belief.covariance.T)
    assert belief.mean.shape == (SIZE,)
    assert np.linalg.eigvalsh(belief.covariance)[0] > 0.0


def test_the_nis_band_narrows_with_the_count() -> None:
    """Chi-square quantiles of 600 degrees of freedom at 0.05 and 99.95 %, by 200."""
    low, high = mean_nis_band(200)
    assert (low, high) == (pytest.approx(2.465, abs=0.01), pytest.approx(3.606, abs=0.01))
    assert mean_nis_band(20)[1] > high
