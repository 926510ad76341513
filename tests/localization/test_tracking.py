"""Tracks: motion model, fusion in any order, gates, loss and recovery, doubled ids."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import SE2
from localization.tracking import Tracker
from localization.tracking.motion import Agility, correct, innovation, predict, start
from protocol.lab import Limits
from protocol.messages import Detection, FrameDetections, TrackedPose
from tests.localization.synthetic import small_lab

LAB = small_lab()
VEHICLE = LAB.vehicle("robot-10")
LIMITS = Limits(speed_mps=1.0)
AGILITY = Agility.of(LIMITS)
SECOND = 1_000_000_000
PERIOD_NS = SECOND // 15
SIGMA_M, SIGMA_RAD = 0.001, 0.002
SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))

states = st.tuples(
    st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3), st.floats(-1, 1), st.floats(-0.3, 0.3), st.floats(-1.5, 1.5)
).map(np.array)


def detection(vehicle: SE2, tag_id: int = 10, sigma_m: float = SIGMA_M) -> Detection:
    """What a camera says of a vehicle whose rotation centre is there."""
    worn = next(v.tag for v in LAB.vehicles if v.tag.id == tag_id) if tag_id in (10, 11) else VEHICLE.tag
    tag = vehicle @ worn.pose_on_vehicle()
    covariance = (sigma_m**2, 0.0, 0.0, sigma_m**2, 0.0, SIGMA_RAD**2)
    return Detection("tag36h11", tag_id, SQUARE, 80.0, tag.x, tag.y, tag.yaw, covariance)


def seen(camera: str, stamp_ns: int, *detections: Detection) -> FrameDetections:
    return FrameDetections(camera, stamp_ns, stamp_ns, 0, False, detections, {})


def circle(t: float) -> SE2:
    """0.5 m/s on a circle of 0.8 m radius."""
    turn = 0.5 / 0.8
    return SE2(1.0 + 0.8 * math.sin(turn * t), 0.5 - 0.8 * math.cos(turn * t), turn * t)


def only(poses: list[TrackedPose]) -> TrackedPose:
    (pose,) = poses
    return pose


def standing(tracker: Tracker, frames: int = 10, pose: SE2 | None = None) -> int:
    """A track at rest; returns the stamp of its last frame."""
    for number in range(frames):
        tracker.update(seen("left", number * PERIOD_NS, detection(pose or SE2(1, 0.5, 0))))
    return (frames - 1) * PERIOD_NS


@given(states, st.floats(0.0, 0.5))
def test_the_model_follows_an_arc(mean: np.ndarray, dt: float) -> None:
    """Against the exact motion of a body with a constant twist (SE(2)'s exponential)."""
    before = start(0, mean[:3], np.eye(3), LIMITS)
    before.mean[:] = mean
    after = predict(before, round(dt * SECOND), AGILITY)
    x, y, yaw, forward, sideways, turn = (float(v) for v in mean)
    exact = SE2(x, y, yaw) @ SE2.exp(forward * dt, sideways * dt, turn * dt)
    travelled = math.hypot(forward, sideways) * dt
    assert math.dist((exact.x, exact.y), (float(after.mean[0]), float(after.mean[1]))) <= 0.025 * travelled + 1e-9
    assert abs(math.remainder(exact.yaw - float(after.mean[2]), math.tau)) < 1e-8
    assert np.linalg.eigvalsh(after.covariance)[0] > -1e-9


@given(states, st.floats(0.01, 0.5))
def test_the_covariance_moves_by_the_model_s_derivative(mean: np.ndarray, dt: float) -> None:
    still = Agility(0.0, 0.0, 0.0)
    stamp = round(dt * SECOND)

    def moved(at: np.ndarray) -> np.ndarray:
        state = start(0, at[:3], np.eye(3), LIMITS)
        state.mean[:] = at
        return predict(state, stamp, still).mean

    step = 1e-6
    columns = [(moved(mean + step * axis) - moved(mean - step * axis)) / (2 * step) for axis in np.eye(6)]
    jacobian = np.array(columns).T
    before = start(0, mean[:3], np.diag([1e-4, 4e-4, 9e-4]), LIMITS)
    before.mean[:] = mean
    expected = jacobian @ before.covariance @ jacobian.T
    assert predict(before, stamp, still).covariance == pytest.approx(expected, rel=1e-4, abs=1e-8)


def test_a_measurement_across_the_seam_of_the_angle_counts_as_near() -> None:
    state = start(0, np.array([0.0, 0.0, math.pi - 0.01]), np.eye(3) * 1e-4, LIMITS)
    seen_pose = innovation(state, np.array([0.0, 0.0, -math.pi + 0.01]), np.eye(3) * 1e-4)
    assert float(seen_pose.difference[2]) == pytest.approx(0.02)
    assert abs(abs(float(correct(state, seen_pose).mean[2])) - math.pi) < 0.01


def test_a_vehicle_on_a_circle_is_followed_with_its_velocities() -> None:
    tracker = Tracker(LAB)
    rng = np.random.default_rng(4)
    errors: list[float] = []
    for number in range(60):
        truth = circle(number / 15)
        noisy = SE2(
            truth.x + rng.normal(0, SIGMA_M), truth.y + rng.normal(0, SIGMA_M), truth.yaw + rng.normal(0, SIGMA_RAD)
        )
        pose = only(tracker.update(seen("left", number * PERIOD_NS, detection(noisy))))
        assert pose.stamp_ns == number * PERIOD_NS
        if number > 15:
            errors.append(math.dist((pose.x, pose.y), (truth.x, truth.y)))
            speed = (0.5 * math.cos(truth.yaw), 0.5 * math.sin(truth.yaw))
            assert (pose.vx, pose.vy) == pytest.approx(speed, abs=0.06)
            assert pose.yaw_rate == pytest.approx(0.625, abs=0.12)
    assert float(np.median(errors)) < 1.5 * SIGMA_M
    ahead = tracker.predict("robot-10", 62 * PERIOD_NS)
    assert ahead is not None
    assert math.dist((ahead.x, ahead.y), (circle(62 / 15).x, circle(62 / 15).y)) < 0.02


def test_pose_is_that_of_the_rotation_centre_in_its_area() -> None:
    pose = only(Tracker(LAB).update(seen("left", 0, detection(SE2(1.0, 0.5, 0.7)))))
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.0, 0.5, 0.7))
    assert (pose.vehicle, pose.area, pose.cameras) == ("robot-10", "room", ("left",))
    outside = only(Tracker(LAB).update(seen("left", 0, detection(SE2(9.0, 9.0, 0.7)))))
    assert outside.area is None


def test_two_cameras_are_fused_by_their_covariance_never_alternated() -> None:
    """They disagree by 4 mm; the surer one counts sixteen times as much, and the pose does not jump between them."""
    tracker = Tracker(LAB)
    places: list[float] = []
    for number in range(40):
        stamp = number * PERIOD_NS
        tracker.update(seen("left", stamp, detection(SE2(1.000, 0.5, 0.0), sigma_m=0.001)))
        pose = only(tracker.update(seen("right", stamp, detection(SE2(1.004, 0.5, 0.0), sigma_m=0.004))))
        assert pose.cameras == ("left", "right")
        places.append(pose.x)
    assert max(abs(b - a) for a, b in pairwise(places[5:])) < 0.0001
    assert places[-1] == pytest.approx(1.0 + 0.004 / 17, abs=0.0002)


def test_cameras_that_are_surer_than_right_are_fused_all_the_same() -> None:
    """Each claims a tenth of a millimetre and they differ by eight: neither may be shut out, or hand-over would break."""
    tracker = Tracker(LAB)
    for number in range(20):
        stamp = number * PERIOD_NS
        tracker.update(seen("left", stamp, detection(SE2(1.000, 0.5, 0.0), sigma_m=0.0001)))
        pose = only(tracker.update(seen("right", stamp, detection(SE2(1.008, 0.5, 0.0), sigma_m=0.0001))))
        assert pose.x == pytest.approx(1.004, abs=0.001)


@given(st.permutations(range(8)), st.integers(0, 2**31))
def test_the_order_of_arrival_does_not_matter(order: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    frames = [
        seen(
            ("left", "right")[index % 2],
            SECOND + index * 20_000_000,
            detection(SE2(1 + 0.01 * index + rng.normal(0, SIGMA_M), 0.5, rng.normal(0, SIGMA_RAD))),
        )
        for index in range(8)
    ]
    base = seen("left", SECOND - 20_000_000, detection(SE2(0.99, 0.5, 0.0)))

    def final(sequence: list[FrameDetections]) -> TrackedPose:
        tracker = Tracker(LAB)
        tracker.update(base)
        for frame in sequence:
            tracker.update(frame)
        pose = tracker.predict("robot-10", SECOND + 7 * 20_000_000)
        assert pose is not None
        return pose

    one, other = final(frames), final([frames[index] for index in order])
    assert (one.x, one.y, one.yaw) == pytest.approx((other.x, other.y, other.yaw), abs=1e-9)
    assert one.covariance == pytest.approx(other.covariance, rel=1e-6, abs=1e-15)


def test_a_late_frame_improves_the_newest_pose_and_does_not_set_it_back() -> None:
    tracker = Tracker(LAB)
    last = standing(tracker)
    before = tracker.predict("robot-10", last)
    late = only(tracker.update(seen("right", last - PERIOD_NS // 2, detection(SE2(1.002, 0.5, 0.0)))))
    assert before is not None
    assert late.stamp_ns == last
    assert late.covariance[0] < before.covariance[0]
    assert late.x > before.x


def test_the_same_frame_twice_counts_once() -> None:
    tracker = Tracker(LAB)
    last = standing(tracker)
    assert tracker.update(seen("left", last, detection(SE2(1.001, 0.5, 0.0)))) == []


def test_an_outlier_is_refused() -> None:
    tracker = Tracker(LAB)
    last = standing(tracker)
    assert tracker.update(seen("left", last + PERIOD_NS, detection(SE2(1.5, 0.9, 2.0)))) == []
    pose = only(tracker.update(seen("left", last + 2 * PERIOD_NS, detection(SE2(1.0, 0.5, 0.0)))))
    assert pose.x == pytest.approx(1.0, abs=0.002)


def test_a_vehicle_that_was_carried_away_is_believed_after_a_few_frames() -> None:
    tracker = Tracker(LAB)
    last = standing(tracker)
    places = [
        tracker.update(seen("left", last + number * PERIOD_NS, detection(SE2(2.5, 0.9, 2.0)))) for number in range(1, 6)
    ]
    assert places[0] == []
    assert only(places[-1]).x == pytest.approx(2.5, abs=0.002)
    assert tracker.take_duplicates() == []


def test_a_track_is_lost_after_half_a_second_and_found_again() -> None:
    tracker = Tracker(LAB)
    last = standing(tracker)
    assert tracker.predict("robot-10", last + SECOND // 2) is not None
    assert tracker.predict("robot-10", last + SECOND // 2 + 1) is None
    pose = only(tracker.update(seen("right", last + 3 * SECOND, detection(SE2(2.5, 0.9, 2.0)))))
    assert (pose.x, pose.vx, pose.cameras) == (pytest.approx(2.5), 0.0, ("right",))


def test_a_clock_that_was_set_back_does_not_end_tracking() -> None:
    tracker = Tracker(LAB)
    tracker.update(seen("left", 100 * SECOND, detection(SE2(1.0, 0.5, 0.0))))
    assert only(tracker.update(seen("left", SECOND, detection(SE2(1.0, 0.5, 0.0))))).stamp_ns == SECOND


def test_two_tags_with_one_id_in_a_frame_are_reported_and_the_known_one_is_followed() -> None:
    tracker = Tracker(LAB)
    last = standing(tracker)
    twins = seen("left", last + PERIOD_NS, detection(SE2(2.0, 0.5, 0.0)), detection(SE2(1.0, 0.5, 0.0)))
    pose = only(tracker.update(twins))
    assert pose.x == pytest.approx(1.0, abs=0.001)
    (report,) = tracker.take_duplicates()
    assert (report.vehicle, report.tag_id, report.camera) == ("robot-10", 10, "left")
    assert sorted(round(x) for x, _ in report.places) == [1, 2]
    assert "two tags with one id?" in str(report)
    assert tracker.take_duplicates() == []


def test_two_tags_with_one_id_and_no_track_give_no_pose() -> None:
    tracker = Tracker(LAB)
    assert tracker.update(seen("left", 0, detection(SE2(1, 0.5, 0)), detection(SE2(2, 0.5, 0)))) == []
    assert len(tracker.take_duplicates()) == 1


def test_two_tags_with_one_id_in_two_cameras_are_reported_and_do_not_alternate() -> None:
    tracker = Tracker(LAB)
    last = standing(tracker)
    for number in range(1, 30):
        stamp = last + number * PERIOD_NS
        tracker.update(seen("left", stamp, detection(SE2(1.0, 0.5, 0.0))))
        assert tracker.update(seen("right", stamp, detection(SE2(2.6, 0.5, 0.0)))) == []
    assert len(tracker.take_duplicates()) == 29
    pose = tracker.predict("robot-10", last + 29 * PERIOD_NS)
    assert pose is not None
    assert pose.x == pytest.approx(1.0, abs=0.001)


def test_what_is_no_vehicle_or_no_number_changes_nothing() -> None:
    tracker = Tracker(LAB)
    good = detection(SE2(1.0, 0.5, 0.0))
    for bad in (
        detection(SE2(1.0, 0.5, 0.0), tag_id=99),
        Detection("tag36h11", 10, SQUARE, 80.0, math.nan, 0.0, 0.0, good.covariance),
        Detection("tag36h11", 10, SQUARE, 80.0, 1.0, 0.5, 0.0, (1.0, 2.0, 0.0, 1.0, 0.0, 1.0)),
        Detection("tag36h11", 10, SQUARE, 80.0, 1.0, 0.5, 0.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
    ):
        assert tracker.update(seen("left", 0, bad)) == []
    assert tracker.predict("robot-10", 0) is None
    with pytest.raises(KeyError):
        tracker.predict("stranger", 0)
