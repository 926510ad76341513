"""The filter of a track by itself: its motion model, what it believes of a measurement, and how sure it is."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from geometry import SE2
from localization.tracking.filter import correct, innovation, predict, start
from localization.tracking.motion import Agility, move
from localization.tracking.sight import Sight, cholesky
from protocol.lab import Limits
from tests.localization.camera_reports import PERIOD_NS, SECOND

LIMITS = Limits(speed_mps=1.0)
AGILITY = Agility.of(LIMITS)

states = st.tuples(
    st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3), st.floats(-1, 1), st.floats(-0.3, 0.3), st.floats(-1.5, 1.5)
).map(np.array)


def sight(pose: SE2, noise_m: float, bias_m: float = 0.0, camera: str = "left", stamp_ns: int = 0) -> Sight:
    at = np.array([pose.x, pose.y, pose.yaw])
    return Sight(camera, stamp_ns, at, np.diag(np.square([noise_m, noise_m, noise_m])), bias_m * np.eye(3))


@given(states, st.floats(0.0, 0.5))
def test_the_model_follows_an_arc(mean: np.ndarray, dt: float) -> None:
    """Against the exact motion of a body with a constant twist (SE(2)'s exponential)."""
    after = move(np.append(mean, 0.0), dt, AGILITY)
    x, y, yaw, forward, sideways, turn = (float(v) for v in mean)
    exact = SE2(x, y, yaw) @ SE2.exp(forward * dt, sideways * dt, turn * dt)
    travelled = math.hypot(forward, sideways) * dt
    assert math.dist((exact.x, exact.y), (float(after.mean[0]), float(after.mean[1]))) <= 0.025 * travelled + 1e-9
    assert abs(math.remainder(exact.yaw - float(after.mean[2]), math.tau)) < 1e-8
    assert np.linalg.eigvalsh(after.noise)[0] > -1e-9


@given(states, st.floats(-1.0, 1.0), st.floats(-0.05, 0.5))
def test_the_model_s_jacobian_is_its_derivative(mean: np.ndarray, acceleration: float, dt: float) -> None:
    at, step = np.append(mean, acceleration), 1e-6
    columns = [
        (move(at + step * axis, dt, AGILITY).mean - move(at - step * axis, dt, AGILITY).mean) / (2 * step)
        for axis in np.eye(7)
    ]
    assert move(at, dt, AGILITY).jacobian == pytest.approx(np.array(columns).T, rel=1e-4, abs=1e-7)


@given(states, st.integers(2, 12))
def test_doubt_grows_as_fast_in_many_small_steps_as_in_one(mean: np.ndarray, steps: int) -> None:
    """Else a vehicle that four cameras see would be thought to accelerate less than one that one camera sees."""
    at, dt = np.append(mean * (1, 1, 1, 1, 0, 0), 0.0), 0.06
    whole, parts = move(at, dt, AGILITY).noise, np.zeros((7, 7))
    for _ in range(steps):
        step = move(at, dt / steps, AGILITY)
        at, parts = step.mean, step.jacobian @ parts @ step.jacobian.T + step.noise
    assert np.sqrt(np.diag(parts)) == pytest.approx(np.sqrt(np.diag(whole)), rel=0.12, abs=1e-6)


def test_a_measurement_across_the_seam_of_the_angle_counts_as_near() -> None:
    state = start(sight(SE2(0.0, 0.0, math.pi - 0.01), 0.01), LIMITS)
    seen_pose = innovation(state, sight(SE2(0.0, 0.0, -math.pi + 0.01), 0.01))
    assert float(seen_pose.difference[2]) == pytest.approx(0.02)
    assert abs(abs(float(correct(seen_pose).mean[2])) - math.pi) < 0.01


@given(st.floats(0.0, 0.01), st.floats(0.0, 2.0), st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1))
def test_the_factor_of_a_covariance_may_be_singular(scale: float, size: float, a: float, b: float, c: float) -> None:
    root = np.array([[scale, 0.0, 0.0], [a * scale, size * scale, 0.0], [b * scale, c * scale, 0.0]])
    covariance = root @ root.T
    factor = cholesky(covariance)
    assert factor @ factor.T == pytest.approx(covariance, abs=5e-5 * scale**2)
    assert factor[0, 1] == factor[0, 2] == factor[1, 2] == 0.0


def test_what_a_calibration_has_wrong_does_not_average_away() -> None:
    """A thousand frames of one camera, and one's own motion, say nothing of it; each frame's own noise goes."""
    first = sight(SE2(1.0, 2.0, 0.3), 0.0008, bias_m=0.001)
    state = start(first, LIMITS)
    for number in range(1, 1000):
        now = predict(state, number * SECOND // 60, AGILITY)
        state = correct(innovation(now, sight(SE2(1.0, 2.0, 0.3), 0.0008, 0.001, stamp_ns=now.stamp_ns)))
    sigmas = np.sqrt(np.diag(state.covariance)[:2])
    assert (sigmas > 0.001).all()
    assert (np.square(sigmas) - 0.001**2 < 0.7 * np.diag(first.noise)[:2]).all()


def test_a_camera_that_comes_and_goes_does_not_make_a_standing_vehicle_surer_and_surer() -> None:
    """Its error is the same each time: it is remembered."""
    state = start(sight(SE2(1.0, 2.0, 0.0), 0.0002, bias_m=0.001), LIMITS)
    sigmas: list[float] = []
    for number in range(1, 600):
        camera = "right" if number % 50 == 0 else "left"
        now = predict(state, number * PERIOD_NS, AGILITY)
        state = correct(innovation(now, sight(SE2(1.0, 2.0, 0.0), 0.0002, 0.001, camera, now.stamp_ns)))
        sigmas.append(math.sqrt(float(state.covariance[0, 0])))
    assert sigmas[-1] > 0.9 * sigmas[60]
    assert state.cameras == ("left", "right")


def test_of_very_many_cameras_the_worst_known_is_forgotten() -> None:
    state = start(sight(SE2(0.0, 0.0, 0.0), 0.0002, 0.001, "cam-0"), LIMITS)
    for number in range(1, 20):
        now = predict(state, number * SECOND // 10, AGILITY)
        state = correct(innovation(now, sight(SE2(0.0, 0.0, 0.0), 0.0002, 0.001, f"cam-{number}")))
    assert len(state.cameras) == 6
    assert state.cameras[-1] == "cam-19"
    assert np.linalg.eigvalsh(state.covariance)[0] > 0


def drive_through(rng: np.random.Generator) -> list[tuple[np.ndarray, np.ndarray]]:
    """Error and covariance of every pose of a vehicle that drives at 0.5 m/s from one camera's view through two cameras' into
    the other's. Their errors: 1 mm and 2 mrad, a third of the variance common to both."""
    sigma, common = np.array([0.001, 0.001, 0.002]), rng.normal(size=3)
    offsets = {
        camera: sigma * (math.sqrt(0.3) * common + math.sqrt(0.7) * rng.normal(size=3)) for camera in ("left", "right")
    }
    track, results = None, list[tuple[np.ndarray, np.ndarray]]()
    for number in range(80):
        stamp = number * SECOND // 30
        truth = np.array([0.5 * stamp * 1e-9, 0.0, 0.0])
        cameras = [camera for camera, on in (("left", number < 50), ("right", number >= 30)) if on]
        for camera in cameras:
            pose = truth + offsets[camera] + 0.0001 * rng.normal(size=3)
            one = Sight(camera, stamp, pose, 1e-8 * np.eye(3), np.diag(sigma))
            track = start(one, LIMITS) if track is None else correct(innovation(predict(track, stamp, AGILITY), one))
        assert track is not None
        results.append((track.mean[:3] - truth, track.covariance[:3, :3]))
    return results


def test_the_covariance_is_honest_and_hand_over_is_smooth() -> None:
    """Over 300 rooms: the normalised estimation error squared has mean 3 within its 99.9 % band, before, at and after the
    hand-over (Bar-Shalom et al. 2001, sec. 5.4.2; these errors are the same everywhere, the filter allows for others, so a
    little caution is due); and no step between two poses is larger than half of what the cameras differ by, which a camera
    that comes must bring in."""
    rng = np.random.default_rng(8)
    rooms = [drive_through(rng) for _ in range(300)]
    for frame in (20, 40, 55, 75):
        nees = [
            float(error @ np.linalg.solve(covariance, error)) for error, covariance in (room[frame] for room in rooms)
        ]
        low, high = (float(chi2.ppf(q, 3 * len(rooms))) / len(rooms) for q in (0.0005, 0.9995))
        assert 0.9 * low <= float(np.mean(nees)) <= high, frame
    steps = np.array([[float(np.hypot(*(b[0] - a[0])[:2])) for a, b in pairwise(room)] for room in rooms])
    assert float(np.percentile(steps[:, 29], 95)) < 0.0025  # the second camera comes: the middle of the two is better
    assert float(np.percentile(steps[:, 49], 95)) < 0.0005  # the first goes: nothing new was learned
    assert float(np.percentile(steps[:, 5:28], 95)) < 0.0004  # its noise is 0.1 mm per axis
