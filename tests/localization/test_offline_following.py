"""Tracks over recordings: what jumps is followed, what may be another tag with the same id is not."""

import math

import pytest

from localization.offline.following import Following
from protocol.lab import Lab, parse_lab
from protocol.messages import Detection, FrameDetections
from tests.localization.synthetic import SMALL_LAB

TURN_NS = 300_000_000
PERIOD_NS = 200_000_000
SURE = (1e-7, 0.0, 0.0, 1e-7, 0.0, 1e-6)


@pytest.fixture
def lab() -> Lab:
    return parse_lab(SMALL_LAB)


def frame(camera: str, stamp_ns: int, *places: tuple[float, float], tag: int = 11) -> FrameDetections:
    corners = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    detections = tuple(Detection("tag36h11", tag, corners, 80.0, x, y, 0.0, SURE) for x, y in places)
    return FrameDetections(camera, stamp_ns, stamp_ns, 0, True, detections, {})


def test_a_vehicle_that_is_somewhere_else_in_every_frame_has_a_pose_in_every_frame(lab: Lab) -> None:
    following = Following(lab, TURN_NS)
    for number in range(12):
        x, y = 1.5 + 1.4 * math.sin(7.0 * number), 0.5 + 0.6 * math.cos(5.0 * number)
        (pose,) = following.update(frame("left", number * PERIOD_NS, (x, y)))
        assert pose.stamp_ns == number * PERIOD_NS
        assert math.dist((pose.x, pose.y), (x, y)) < 0.001
    assert following.begun_anew["robot-11"] >= 8
    assert following.newest["robot-11"].stamp_ns == 11 * PERIOD_NS


def test_the_same_id_before_another_camera_does_not_take_the_track_over(lab: Lab) -> None:
    following = Following(lab, TURN_NS)
    for number in range(10):
        (pose,) = following.update(frame("left", number * PERIOD_NS, (0.5, 0.5)))
        assert (pose.x, pose.y) == pytest.approx((0.5, 0.5), abs=1e-3)
        assert following.update(frame("right", number * PERIOD_NS + PERIOD_NS // 2, (2.5, 0.5))) == []
    assert not following.begun_anew


def test_two_tags_in_one_frame_are_reported_and_the_one_on_the_track_is_followed(lab: Lab) -> None:
    following = Following(lab, TURN_NS)
    following.update(frame("left", 0, (0.5, 0.5)))
    (pose,) = following.update(frame("left", PERIOD_NS, (1.5, 0.5), (0.501, 0.5)))
    assert pose.x == pytest.approx(0.501, abs=0.002)
    assert [(d.vehicle, d.camera) for d in following.take_duplicates()] == [("robot-11", "left")]
    assert following.take_duplicates() == []


def test_a_vehicle_carried_into_another_view_is_found_there_after_a_turn(lab: Lab) -> None:
    following = Following(lab, TURN_NS)
    following.update(frame("left", 0, (0.5, 0.5)))
    assert following.update(frame("right", PERIOD_NS, (2.5, 0.5))) == []
    (pose,) = following.update(frame("right", 2 * PERIOD_NS, (2.5, 0.5)))
    assert pose.x == pytest.approx(2.5, abs=1e-3)
    assert pose.cameras == ("right",)


def test_vehicles_do_not_share_tracks(lab: Lab) -> None:
    following = Following(lab, TURN_NS)
    both = frame("left", 0, (0.5, 0.5)).detections + frame("left", 0, (1.5, 0.5), tag=10).detections
    poses = following.update(FrameDetections("left", 0, 0, 0, True, both, {}))
    assert {pose.vehicle for pose in poses} == {"robot-10", "robot-11"}
