"""Vehicles are followed with their velocities, and what several cameras say of them is fused in any order."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import SE2
from localization.tracking import Tracker
from protocol.messages import FrameDetections, TrackedPose
from tests.localization.camera_reports import (
    LAB,
    PERIOD_NS,
    SECOND,
    SIGMA_M,
    SIGMA_RAD,
    detection,
    only,
    seen,
    standing,
)


def circle(t: float) -> SE2:
    """0.5 m/s on a circle of 0.8 m radius."""
    turn = 0.5 / 0.8
    return SE2(1.0 + 0.8 * math.sin(turn * t), 0.5 - 0.8 * math.cos(turn * t), turn * t)


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


def test_pose_is_that_of_the_rotation_centre_in_its_area() -> None:
    pose = only(Tracker(LAB).update(seen("left", 0, detection(SE2(1.0, 0.5, 0.7)))))
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.0, 0.5, 0.7))
    assert (pose.vehicle, pose.area, pose.cameras) == ("robot-10", "room", ("left",))
    outside = only(Tracker(LAB).update(seen("left", 0, detection(SE2(9.0, 9.0, 0.7)))))
    assert outside.area is None


def test_cameras_that_take_turns_make_no_saw_teeth() -> None:
    """They differ by 4 mm, four times their sigma."""
    tracker, places = Tracker(LAB), list[float]()
    for number in range(120):
        camera, x = (("left", 1.000), ("right", 1.004))[number % 2]
        frame = seen(camera, number * SECOND // 120, detection(SE2(x, 0.5, 0.0), sigma_m=0.00102, systematic_m=0.001))
        places.append(only(tracker.update(frame)).x)
    assert max(abs(b - a) for a, b in pairwise(places[20:])) < 0.00002
    assert places[-1] == pytest.approx(1.002, abs=0.0002)


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
