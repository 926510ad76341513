"""The rectangle experiment: its rooms, its driver, its figures, and one short round."""

from pathlib import Path

import pytest

from geometry import SE2
from lab.truth import true_floor_tags
from lab.world import World
from launcher.experiments.corner_course import SEGMENTS_M, CornerDriver, corners
from launcher.experiments.rectangle import HAND_ERROR_M, METHODS, Room, figures, measured_by_hand
from protocol.lab import load_lab

GULLIVER = load_lab(Path("labs/gulliver.yaml"))
ALONE = GULLIVER.model_copy(update={"vehicles": GULLIVER.vehicles[:1]})


def test_the_driver_halts_at_every_corner() -> None:
    world = World(ALONE)
    start = SE2(1.0, 0.9, 0.0)
    world.place("wifibot-14", start)
    driver = CornerDriver(world, "wifibot-14", corners(start))
    stood: dict[int, tuple[float, float]] = {}
    for _ in range(12_000):
        driver.steer()
        world.step()
        if driver.halt is not None:
            pose = world.truth().vehicles["wifibot-14"]
            assert pose.linear_mps == pytest.approx(0.0, abs=2e-3)
            stood[driver.halt] = (pose.x, pose.y)
        if driver.is_done:
            break
    assert driver.is_done
    assert sorted(stood) == [0, 1, 2, 3, 4]
    for corner, (x, y) in enumerate(corners(start)):
        assert stood[corner] == pytest.approx((x, y), abs=0.03)


def test_hand_measured_rooms_are_wrong_by_up_to_five_millimetres_and_know_it() -> None:
    true, described = measured_by_hand(ALONE, 3)
    places = true_floor_tags(true, 3)
    off = [
        abs(difference)
        for tag, (x, y, _) in described.floor_tags.poses.items()
        for difference in (places[tag].x - x, places[tag].y - y)
    ]
    assert 0.8 * HAND_ERROR_M < max(off) <= HAND_ERROR_M
    assert described.accuracy.floor_tag_m == pytest.approx(HAND_ERROR_M / 3**0.5)
    assert measured_by_hand(ALONE, 4)[1].floor_tags != described.floor_tags


def test_figures_are_means_over_runs_and_segments() -> None:
    described = [{"joint": [0.001, 0.002, 0.003, 0.004], "single": [0.0] * 4, "per_tag": [0.01] * 4}] * 2
    by_hand = [{"joint": [0.002] * 4, "single": [0.003] * 4, "per_tag": [0.0, 0.0, 0.0, 0.02]}]
    found = figures(described, by_hand)
    assert found["segment_error_mean_mm"] == pytest.approx(2.5)
    assert found["segment_error_max_mm"] == pytest.approx(4.0)
    assert found["segment_2_error_mean_mm"] == pytest.approx(2.0)
    assert found["run_2_segment_3_error_mm"] == pytest.approx(3.0)
    assert found["segment_error_joint_mean_mm"] == pytest.approx(2.0)
    assert found["segment_error_single_mean_mm"] == pytest.approx(3.0)
    assert found["segment_error_per_tag_mean_mm"] == pytest.approx(5.0)
    assert found["segment_error_per_tag_max_mm"] == pytest.approx(20.0)


def test_a_round_in_a_room_measured_by_hand() -> None:
    slow = ALONE.model_copy(update={"cameras": tuple(c.model_copy(update={"rate_hz": 5.0}) for c in ALONE.cameras)})
    true, described = measured_by_hand(slow, 2)
    errors = Room(true, described, 2).drive(1)
    assert set(errors) == set(METHODS)
    assert all(len(of_method) == len(SEGMENTS_M) for of_method in errors.values())
    assert sum(errors["joint"]) / 4 < 0.005
