"""The score of the tracking experiment, on made-up errors whose figures are known."""

import math

import pytest

from launcher.experiments.tracking_score import TrackingScore
from protocol.messages import TrackedPose, TruePose


def tracked(x: float, y: float = 0.0, yaw: float = 0.0, cameras: tuple[str, ...] = ("cam0",)) -> TrackedPose:
    return TrackedPose("car", 0, x, y, yaw, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), cameras)


TRUTH = TruePose(0.0, 0.0, 0.0, 0.0, 0.0)


def test_errors_are_summed_up_with_their_units() -> None:
    score = TrackingScore()
    for millimetres in range(1, 101):
        score.pose(tracked(millimetres / 1000, yaw=math.radians(-0.5)), TRUTH)
    score.tags(visible=[1, 2], found=[1])
    figures = score.figures()
    assert figures["position_error_median_mm"] == pytest.approx(50.5)
    assert figures["position_error_p99_mm"] == pytest.approx(99.01)
    assert figures["heading_error_median_deg"] == pytest.approx(0.5)
    assert figures["pose_share"] == 0.5


def test_a_jump_counts_only_when_the_cameras_change_and_is_that_of_the_error() -> None:
    score = TrackingScore()
    score.tags(visible=[1], found=[1])
    score.pose(tracked(0.001), TRUTH)
    score.pose(tracked(0.050), TRUTH)  # same camera: noise, not a hand-over
    assert score.figures()["handover_jump_max_mm"] == 0.0
    score.pose(tracked(1.056, cameras=("cam0", "cam1")), TruePose(1.0, 0.0, 0.0, 0.0, 0.0))
    figures = score.figures()
    assert figures["handovers"] == 1
    assert figures["handover_jump_max_mm"] == pytest.approx(6.0)


def test_a_tag_found_where_none_was_visible_does_not_raise_the_share() -> None:
    score = TrackingScore()
    score.pose(tracked(0.0), TRUTH)
    score.tags(visible=[1, 2], found=[1, 3, 3])
    assert score.figures()["pose_share"] == 0.5
    assert score.figures()["duplicate_detections"] == 1


def test_nothing_tracked_is_no_result() -> None:
    with pytest.raises(ValueError, match="no pose"):
        TrackingScore().figures()
