"""Ways over free floor: they keep their clearance, are as short as they can be, and are found whenever there are any."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from shapely.geometry import LineString, MultiPolygon, Point, Polygon, box

from mapping.grid import FloorGrid
from server.planning import FreeSpace, Needs, ShortestWays, straightened

GROUND = box(0.0, 0.0, 8.0, 4.0)
HALF, CLEARANCE = 0.16, 0.3
OWN = box(0.85, 1.85, 1.15, 2.15)


def grid(
    *obstacles: tuple[float, float, float, float], unseen: tuple[float, float, float, float] | None = None
) -> FloorGrid:
    """Cells are taken that an obstacle (min x, min y, max x, max y) touches."""
    empty = FloorGrid.covering(GROUND.bounds)
    rows, columns = np.indices(empty.occupied.shape)
    x, y = (columns + 0.5) * empty.cell_m, (rows + 0.5) * empty.cell_m
    half = empty.cell_m / 2

    def within(area: tuple[float, float, float, float]) -> NDArray[np.bool_]:
        across, along = (x > area[0] - half) & (x < area[2] + half), (y > area[1] - half) & (y < area[3] + half)
        return np.asarray(across & along, dtype=np.bool_)

    occupied = np.zeros_like(empty.occupied)
    for obstacle in obstacles:
        occupied |= within(obstacle)
    observed = np.ones_like(occupied) if unseen is None else ~within(unseen)
    return empty.with_cells(occupied, observed)


def space(floor: FloorGrid, *, unknown: bool = True, lanes: tuple[Polygon, ...] = ()) -> FreeSpace:
    needs = Needs((1.0, 2.0), HALF, CLEARANCE, OWN, unknown)
    return FreeSpace.around(needs, floor, GROUND, GROUND.bounds, (), lanes)


def way(free: FreeSpace, goal: tuple[float, float]) -> list[tuple[float, float]]:
    return straightened(free, ShortestWays(free, (1.0, 2.0)).way_to(goal))


def length(points: list[tuple[float, float]]) -> float:
    return LineString(points).length


def test_without_obstacles_the_way_is_straight() -> None:
    found = way(space(grid()), (6.0, 2.0))
    assert len(found) == 2
    assert length(found) == pytest.approx(5.0, abs=0.1)


def test_a_way_around_keeps_half_the_robot_and_the_clearance_from_everything() -> None:
    wall = (3.0, 1.4, 3.2, 4.0)
    found = way(space(grid(wall)), (6.0, 2.0))
    assert LineString(found).distance(box(*wall)) >= HALF + CLEARANCE - 0.05
    assert length(found) < 5.6
    assert len(found) < 10


@pytest.mark.parametrize(("gap", "open_"), [(0.98, True), (0.92, True), (0.78, False)])
def test_a_gap_as_wide_as_the_robot_with_its_clearance_is_found_and_a_narrower_one_is_none(
    gap: float, open_: bool
) -> None:
    floor = grid((3.0, 0.0, 3.3, 2.013 - gap / 2), (3.0, 2.013 + gap / 2, 3.3, 4.0))
    assert (way(space(floor), (6.0, 2.0)) != []) is open_


def test_unknown_floor_counts_unless_it_is_not_to() -> None:
    floor = grid(unseen=(3.0, 0.0, 3.5, 4.0))
    assert way(space(floor), (6.0, 2.0)) == []
    assert way(space(floor, unknown=False), (6.0, 2.0)) != []


def test_the_floor_that_the_robot_itself_hides_is_not_unknown() -> None:
    assert way(space(grid(unseen=(0.6, 1.6, 1.4, 2.4))), (6.0, 2.0)) != []


def test_lanes_are_kept_off_but_for_the_robots_own_surroundings() -> None:
    lane = box(0.0, 1.6, 5.0, 2.4)
    found = LineString(way(space(grid(), lanes=(lane,)), (6.0, 2.0)))
    assert found.intersection(lane.difference(Point(1.0, 2.0).buffer(0.8))).length == pytest.approx(0.0, abs=0.06)


def test_a_window_beside_the_grid_is_refused() -> None:
    with pytest.raises(ValueError, match="nothing in common"):
        FreeSpace.around(Needs((1.0, 2.0), HALF, CLEARANCE, OWN), grid(), GROUND, (20.0, 20.0, 30.0, 30.0))


def test_a_large_floor_is_searched_in_coarser_cells() -> None:
    large = FloorGrid.covering((0.0, 0.0, 40.0, 30.0))
    seen = large.with_cells(large.occupied, np.ones_like(large.occupied))
    free = FreeSpace.around(Needs((1.0, 2.0), HALF, CLEARANCE, OWN), seen, box(0, 0, 40, 30), (0.0, 0.0, 40.0, 30.0))
    assert free.shape[0] * free.shape[1] <= 60_000
    assert way(free, (35.0, 25.0)) != []


blocks = st.lists(
    st.tuples(st.floats(1.8, 7.0), st.floats(0.0, 3.6), st.floats(0.1, 1.0), st.floats(0.1, 1.0)), max_size=5
).map(lambda found: [(x, y, min(8.0, x + w), min(4.0, y + h)) for x, y, w, h in found])


@settings(max_examples=40, deadline=None)
@given(obstacles=blocks, goal=st.tuples(st.floats(0.5, 7.5), st.floats(0.5, 3.5)))
def test_every_way_is_allowed_and_one_is_found_wherever_exact_geometry_has_one(
    obstacles: list[tuple[float, float, float, float]], goal: tuple[float, float]
) -> None:
    free = space(grid(*obstacles))
    found = way(free, goal)
    solid = shapely.union_all([box(*obstacle) for obstacle in obstacles]) if obstacles else MultiPolygon()
    if found:
        away = LineString([*found, found[-1]]).distance(solid) if obstacles else math.inf
        assert away >= HALF + CLEARANCE - 0.09  # a cell, and what its centre may be off
        return
    room = GROUND.buffer(-HALF - 0.05).difference(solid.buffer(HALF + CLEARANCE + 0.02))
    joined = [part for part in shapely.get_parts(room) if part.distance(Point(1.0, 2.0)) < 0.01]
    assert not any(part.buffer(-0.03).covers(Point(goal)) for part in joined)
