"""People walk, pallets lie, nobody passes through anybody, and the infrared sensor sees what is ahead."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry import SE2
from lab.objects import PALLET_LENGTH_M
from lab.ranging import RANGE_MAX_M, RANGE_MIN_M
from lab.world import World
from protocol.messages import SimulatedObject
from tests.lab.rooms import PERFECT, gulliver

WIFIBOT, OTHER = "wifibot-14", "wifibot-15"
NOSE_M = 0.15


def empty_floor() -> World:
    """The first wifibot at (1, 1) looking along x, everybody else far from its way."""
    world = World(gulliver(drive=PERFECT))
    world.place(WIFIBOT, SE2(1.0, 1.0, 0.0))
    world.place(OTHER, SE2(1.0, 4.0, 0.0))
    world.place("turtlebot-16", SE2(8.0, 4.0, 0.0))
    world.place("turtlebot-17", SE2(8.0, 3.0, 0.0))
    return world


def drive(world: World, seconds: float, linear_mps: float, vehicle: str = WIFIBOT) -> None:
    for _ in range(round(seconds / 0.1)):
        world.set_drive(vehicle, linear_mps, 0.0)
        world.run(0.1)


def object_at(world: World, object_id: str) -> tuple[float, float]:
    found = next(item for item in world.snapshot().objects if item.id == object_id)
    return found.x, found.y


def test_a_vehicle_stops_at_a_pallet_and_the_touch_counts_once() -> None:
    world = empty_floor()
    world.put(SimulatedObject(id="pallet", kind="pallet", x=2.5, y=1.0))
    drive(world, 6.0, 0.5)
    truth = world.truth()
    gap = 2.5 - PALLET_LENGTH_M / 2 - NOSE_M - truth.vehicles[WIFIBOT].x
    assert 0.0 <= gap < 0.01
    assert truth.vehicles[WIFIBOT].linear_mps == 0.0
    assert truth.contacts == 1
    drive(world, 1.0, -0.3)
    assert world.truth().vehicles[WIFIBOT].x < truth.vehicles[WIFIBOT].x - 0.1, "it can back away"
    drive(world, 3.0, 0.3)
    assert world.truth().contacts == 2, "a second touch"


def test_a_removed_pallet_frees_the_way() -> None:
    world = empty_floor()
    world.put(SimulatedObject(id="pallet", kind="pallet", x=2.0, y=1.0))
    drive(world, 3.0, 0.5)
    assert world.truth().vehicles[WIFIBOT].x < 1.7
    assert world.remove("pallet")
    assert not world.remove("pallet")
    drive(world, 3.0, 0.5)
    assert world.truth().vehicles[WIFIBOT].x > 2.5


def test_vehicles_do_not_pass_through_each_other() -> None:
    world = empty_floor()
    world.place(OTHER, SE2(3.0, 1.0, math.pi))
    for _ in range(50):
        world.set_drive(WIFIBOT, 0.5, 0.0)
        world.set_drive(OTHER, 0.5, 0.0)
        world.run(0.1)
    truth = world.truth()
    assert 2 * NOSE_M <= truth.vehicles[OTHER].x - truth.vehicles[WIFIBOT].x < 2 * NOSE_M + 0.02
    assert truth.contacts == 1


def test_something_put_onto_a_vehicle_counts_and_does_not_trap_it() -> None:
    world = empty_floor()
    world.put(SimulatedObject(id="pallet", kind="pallet", x=1.3, y=1.0))
    assert world.truth().contacts == 1
    drive(world, 3.0, -0.3)
    assert world.truth().vehicles[WIFIBOT].x < 0.7
    assert world.truth().contacts == 1


def test_a_person_waits_for_a_vehicle_in_the_way() -> None:
    world = empty_floor()
    world.put(SimulatedObject(id="ann", kind="person", x=2.5, y=1.0, path=((0.0, 1.0),), speed_mps=1.0))
    world.run(4.0)
    assert object_at(world, "ann")[0] == pytest.approx(1.0 + NOSE_M + 0.22, abs=0.02)
    assert world.truth().contacts == 1
    world.place(WIFIBOT, SE2(1.0, 3.0, 0.0))
    world.run(1.0)
    assert object_at(world, "ann")[0] < 0.5


def test_a_person_walks_back_and_forth() -> None:
    world = empty_floor()
    world.put(SimulatedObject(id="bo", kind="person", x=3.0, y=3.0, path=((4.0, 3.0), (4.0, 4.0)), speed_mps=1.0))
    places: list[tuple[float, float]] = []
    for _ in range(5):
        world.run(1.0)
        places.append(object_at(world, "bo"))
    assert np.array(places) == pytest.approx(np.array([(4, 3), (4, 4), (4, 3), (3, 3), (4, 3)]), abs=0.02)


@settings(max_examples=20)
@given(
    st.lists(st.tuples(st.integers(20, 70), st.integers(10, 40)), max_size=5),
    st.floats(0.0, 3.0),
    st.floats(0.1, 2.0),
)
def test_a_walker_is_always_on_its_path(points: list[tuple[int, int]], speed_mps: float, seconds: float) -> None:
    path = tuple((x / 10, y / 10) for x, y in points)
    world = World(gulliver().model_copy(update={"vehicles": ()}))
    world.put(SimulatedObject(id="cy", kind="person", x=3.0, y=2.0, path=path, speed_mps=speed_mps))
    for _ in range(4):
        world.run(seconds)
        x, y = object_at(world, "cy")
        corners = [(3.0, 2.0), *path]
        legs = zip(corners, corners[1:] or corners, strict=False)
        assert min(_distance((x, y), a, b) for a, b in legs) < 1e-6


def test_the_same_id_again_replaces() -> None:
    world = empty_floor()
    world.put(SimulatedObject(id="thing", kind="pallet", x=3.0, y=1.0))
    world.put(SimulatedObject(id="thing", kind="person", x=5.0, y=2.0))
    assert world.object_ids == ("thing",)
    assert object_at(world, "thing") == (5.0, 2.0)


def test_the_range_sensor_measures_from_the_nose() -> None:
    world = empty_floor()
    assert world.odometry(WIFIBOT).range_front_m is None
    for distance in (1.4, 0.8, 0.3):
        world.put(SimulatedObject(id="pallet", kind="pallet", x=1.0 + NOSE_M + distance + PALLET_LENGTH_M / 2, y=1.0))
        world.step()
        assert world.odometry(WIFIBOT).range_front_m == pytest.approx(distance, rel=0.06)


def test_the_range_sensor_knows_its_limits() -> None:
    world = empty_floor()
    world.place(OTHER, SE2(1.0 + NOSE_M + 0.05 + NOSE_M, 1.0, 0.0))
    assert world.odometry(WIFIBOT).range_front_m == RANGE_MIN_M
    world.place(OTHER, SE2(1.0 + NOSE_M + RANGE_MAX_M + 0.1 + NOSE_M, 1.0, 0.0))
    assert world.odometry(WIFIBOT).range_front_m is None
    world.place(OTHER, SE2(1.0, 2.0, 0.0))
    assert world.odometry(WIFIBOT).range_front_m is None, "beside, not ahead"


def _distance(point: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    way = (b[0] - a[0], b[1] - a[1])
    squared = way[0] ** 2 + way[1] ** 2
    along = 0.0 if squared == 0 else ((point[0] - a[0]) * way[0] + (point[1] - a[1]) * way[1]) / squared
    along = min(1.0, max(0.0, along))
    return math.dist(point, (a[0] + along * way[0], a[1] + along * way[1]))
