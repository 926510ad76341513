"""Merging the cameras' rasters: safe before tidy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from msgspec.structs import replace
from numpy.typing import NDArray

from mapping.fusion import TTL_S, ObstacleMap
from mapping.grid import FloorGrid
from protocol.errors import DecodeError
from protocol.messages import FloorRaster

Cells = NDArray[np.bool_]
S = 1_000_000_000
AREA = FloorGrid.covering((0.0, 0.0, 4.0, 2.0))
SHAPE = AREA.occupied.shape


def everywhere() -> Cells:
    return np.ones(SHAPE, np.bool_)


def block(x0: float, y0: float, x1: float, y1: float) -> Cells:
    """The cells of a rectangle in metres."""
    cells = np.zeros(SHAPE, np.bool_)
    cells[round(y0 / 0.05) : round(y1 / 0.05), round(x0 / 0.05) : round(x1 / 0.05)] = True
    return cells


def raster(camera: str, occupied: Cells, observed: Cells | None = None, stamp_ns: int = 10 * S) -> FloorRaster:
    return AREA.with_cells(occupied, everywhere() if observed is None else observed).to_raster(camera, stamp_ns)


def two_cameras() -> ObstacleMap:
    """cam0 hangs over (1, 1), cam1 over (3, 1)."""
    obstacles = ObstacleMap(AREA, ["cam0", "cam1"])
    obstacles.place_camera("cam0", 1.0, 1.0)
    obstacles.place_camera("cam1", 3.0, 1.0)
    return obstacles


def test_nothing_is_observed_before_a_camera_says_so() -> None:
    grid = two_cameras().merged(10 * S)
    assert not grid.observed.any()
    assert not grid.occupied.any()


def test_cameras_complete_each_other() -> None:
    obstacles = two_cameras()
    left, right = block(0, 0, 2, 2), block(2, 0, 4, 2)
    obstacles.add(raster("cam0", block(0.5, 0.5, 0.7, 0.7), left))
    obstacles.add(raster("cam1", block(3.5, 0.5, 3.7, 0.7), right))
    grid = obstacles.merged(10 * S)
    assert grid.observed.all()
    assert np.array_equal(grid.occupied, block(0.5, 0.5, 0.7, 0.7) | block(3.5, 0.5, 3.7, 0.7))


def test_rasters_smaller_than_the_lab_are_put_in_their_place() -> None:
    obstacles = two_cameras()
    small = FloorGrid.empty(2.5, 1.0, 0.05, columns=10, rows=5)
    occupied = np.zeros((5, 10), np.bool_)
    occupied[2, 3] = True
    obstacles.add(small.with_cells(occupied, np.ones((5, 10), np.bool_)).to_raster("cam0", 10 * S))
    grid = obstacles.merged(10 * S)
    assert grid.occupied_centres() == pytest.approx(np.array([[2.675, 1.125]]))
    assert np.count_nonzero(grid.observed) == 50


def test_a_silent_camera_no_longer_observes_and_its_obstacles_stay_until_somebody_looks() -> None:
    obstacles = two_cameras()
    pallet = block(1.9, 0.5, 2.1, 0.7)
    obstacles.add(raster("cam0", pallet, block(0, 0, 2.2, 2)))
    obstacles.add(raster("cam1", np.zeros(SHAPE, np.bool_), block(2.2, 0, 4, 2)))
    later = 10 * S + round(TTL_S * 1e9)
    assert obstacles.living(later) == ("cam0", "cam1")
    obstacles.add(raster("cam1", np.zeros(SHAPE, np.bool_), block(2.2, 0, 4, 2), later + 1))
    grid = obstacles.merged(later + 1)
    assert obstacles.living(later + 1) == ("cam1",)
    assert np.array_equal(grid.observed, block(2.2, 0, 4, 2))
    assert np.array_equal(grid.occupied, pallet)
    # The neighbour looks and sees half of the place free.
    obstacles.add(raster("cam1", np.zeros(SHAPE, np.bool_), block(2.0, 0, 4, 2), later + 2))
    assert np.array_equal(obstacles.merged(later + 2).occupied, block(1.9, 0.5, 2.0, 0.7))
    # It looks away again: what was seen free does not come back.
    obstacles.add(raster("cam1", np.zeros(SHAPE, np.bool_), block(2.2, 0, 4, 2), later + 3))
    assert np.array_equal(obstacles.merged(later + 3).occupied, block(1.9, 0.5, 2.0, 0.7))
    # The camera comes back and sees the floor.
    obstacles.add(raster("cam0", np.zeros(SHAPE, np.bool_), block(0, 0, 2.2, 2), later + 4))
    grid = obstacles.merged(later + 4)
    assert not grid.occupied.any()
    assert grid.observed.all()


def test_the_smear_of_something_tall_is_taken_back_where_another_camera_sees_the_floor() -> None:
    obstacles = two_cameras()
    foot, smear = block(1.8, 0.9, 2.0, 1.1), block(2.0, 0.9, 2.8, 1.1)
    obstacles.add(raster("cam0", foot | smear))
    obstacles.add(raster("cam1", foot | block(1.2, 0.9, 1.8, 1.1)))
    grid = obstacles.merged(10 * S)
    assert (grid.occupied & foot).sum() == foot.sum()
    # Of both smears only what is near to the confirmed foot remains.
    low, high = grid.occupied_centres().min(axis=0), grid.occupied_centres().max(axis=0)
    assert low[0] > 1.8 - 0.25
    assert high[0] < 2.0 + 0.25


def test_what_another_camera_is_blind_to_stays_whole() -> None:
    obstacles = two_cameras()
    pallet = block(1.6, 0.8, 2.4, 1.2)
    obstacles.add(raster("cam0", pallet))
    obstacles.add(raster("cam1", np.zeros(SHAPE, np.bool_)))
    assert np.array_equal(obstacles.merged(10 * S).occupied, pallet)


def test_what_stands_beside_a_confirmed_thing_stays() -> None:
    """Only what lies behind a confirmed part, seen from the camera, can be its smear."""
    obstacles = two_cameras()
    foot, beside = block(1.8, 0.9, 2.0, 1.1), block(1.8, 1.1, 2.0, 1.8)
    obstacles.add(raster("cam0", foot | beside))
    obstacles.add(raster("cam1", foot))
    assert np.array_equal(obstacles.merged(10 * S).occupied, foot | beside)


def test_without_knowing_where_a_camera_hangs_nothing_is_taken_back() -> None:
    obstacles = ObstacleMap(AREA, ["cam0", "cam1"])
    wide = block(1.8, 0.9, 2.8, 1.1)
    obstacles.add(raster("cam0", wide))
    obstacles.add(raster("cam1", block(1.8, 0.9, 2.0, 1.1)))
    assert np.array_equal(obstacles.merged(10 * S).occupied, wide)


cells = hnp.arrays(np.bool_, SHAPE, elements=st.booleans(), fill=st.just(False))


@given(cells, cells, cells, cells)
def test_what_both_cameras_see_never_vanishes_and_nothing_is_invented(a: Cells, b: Cells, c: Cells, d: Cells) -> None:
    obstacles = two_cameras()
    obstacles.add(raster("cam0", a & c, c))
    obstacles.add(raster("cam1", b & d, d))
    grid = obstacles.merged(10 * S)
    assert not ((a & c) & (b & d) & ~grid.occupied).any()
    assert not (grid.occupied & ~((a & c) | (b & d))).any()
    assert np.array_equal(grid.observed, c | d)
    # What only one camera observes cannot be doubted by the other.
    assert not ((a & c) & ~d & ~grid.occupied).any()


def test_an_older_raster_changes_nothing() -> None:
    obstacles = two_cameras()
    assert obstacles.add(raster("cam0", block(1, 1, 2, 2), stamp_ns=10 * S))
    assert not obstacles.add(raster("cam0", np.zeros(SHAPE, np.bool_), stamp_ns=10 * S - 1))
    assert obstacles.merged(10 * S).occupied.any()


def test_a_camera_whose_clock_is_ahead_observes_nothing() -> None:
    obstacles = two_cameras()
    obstacles.add(raster("cam0", block(1, 1, 2, 2), stamp_ns=12 * S))
    grid = obstacles.merged(10 * S)
    assert not grid.observed.any()
    assert np.array_equal(grid.occupied, block(1, 1, 2, 2))


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (raster("cam7", everywhere()), "'cam7'.*no camera"),
        (replace(raster("cam0", everywhere()), occupied=b""), "'cam0'.*occupied has 0 bytes"),
        (replace(raster("cam0", everywhere()), origin_x=0.02), "'cam0'.*share"),
        (replace(raster("cam0", everywhere()), cell_m=0.1), "'cam0'.*0.1 m"),
        (replace(raster("cam0", everywhere()), origin_x=1.0), "'cam0'.*within"),
    ],
)
def test_a_raster_that_cannot_be_is_refused_and_changes_nothing(bad: FloorRaster, words: str) -> None:
    obstacles = two_cameras()
    obstacles.add(raster("cam0", np.zeros(SHAPE, np.bool_)))
    with pytest.raises((DecodeError, ValueError), match=words):
        obstacles.add(bad)
    grid = obstacles.merged(10 * S)
    assert not grid.occupied.any()
    assert grid.observed.all()
