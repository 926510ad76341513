"""The report's filter: alignment, delay, drift, restarts, and angles across the wrap."""

import math
import random
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.drivers import OdometryReading
from agents.estimation import ExponentialConfig, ExponentialFilter, Localization, OdometryHistory
from agents.motion import STOP, Twist
from geometry import SE2, angle_difference
from tests.agents.plant import Plant, tracked

MS = 1_000_000
START_NS = 1_700_000_000_000_000_000
POSE = st.builds(SE2, st.floats(-10, 10), st.floats(-10, 10), st.floats(-math.pi, math.pi))


def reading(stamp_ns: int, pose: SE2, twist: Twist = STOP, session: str = "a") -> OdometryReading:
    return OdometryReading(stamp_ns, session, pose, twist)


def assert_close(actual: SE2 | None, expected: SE2, metres: float = 1e-6, radians: float = 1e-6) -> None:
    assert actual is not None
    assert actual.distance_to(expected) <= metres
    assert abs(angle_difference(actual.yaw, expected.yaw)) <= radians


@settings(deadline=None)
@given(POSE, POSE, POSE)
def test_start_up_aligns_odometry_to_the_map_in_position_and_yaw(camera: SE2, before: SE2, motion: SE2) -> None:
    """Wherever odometry's frame lies, the motion after the first camera pose is added in the robot's own frame."""
    estimator = ExponentialFilter()
    estimator.add_odometry(reading(START_NS, before))
    assert estimator.add_camera_pose(tracked("r", camera, START_NS))
    estimator.add_odometry(reading(START_NS + 50 * MS, before @ motion))
    estimate = estimator.estimate(START_NS + 50 * MS)
    assert estimate.localization is Localization.ALIGNED
    assert_close(estimate.pose, camera @ motion)


def test_never_localized_is_said() -> None:
    estimator = ExponentialFilter()
    estimator.add_odometry(reading(START_NS, SE2(1.0, 0.0, 0.0)))
    estimate = estimator.estimate(START_NS)
    assert (estimate.localization, estimate.pose, estimate.camera_stamp_ns) == (Localization.NEVER, None, None)


def test_a_camera_pose_before_any_odometry_is_not_used() -> None:
    estimator = ExponentialFilter()
    assert not estimator.add_camera_pose(tracked("r", SE2.identity(), START_NS))


@settings(deadline=None)
@given(POSE, st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-1.0, 1.0))
def test_weights_are_35_and_65_percent(first: SE2, dx: float, dy: float, turn: float) -> None:
    """Also when the two yaws lie on both sides of +-pi."""
    estimator = ExponentialFilter()
    estimator.add_odometry(reading(START_NS, SE2.identity()))
    estimator.add_camera_pose(tracked("r", first, START_NS))
    estimator.add_camera_pose(tracked("r", SE2(first.x + dx, first.y + dy, first.yaw + turn), START_NS + 66 * MS))
    expected = SE2(first.x + 0.35 * dx, first.y + 0.35 * dy, first.yaw + 0.35 * turn)
    assert_close(estimator.estimate(START_NS + 66 * MS).pose, expected)


def drive(
    estimator: ExponentialFilter,
    seconds: float,
    delay_ms: int,
    *,
    twist: Callable[[float], Twist],
    noise_m: float = 0.0,
    distance_scale: float = 1.0,
) -> list[float]:
    """Position errors (m) at 20 Hz of a robot that drives with exact twists; camera at 15 Hz, odometry at 50 Hz."""
    rng = random.Random(7)
    plant = Plant(SE2(3.0, 1.0, 2.5), distance_scale=distance_scale)
    waiting: list[tuple[int, SE2]] = []
    errors: list[float] = []
    for step in range(round(seconds * 300)):
        now_ns = START_NS + step * 1_000_000_000 // 300
        plant.setpoint = twist(step / 300)
        plant.step(1 / 300)
        if step % 6 == 0:
            estimator.add_odometry(plant.reading(now_ns))
        if step % 20 == 0:
            seen = SE2(plant.pose.x + rng.gauss(0, noise_m), plant.pose.y + rng.gauss(0, noise_m), plant.pose.yaw)
            waiting.append((now_ns, seen))
        if waiting and now_ns - waiting[0][0] >= delay_ms * MS:
            stamp_ns, seen = waiting.pop(0)
            estimator.add_camera_pose(tracked("r", seen, stamp_ns))
        pose = estimator.estimate(now_ns).pose
        if step % 15 == 0 and pose is not None:
            errors.append(pose.distance_to(plant.pose))
    return errors


def weaving(t: float) -> Twist:
    return Twist(0.5, 0.8 * math.sin(t))


@pytest.mark.parametrize("delay_ms", [20, 100, 250])
def test_the_cameras_delay_is_made_up_for(delay_ms: int) -> None:
    """At 0.5 m/s a camera 100 ms late would be 50 mm behind; what remains is the vehicle's own reaction between samples."""
    errors = drive(ExponentialFilter(), 20.0, delay_ms, twist=weaving)
    assert max(errors[20:]) < 0.004


def test_drift_and_noise_stay_small() -> None:
    errors = sorted(drive(ExponentialFilter(), 40.0, 100, twist=weaving, noise_m=0.005, distance_scale=1.03)[20:])
    assert errors[len(errors) // 2] < 0.008
    assert errors[-1] < 0.02


def test_smoother_than_the_camera_alone() -> None:
    def jitter(weight: float) -> float:
        errors = drive(
            ExponentialFilter(ExponentialConfig(camera_weight=weight)), 20.0, 100, twist=weaving, noise_m=0.01
        )
        return sum(errors[20:]) / len(errors[20:])

    assert jitter(0.35) < 0.75 * jitter(1.0)


def test_a_restarted_base_is_aligned_again() -> None:
    estimator = ExponentialFilter()
    estimator.add_odometry(reading(START_NS, SE2(5.0, 5.0, 1.0)))
    estimator.add_camera_pose(tracked("r", SE2(1.0, 2.0, 0.5), START_NS))
    estimator.add_odometry(reading(START_NS + 20 * MS, SE2.identity(), session="b"))
    lost = estimator.estimate(START_NS + 20 * MS)
    assert lost.localization is Localization.LOST
    assert_close(lost.pose, SE2(1.0, 2.0, 0.5))
    estimator.add_camera_pose(tracked("r", SE2(1.1, 2.0, 0.5), START_NS + 30 * MS))
    again = estimator.estimate(START_NS + 30 * MS)
    assert again.localization is Localization.ALIGNED
    assert_close(again.pose, SE2(1.1, 2.0, 0.5))


def test_after_a_long_silence_the_camera_counts_whole() -> None:
    """The robot may have been carried; it was not allowed to drive for long."""
    estimator = ExponentialFilter()
    estimator.add_odometry(reading(START_NS, SE2.identity()))
    estimator.add_camera_pose(tracked("r", SE2(1.0, 1.0, 0.0), START_NS))
    later_ns = START_NS + 3_000 * MS
    estimator.add_odometry(reading(later_ns, SE2.identity()))
    assert estimator.estimate(later_ns).localization is Localization.LOST
    estimator.add_camera_pose(tracked("r", SE2(4.0, 1.0, 3.0), later_ns))
    assert_close(estimator.estimate(later_ns).pose, SE2(4.0, 1.0, 3.0))


def test_camera_poses_out_of_order_change_nothing() -> None:
    estimator = ExponentialFilter()
    estimator.add_odometry(reading(START_NS, SE2.identity()))
    estimator.add_camera_pose(tracked("r", SE2.identity(), START_NS + 50 * MS))
    assert not estimator.add_camera_pose(tracked("r", SE2(9.0, 9.0, 0.0), START_NS + 40 * MS))
    assert not estimator.add_camera_pose(tracked("r", SE2(9.0, 9.0, 0.0), START_NS + 50 * MS))
    assert_close(estimator.estimate(START_NS + 50 * MS).pose, SE2.identity())


def test_a_clock_that_was_set_back_leads_to_a_new_alignment() -> None:
    estimator = ExponentialFilter()
    estimator.add_odometry(reading(START_NS, SE2(1.0, 0.0, 0.0)))
    estimator.add_camera_pose(tracked("r", SE2(1.0, 2.0, 0.5), START_NS))
    hour_ago_ns = START_NS - 3_600_000 * MS
    estimator.add_odometry(reading(hour_ago_ns, SE2(1.0, 0.0, 0.0)))
    assert estimator.estimate(hour_ago_ns).localization is Localization.LOST
    assert estimator.add_camera_pose(tracked("r", SE2(3.0, 2.0, 0.5), hour_ago_ns))
    assert_close(estimator.estimate(hour_ago_ns).pose, SE2(3.0, 2.0, 0.5))


@settings(deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.integers(0, 100))
def test_history_interpolates_along_the_arc(linear: float, angular: float, share: int) -> None:
    history = OdometryHistory()
    twist = Twist(linear, angular)
    history.add(reading(START_NS, SE2.identity(), twist))
    history.add(reading(START_NS + 100 * MS, SE2.exp(linear * 0.1, 0.0, angular * 0.1), twist))
    assert_close(
        history.at(START_NS + share * MS), SE2.exp(linear * share / 1e3, 0.0, angular * share / 1e3), 1e-9, 1e-9
    )


def test_history_reaches_only_so_far() -> None:
    history = OdometryHistory(span_s=1.0, max_extrapolation_s=0.1)
    assert history.at(START_NS) is None
    for step in range(31):
        history.add(reading(START_NS + step * 50 * MS, SE2(step * 0.05, 0.0, 0.0), Twist(1.0, 0.0)))
    assert history.at(START_NS) is None, "older than the span"
    assert_close(history.at(START_NS + 1_550 * MS), SE2(1.55, 0.0, 0.0))
    assert history.at(START_NS + 1_601 * MS) is None
