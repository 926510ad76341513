"""Guidance's benchmark drives what it says: everybody but those with a pallet on their way."""

from launcher.paths import DEFAULT_LAB
from protocol.lab import load_lab
from tests.bench.guidance import PALLETS_SHARE, Hall, measure


def test_nearly_all_robots_drive() -> None:
    found = measure(20, 30, seed=3)
    assert 1 - 3 * PALLETS_SHARE < found.driving_share <= 1
    assert len(found.cycle_ms) == 30


def test_a_robot_stays_on_its_loop_within_the_hall() -> None:
    hall = Hall.of(7, seed=1)
    low_x, low_y, high_x, high_y = hall.lab.bounds()
    for name in hall.corners:
        for way_m in (0.0, 2.5, 3.0, 5.0, 9.1, 100.0):
            pose = hall.pose(name, way_m, 0)
            assert low_x < pose.x < high_x
            assert low_y < pose.y < high_y
    assert load_lab(DEFAULT_LAB).vehicle("wifibot-14").limits == hall.lab.vehicles[0].limits
