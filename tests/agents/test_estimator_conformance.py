"""What every pose estimator of the registry promises, whatever it is inside."""

import math
import pickle
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace as replace_message

from agents.drivers import OdometryReading
from agents.estimation import DEFAULT_ESTIMATOR, ESTIMATORS, Localization, PoseEstimator
from agents.motion import STOP, Twist
from geometry import SE2, angle_difference
from protocol.messages import TrackedPose
from tests.agents.fusion_drive import MS, START_NS, FusionDrive
from tests.agents.plant import tracked

POSE = st.builds(SE2, st.floats(-10, 10), st.floats(-10, 10), st.floats(-math.pi, math.pi))
pytestmark = pytest.mark.parametrize("name", sorted(ESTIMATORS))


def reading(stamp_ns: int, pose: SE2, session: str = "a") -> OdometryReading:
    return OdometryReading(stamp_ns, session, pose, STOP)


def assert_close(actual: SE2 | None, expected: SE2, metres: float = 1e-6, radians: float = 1e-6) -> None:
    assert actual is not None
    assert actual.distance_to(expected) <= metres
    assert abs(angle_difference(actual.yaw, expected.yaw)) <= radians


def aligned(name: str, camera: SE2, odometry: SE2) -> PoseEstimator:
    estimator = ESTIMATORS[name]()
    estimator.add_odometry(reading(START_NS, odometry))
    assert estimator.add_camera_pose(tracked("r", camera, START_NS))
    return estimator


def test_the_default_is_one_of_them(name: str) -> None:
    assert DEFAULT_ESTIMATOR in ESTIMATORS and name in ESTIMATORS


def test_never_localized_is_said(name: str) -> None:
    estimator = ESTIMATORS[name]()
    assert estimator.estimate(START_NS).localization is Localization.NEVER
    assert not estimator.add_camera_pose(tracked("r", SE2.identity(), START_NS)), "odometry does not reach there"
    estimator.add_odometry(reading(START_NS, SE2(1.0, 0.0, 0.0)))
    estimate = estimator.estimate(START_NS)
    assert (estimate.localization, estimate.pose, estimate.camera_stamp_ns) == (Localization.NEVER, None, None)


@settings(deadline=None, max_examples=30)
@given(camera=POSE, before=POSE, motion=POSE)
def test_start_up_aligns_odometry_to_the_map(name: str, camera: SE2, before: SE2, motion: SE2) -> None:
    motion = SE2(0.05 * motion.x, 0.0, 0.3 * motion.yaw)
    estimator = aligned(name, camera, before)
    estimator.add_odometry(reading(START_NS + 50 * MS, before @ motion))
    estimate = estimator.estimate(START_NS + 50 * MS)
    assert estimate.localization is Localization.ALIGNED
    assert estimate.camera_stamp_ns == START_NS
    assert_close(estimate.pose, camera @ motion)


def test_a_pose_given_twice_counts_once(name: str) -> None:
    estimator = aligned(name, SE2.identity(), SE2.identity())
    pose = tracked("r", SE2(0.004, 0.0, 0.0), START_NS + 50 * MS)
    estimator.add_odometry(reading(START_NS + 50 * MS, SE2.identity()))
    assert estimator.add_camera_pose(pose)
    before = estimator.estimate(START_NS + 50 * MS)
    assert not estimator.add_camera_pose(pose)
    assert estimator.estimate(START_NS + 50 * MS) == before


@pytest.mark.parametrize(
    "changes",
    [
        {"x": math.nan},
        {"y": math.inf},
        {"yaw": -math.inf},
        {"x": 1e300},
        {"covariance": (math.nan, 0.0, 0.0, 1e-4, 0.0, 1e-4)},
        {"covariance": (1e-4, 0.0, 0.0, math.inf, 0.0, 1e-4)},
        {"covariance": (-1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4)},
        {"covariance": (1e-4, 0.0, 0.0, 1e-4, 0.0, -1e-9)},
        {"covariance": (1e-4, 2e-4, 0.0, 1e-4, 0.0, 1e-4)},
        {"covariance": (1e-4, 9e-5, -9e-5, 1e-4, 9e-5, 1e-4)},
    ],
    ids=str,
)
def test_numbers_that_are_none_are_refused(name: str, changes: dict[str, float]) -> None:
    estimator = aligned(name, SE2(1.0, 2.0, 0.5), SE2.identity())
    now_ns = START_NS + 50 * MS
    estimator.add_odometry(reading(now_ns, SE2.identity()))
    before = estimator.estimate(now_ns)
    assert not estimator.add_camera_pose(replace_message(tracked("r", SE2(1.0, 2.0, 0.5), now_ns), **changes))
    assert estimator.estimate(now_ns) == before


def test_odometry_beyond_any_floor_changes_nothing(name: str) -> None:
    estimator = aligned(name, SE2(1.0, 2.0, 0.5), SE2.identity())
    before = estimator.estimate(START_NS)
    estimator.add_odometry(reading(START_NS + 50 * MS, SE2(1e308, -1e308, 0.0)))
    assert estimator.estimate(START_NS) == before


def test_repeated_and_older_odometry_changes_nothing(name: str) -> None:
    estimator = aligned(name, SE2(1.0, 2.0, 0.5), SE2.identity())
    estimator.add_odometry(reading(START_NS, SE2(0.1, 0.0, 0.0)))
    estimator.add_odometry(reading(START_NS - 20 * MS, SE2(0.1, 0.0, 0.0)))
    assert_close(estimator.estimate(START_NS).pose, SE2(1.0, 2.0, 0.5))


def test_a_restarted_base_is_aligned_again(name: str) -> None:
    estimator = aligned(name, SE2(1.0, 2.0, 0.5), SE2(5.0, 5.0, 1.0))
    estimator.add_odometry(reading(START_NS + 20 * MS, SE2.identity(), session="b"))
    lost = estimator.estimate(START_NS + 20 * MS)
    assert lost.localization is Localization.LOST
    assert_close(lost.pose, SE2(1.0, 2.0, 0.5))
    assert estimator.add_camera_pose(tracked("r", SE2(1.1, 2.0, 0.5), START_NS + 30 * MS))
    again = estimator.estimate(START_NS + 30 * MS)
    assert again.localization is Localization.ALIGNED
    assert_close(again.pose, SE2(1.1, 2.0, 0.5))


def test_a_clock_that_was_set_back_leads_to_a_new_alignment(name: str) -> None:
    estimator = aligned(name, SE2(1.0, 2.0, 0.5), SE2(1.0, 0.0, 0.0))
    hour_ago_ns = START_NS - 3_600_000 * MS
    estimator.add_odometry(reading(hour_ago_ns, SE2(1.0, 0.0, 0.0)))
    assert estimator.estimate(hour_ago_ns).localization is Localization.LOST
    assert estimator.add_camera_pose(tracked("r", SE2(3.0, 2.0, 0.5), hour_ago_ns))
    assert_close(estimator.estimate(hour_ago_ns).pose, SE2(3.0, 2.0, 0.5))


@pytest.mark.parametrize("delay_ms", [20, 150, 400])
def test_delay_noise_and_wheels_that_lie(name: str, delay_ms: int) -> None:
    """At 0.5 m/s a camera 400 ms late is 200 mm behind."""
    drive = FusionDrive(ESTIMATORS[name](), delay_ms=delay_ms, distance_scale=1.01, turn_scale=0.99)
    errors = sorted(list(drive.run(20.0))[60:])
    assert errors[len(errors) // 2] < 0.012
    assert errors[-1] < 0.05


def test_a_robot_lifted_elsewhere_is_found_within_two_seconds(name: str) -> None:
    drive = FusionDrive(ESTIMATORS[name]())
    assert max(list(drive.run(10.0))[40:]) < 0.05
    drive.plant.pose = SE2(7.0, 3.0, -1.0)
    errors = list(drive.run(4.0))
    assert max(errors[40:]) < 0.05
    assert drive.estimator.estimate(drive.now_ns).localization is Localization.ALIGNED


def test_memory_is_bounded(name: str) -> None:
    drive = FusionDrive(ESTIMATORS[name]())
    sizes: list[int] = []
    for _ in range(3):
        list(drive.run(8.0))
        sizes.append(len(pickle.dumps(drive.estimator)))
    assert sizes[2] < 1.1 * sizes[1]


def test_a_base_that_floods_does_not_fill_the_memory(name: str) -> None:
    estimator = aligned(name, SE2.identity(), SE2.identity())
    for count in range(1, 4000):
        estimator.add_odometry(reading(START_NS + count, SE2(1e-9 * count, 0.0, 0.0)))
    assert len(pickle.dumps(estimator)) < 3_000_000


FINITE = st.floats(allow_nan=False, allow_infinity=False)
STEP_NS = st.integers(-3_000 * MS, 3_000 * MS)


def _reading(x: float, y: float, yaw: float, v: float, w: float, session: str) -> OdometryReading:
    return OdometryReading(0, session, SE2(x, y, yaw), Twist(v, w))


def _pose(x: float, y: float, yaw: float, xx: float, yy: float, tt: float, xy: float) -> TrackedPose:
    covariance = (xx, xy, 0.0, yy, 0.0, tt)
    return replace_message(tracked("r", SE2.identity(), 0), x=x, y=y, yaw=yaw, covariance=covariance)


ANY_READING = st.builds(
    _reading,
    FINITE | st.floats(-3, 3),
    FINITE | st.floats(-3, 3),
    FINITE,
    FINITE | st.floats(-1, 1),
    FINITE | st.floats(-1, 1),
    st.sampled_from("aaaab"),
)
VARIANCE = st.floats(0.0, 1e-3) | FINITE
ANY_POSE = st.builds(
    _pose,
    FINITE | st.floats(-3, 3),
    FINITE | st.floats(-3, 3),
    FINITE,
    VARIANCE,
    VARIANCE,
    VARIANCE,
    st.just(0.0) | FINITE,
)


@settings(deadline=None, max_examples=60)
@given(events=st.lists(st.tuples(STEP_NS, ANY_READING | ANY_POSE), max_size=30))
def test_estimates_are_finite_whatever_comes(
    name: str, events: list[tuple[int, OdometryReading | TrackedPose]]
) -> None:
    """An SE2 is finite by its constructor; so must the covariance be, and no variance negative."""
    estimator = ESTIMATORS[name]()
    now_ns = START_NS
    for step_ns, event in events:
        now_ns += step_ns
        if isinstance(event, OdometryReading):
            estimator.add_odometry(replace(event, stamp_ns=now_ns))
        else:
            estimator.add_camera_pose(replace_message(event, stamp_ns=now_ns))
        for asked_ns in (now_ns, now_ns + 10**9, now_ns - 10**9, now_ns + 10**17):
            covariance = estimator.estimate(asked_ns).covariance
            assert covariance is None or all(math.isfinite(value) for value in covariance)
            assert covariance is None or min(covariance[0], covariance[3], covariance[5]) >= 0.0


def test_a_short_silence_of_odometry_is_bridged(name: str) -> None:
    """As long as the agent waits for its base (0.2 s) and a little more; the robot is taken to go on."""
    drive = FusionDrive(ESTIMATORS[name](), twist=lambda _: Twist(0.4, 0.0))
    list(drive.run(6.0))
    pose = drive.estimator.estimate(drive.now_ns + 100 * MS).pose
    drive.plant.step(0.1)
    assert pose is not None and pose.distance_to(drive.plant.pose) < 0.03


def test_the_same_input_gives_the_same_estimate(name: str) -> None:
    def run() -> list[float]:
        return list(FusionDrive(ESTIMATORS[name]()).run(3.0))

    assert run() == run()
