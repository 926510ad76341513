"""Tracks: motion model, fusion in any order, gates, loss and recovery, doubled ids."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from geometry import SE2
from localization.tracking import Tracker
from localization.tracking.filter import correct, innovation, predict, start
from localization.tracking.motion import Agility, move
from localization.tracking.sight import Sight, cholesky
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


def detection(vehicle: SE2, tag_id: int = 10, sigma_m: float = SIGMA_M, systematic_m: float = 0.0) -> Detection:
    """What a camera says of a vehicle whose rotation centre is there; `systematic_m` of its doubt is the calibration's."""
    worn = next(v.tag for v in LAB.vehicles if v.tag.id == tag_id) if tag_id in (10, 11) else VEHICLE.tag
    tag = vehicle @ worn.pose_on_vehicle()
    covariance = (sigma_m**2, 0.0, 0.0, sigma_m**2, 0.0, SIGMA_RAD**2)
    systematic = (systematic_m**2, 0.0, 0.0, systematic_m**2, 0.0, 0.0)
    return Detection("tag36h11", tag_id, SQUARE, 80.0, tag.x, tag.y, tag.yaw, covariance, systematic)


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


def sight(pose: SE2, noise_m: float, bias_m: float = 0.0, camera: str = "left", stamp_ns: int = 0) -> Sight:
    at = np.array([pose.x, pose.y, pose.yaw])
    return Sight(camera, stamp_ns, at, np.diag(np.square([noise_m, noise_m, noise_m])), bias_m * np.eye(3))


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


def test_cameras_that_take_turns_make_no_saw_teeth() -> None:
    """They differ by 4 mm, four times their sigma."""
    tracker, places = Tracker(LAB), list[float]()
    for number in range(120):
        camera, x = (("left", 1.000), ("right", 1.004))[number % 2]
        frame = seen(camera, number * SECOND // 120, detection(SE2(x, 0.5, 0.0), sigma_m=0.00102, systematic_m=0.001))
        places.append(only(tracker.update(frame)).x)
    assert max(abs(b - a) for a, b in pairwise(places[20:])) < 0.00002
    assert places[-1] == pytest.approx(1.002, abs=0.0002)


def test_a_vehicle_on_a_circle_is_followed_with_its_velocities() -> None:
    tracker = Tracker(LAB)
    rng = np.random.default_rng(4)
    errors, inwards = list[float](), list[float]()
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
            inwards.append(pose.ay * math.cos(truth.yaw) - pose.ax * math.sin(truth.yaw))
    assert float(np.median(errors)) < 1.5 * SIGMA_M
    assert float(np.mean(inwards)) == pytest.approx(0.5 * 0.625, abs=0.02)
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


def test_acceleration_is_that_of_a_vehicle_that_pulls_away() -> None:
    tracker, given = Tracker(LAB), 0.8
    rng = np.random.default_rng(5)
    seen_ax: list[float] = []
    for number in range(60):
        t = number / 60
        pose = SE2(1.0 + rng.normal(0, 1e-4), 0.5 + given * t * t / 2 + rng.normal(0, 1e-4), math.pi / 2)
        tracked = only(tracker.update(seen("left", round(t * SECOND), detection(pose, sigma_m=1e-4))))
        seen_ax.append(tracked.ay)
        if number > 30:
            assert tracked.vy == pytest.approx(given * t, abs=0.02)
            assert abs(tracked.ax) < 0.2
    assert float(np.mean(seen_ax[30:])) == pytest.approx(given, abs=0.08)


def test_lost_and_found_vehicles_are_told_once() -> None:
    tracker = Tracker(LAB)
    last = standing(tracker)
    (found,) = tracker.take_transitions()
    assert (found.vehicle, found.tracked, found.stamp_ns) == ("robot-10", True, 0)
    assert found.place == pytest.approx((1.0, 0.5))
    assert str(found) == "robot-10 is tracked at (1.00, 0.50)"
    tracker.expire(last + SECOND // 2)
    assert tracker.take_transitions() == []
    for _ in range(2):
        tracker.expire(last + SECOND)
    (lost,) = tracker.take_transitions()
    assert (lost.vehicle, lost.tracked, lost.stamp_ns) == ("robot-10", False, last)
    assert str(lost) == "robot-10 is lost, last seen at (1.00, 0.50)"
    tracker.update(seen("right", last + 3 * SECOND, detection(SE2(2.5, 0.9, 2.0))))
    (again,) = tracker.take_transitions()
    assert again.tracked
    assert again.place == pytest.approx((2.5, 0.9))


def test_a_vehicle_that_comes_back_before_anybody_asked_was_lost_and_found() -> None:
    tracker = Tracker(LAB)
    last = standing(tracker)
    tracker.take_transitions()
    tracker.update(seen("right", last + 3 * SECOND, detection(SE2(2.5, 0.9, 2.0))))
    assert [(each.tracked, each.stamp_ns) for each in tracker.take_transitions()] == [
        (False, last),
        (True, last + 3 * SECOND),
    ]


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
        Detection("tag36h11", 10, SQUARE, 80.0, 1.0, 0.5, 0.0, good.covariance, (math.inf, 0.0, 0.0, 0.0, 0.0, 0.0)),
        detection(SE2(1.0, 0.5, 0.0), sigma_m=0.001, systematic_m=0.002),
    ):
        assert tracker.update(seen("left", 0, bad)) == []
    assert tracker.predict("robot-10", 0) is None
    with pytest.raises(KeyError):
        tracker.predict("stranger", 0)
