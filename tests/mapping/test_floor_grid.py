"""The floor grid: messages, placement, merging, polygons."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from msgspec.structs import replace
from numpy.typing import NDArray
from shapely.geometry import MultiPoint, Point, Polygon

from mapping.grid import FloorGrid
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages import FloorRaster

Cells = NDArray[np.bool_]
shapes = st.tuples(st.integers(1, 30), st.integers(1, 30))
cells = shapes.flatmap(lambda shape: st.tuples(*(hnp.arrays(np.bool_, shape),) * 2))


def grid_of(contents: tuple[Cells, Cells], row: int = 0, column: int = 0, cell_m: float = 0.05) -> FloorGrid:
    return FloorGrid(column * cell_m, row * cell_m, cell_m, *contents)


@given(cells, st.integers(-50, 50), st.integers(-50, 50))
def test_a_grid_survives_the_wire(contents: tuple[Cells, Cells], row: int, column: int) -> None:
    grid = grid_of(contents, row, column)
    back = FloorGrid.from_raster(decode(FloorRaster, encode(grid.to_raster("cam0", 7))))
    assert np.array_equal(back.occupied, grid.occupied)
    assert np.array_equal(back.observed, grid.observed)
    assert back.bounds == grid.bounds


def test_bits_are_row_major_with_the_first_cell_first() -> None:
    occupied = np.zeros((2, 5), np.bool_)
    occupied[0, 0] = occupied[1, 4] = True
    raster = FloorGrid(0.0, 0.0, 0.05, occupied, ~occupied).to_raster("cam0", 1)
    assert raster.occupied == bytes([0b10000000, 0b01000000])
    assert raster.observed == bytes([0b01111111, 0b10000000])


RASTER = FloorGrid.empty(0.0, 0.0, 0.05, columns=5, rows=2).to_raster("cam3", 1)


@pytest.mark.parametrize(
    ("raster", "words"),
    [
        (replace(RASTER, occupied=b"\0"), "occupied has 1 bytes, 5 x 2 cells need 2"),
        (replace(RASTER, observed=b"\0\0\0"), "observed has 3 bytes"),
        (replace(RASTER, columns=0), "0 columns"),
        (replace(RASTER, rows=-2), "-2 rows"),
        (replace(RASTER, columns=10**9, rows=10**9), "1000000000 columns"),
        (replace(RASTER, cell_m=0.0), "cells of 0.0 m"),
        (replace(RASTER, cell_m=math.nan), "cells of nan m"),
        (replace(RASTER, origin_x=math.inf), "origin"),
    ],
)
def test_a_raster_that_contradicts_itself_is_refused(raster: FloorRaster, words: str) -> None:
    with pytest.raises(DecodeError, match="cam3") as caught:
        FloorGrid.from_raster(raster)
    assert words in str(caught.value)


@given(
    st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(0, 10), st.floats(0, 10)),
    st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(0, 10), st.floats(0, 10)),
)
def test_grids_over_any_bounds_cover_them_and_share_cells(
    a: tuple[float, float, float, float], b: tuple[float, float, float, float]
) -> None:
    first, second = (FloorGrid.covering((x, y, x + width, y + height)) for x, y, width, height in (a, b))
    low_x, low_y, high_x, high_y = first.bounds
    assert low_x <= a[0] + 1e-9
    assert low_y <= a[1] + 1e-9
    assert high_x >= a[0] + a[2] - 1e-9
    assert high_y >= a[1] + a[3] - 1e-9
    assert high_x - low_x <= a[2] + 0.1 + 1e-9
    first.merged(second)


@given(cells, cells, st.integers(-40, 40), st.integers(-40, 40))
def test_merging_keeps_what_lies_in_the_window(
    a: tuple[Cells, Cells], b: tuple[Cells, Cells], row: int, column: int
) -> None:
    first, second = grid_of(a), grid_of(b, row, column)
    merged = first.merged(second)
    low_x, low_y, high_x, high_y = first.bounds
    centres = second.occupied_centres()
    within = (centres[:, 0] > low_x) & (centres[:, 0] < high_x) & (centres[:, 1] > low_y) & (centres[:, 1] < high_y)
    expected = {tuple(np.round(c, 6)) for c in (*first.occupied_centres(), *centres[within])}
    assert {tuple(np.round(c, 6)) for c in merged.occupied_centres()} == expected
    assert not (first.observed & ~merged.observed).any()


@pytest.mark.parametrize(
    "other", [FloorGrid.empty(0.02, 0.0, 0.05, columns=3, rows=3), FloorGrid.empty(0.0, 0.0, 0.1, columns=3, rows=3)]
)
def test_grids_that_do_not_share_cells_are_not_merged(other: FloorGrid) -> None:
    with pytest.raises(ValueError, match="cells"):
        FloorGrid.empty(0.0, 0.0, 0.05, columns=3, rows=3).merged(other)


def test_contents_cannot_be_changed_from_outside() -> None:
    occupied = np.zeros((2, 2), np.bool_)
    grid = FloorGrid(0.0, 0.0, 0.05, occupied, occupied)
    occupied[0, 0] = True
    assert not grid.occupied.any()
    with pytest.raises(ValueError, match="read-only"):
        grid.occupied[0, 0] = True


points = st.tuples(st.floats(-1.0, 2.5), st.floats(-1.0, 2.5))


@given(st.lists(points, min_size=3, max_size=9), hnp.arrays(np.bool_, (24, 31)), hnp.arrays(np.bool_, (24, 31)))
def test_a_convex_polygon_contains_the_cells_that_geometry_says(
    corners: list[tuple[float, float]], occupied: Cells, observed: Cells
) -> None:
    hull = MultiPoint(corners).convex_hull
    if not isinstance(hull, Polygon) or hull.area < 0.01:
        return
    grid = FloorGrid(0.0, 0.0, 0.05, occupied, observed)
    content = grid.look(list(hull.exterior.coords)[:-1])
    found = {tuple(np.round(c, 6)) for c in content.occupied}
    for centre in grid.occupied_centres():
        distance = hull.exterior.distance(Point(centre))
        if distance > 1e-6:
            assert (tuple(np.round(centre, 6)) in found) == hull.contains(Point(centre))
    assert 0.0 <= content.observed_share <= 1.0
    assert content.blocked == bool(found)


def test_the_observed_share_counts_what_lies_outside_the_grid() -> None:
    seen = np.ones((20, 20), np.bool_)
    grid = FloorGrid(0.0, 0.0, 0.05, ~seen, seen)
    assert grid.look([(0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8)]).observed_share == 1.0
    half_outside = grid.look([(0.5, 0.0), (1.5, 0.0), (1.5, 1.0), (0.5, 1.0)])
    assert half_outside.observed_share == pytest.approx(0.5)
    assert grid.look([(3.0, 3.0), (4.0, 3.0), (4.0, 4.0)]).observed_share == 0.0


def test_a_polygon_that_crosses_itself_has_no_holes() -> None:
    everything = np.ones((40, 40), np.bool_)
    grid = FloorGrid(0.0, 0.0, 0.05, everything, everything)
    # A ribbon that laps over itself: twice around the same square.
    square = [(0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5)]
    assert len(grid.look(square * 2).occupied) == len(grid.look(square).occupied) == 400


@pytest.mark.parametrize(
    "polygon", [[], [(0, 0), (1, 1)], [(0, 0), (1, 0), (math.nan, 1)], [(0, 0), (1, 0), (math.inf, 1)], [0, 1, 2]]
)
def test_what_is_no_polygon_is_refused(polygon: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="polygon"):
        FloorGrid.empty(0.0, 0.0, 0.05, columns=3, rows=3).look(polygon)
