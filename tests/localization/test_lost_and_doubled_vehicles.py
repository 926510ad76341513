"""What does not fit a track: outliers, vehicles carried away, lost and found again, ids that two tags have."""

import math

import pytest

from geometry import SE2
from localization.tracking import Tracker
from protocol.messages import Detection
from tests.localization.camera_reports import LAB, PERIOD_NS, SECOND, SQUARE, detection, only, seen, standing


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
