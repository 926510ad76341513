"""The floor that a robot's centre may be on: a window of the obstacle grid with what each cell is away from obstacles.

A way is asked to keep `half_width + clearance` from everything (a robot that drives along it is as wide as that), by the
Euclidean distance transform between the cells' centres. One cell less is still allowed: a grid shows every obstacle up to
a cell too large, and a gap that is just wide enough must not be closed by that. Such cells cost more, so that
they are used only where there is no better way. Near the robot, which may stand nearer to something than that already,
it is enough not to come any nearer.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from shapely.geometry.base import BaseGeometry

from mapping.grid import FloorGrid

_MOST_CELLS = 60_000
"""Of a window: 15 x 10 m of 5 cm. A larger one is looked at in coarser cells."""
_NEAR_M = 0.7
"""How far from the robot its present clearance is enough."""
_UNSEEN_NEAR_M = 0.6
"""Floor this near is hidden from the cameras by the robot itself, not unknown."""
_TIGHT_COST = 3.0
_SPARE_M = 0.1


@dataclass(frozen=True, slots=True)
class Needs:
    """What a robot at `start` needs of the floor, in metres: half its width, and what is to stay free beside that. `own` is its
    outline: what lies within is the robot itself. `unknown` says whether floor that no camera sees counts as taken."""

    start: tuple[float, float]
    half_width_m: float
    clearance_m: float
    own: BaseGeometry
    unknown: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class FreeSpace:
    """A window of the floor. Arrays have shape (rows, columns); cell (row, column) is centred at
    `origin + (column, row) * cell_m`. `clearance_m` is the distance of its centre to the nearest taken cell's, `free` whether
    there is room enough, `allowed` whether a way may lead over it (free, or near the robot), `cost` what a metre over it costs.
    """

    origin: tuple[float, float]
    cell_m: float
    required_m: float
    clearance_m: NDArray[np.float64]
    free: NDArray[np.bool_]
    allowed: NDArray[np.bool_]
    cost: NDArray[np.float64] = field(repr=False)

    @classmethod
    def around(
        cls,
        needs: Needs,
        grid: FloorGrid,
        ground: BaseGeometry,
        bounds: tuple[float, float, float, float],
        obstacles: Sequence[BaseGeometry] = (),
        lanes: Sequence[BaseGeometry] = (),
    ) -> "FreeSpace":
        """The window over `bounds` (min x, min y, max x, max y) as far as the grid knows it. `obstacles` are taken too (other
        robots), `lanes` are kept off by the robot's centre but for its own surroundings (where others are about to drive), and
        its body stays on `ground`. ValueError when the window has nothing in common with the grid."""
        window, taken, unseen = _window(grid, bounds)
        x, y = window.centres()
        near_m = np.hypot(x[None, :] - needs.start[0], y[:, None] - needs.start[1])
        taken &= ~_covered(window, needs.own)
        for shape in obstacles:
            taken |= _covered(window, shape)
        if needs.unknown:
            taken |= unseen & (near_m > _UNSEEN_NEAR_M)
        clearance = _distance(taken, window.cell_m)
        required = needs.half_width_m + needs.clearance_m
        inside = _covered(window, ground)
        border = _distance(~inside, window.cell_m)
        row, column = window.cell_of(needs.start)
        tight = required - window.cell_m
        here = min(tight, float(clearance[row, column]) - window.cell_m)
        here_border = min(needs.half_width_m, float(border[row, column]) - window.cell_m)
        near = near_m <= _NEAR_M
        enough = (clearance >= tight) & (border >= needs.half_width_m)
        for lane in lanes:
            enough &= ~_covered(window, lane)
        allowed = enough | (near & (clearance >= here) & (border >= here_border) & inside & ~taken)
        cost = np.where(clearance < required + _SPARE_M, _TIGHT_COST, 1.0)
        return cls(window.origin, window.cell_m, required, clearance, enough, allowed, cost)

    @property
    def shape(self) -> tuple[int, int]:
        return int(self.allowed.shape[0]), int(self.allowed.shape[1])

    def cells_of(self, points: ArrayLike) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
        """Rows and columns of points (N, 2), and which of them are in the window (the others' are clipped to it)."""
        at = (np.asarray(points, dtype=np.float64).reshape(-1, 2) - self.origin) / self.cell_m
        columns, rows = np.rint(at[:, 0]).astype(np.intp), np.rint(at[:, 1]).astype(np.intp)
        height, width = self.shape
        known = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        return rows.clip(0, height - 1), columns.clip(0, width - 1), known

    def allows(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Which points (N, 2) a way may lead over, shape (N,)."""
        rows, columns, known = self.cells_of(points)
        return self.allowed[rows, columns] & known

    def roomy(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Which points (N, 2) have room enough around them, shape (N,)."""
        rows, columns, known = self.cells_of(points)
        return self.free[rows, columns] & known

    def covered(self, shape: BaseGeometry) -> NDArray[np.bool_]:
        """Which cells' centres lie within a shape, shape (rows, columns)."""
        return _covered(_Window(self.origin, self.cell_m, *self.shape), shape)

    def clearance_at(self, points: ArrayLike) -> NDArray[np.float64]:
        """How far points (N, 2) are from what is taken, by their cells, shape (N,); 0 where nothing is known."""
        rows, columns, known = self.cells_of(points)
        return np.where(known, self.clearance_m[rows, columns], 0.0)

    def centre(self, cell: int) -> tuple[float, float]:
        """The centre of a cell by its index, row by row."""
        row, column = divmod(cell, self.shape[1])
        return self.origin[0] + column * self.cell_m, self.origin[1] + row * self.cell_m


@dataclass(frozen=True, slots=True)
class _Window:
    """Where a window's cells are; `origin` is the centre of the first one."""

    origin: tuple[float, float]
    cell_m: float
    rows: int
    columns: int

    def centres(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        x = self.origin[0] + np.arange(self.columns, dtype=np.float64) * self.cell_m
        return x, self.origin[1] + np.arange(self.rows, dtype=np.float64) * self.cell_m

    def cell_of(self, point: tuple[float, float]) -> tuple[int, int]:
        column, row = (round((p - o) / self.cell_m) for p, o in zip(point, self.origin, strict=True))
        return min(self.rows - 1, max(0, row)), min(self.columns - 1, max(0, column))


def _window(
    grid: FloorGrid, bounds: tuple[float, float, float, float]
) -> tuple[_Window, NDArray[np.bool_], NDArray[np.bool_]]:
    """The part of the grid within bounds: its cells, which are taken, and which are seen by nobody. In a coarser one a cell is
    taken, or unseen, when any of those in it are."""
    low = np.floor((np.array(bounds[:2]) - (grid.origin_x, grid.origin_y)) / grid.cell_m).astype(int).clip(0)
    high = np.ceil((np.array(bounds[2:]) - (grid.origin_x, grid.origin_y)) / grid.cell_m).astype(int)
    left, bottom = (int(value) for value in low)
    right, top = min(grid.columns, int(high[0])), min(grid.rows, int(high[1]))
    if right - left < 2 or top - bottom < 2:
        raise ValueError(f"the window {bounds} has nothing in common with the grid over {grid.bounds}")
    taken, unseen = grid.occupied[bottom:top, left:right], ~grid.observed[bottom:top, left:right]
    factor = max(1, int(np.ceil(np.sqrt(taken.size / _MOST_CELLS))))
    if factor > 1:
        taken, unseen = _coarser(taken, factor), _coarser(unseen, factor)
    cell_m = grid.cell_m * factor
    origin = (grid.origin_x + left * grid.cell_m + cell_m / 2, grid.origin_y + bottom * grid.cell_m + cell_m / 2)
    return _Window(origin, cell_m, taken.shape[0], taken.shape[1]), taken.copy(), unseen


def _coarser(cells: NDArray[np.bool_], factor: int) -> NDArray[np.bool_]:
    rows, columns = (-(-size // factor) for size in cells.shape)
    padded = np.zeros((rows * factor, columns * factor), dtype=np.bool_)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    return np.logical_or.reduce(padded.reshape(rows, factor, columns, factor), axis=(1, 3))


def _covered(window: _Window, shape: BaseGeometry) -> NDArray[np.bool_]:
    """Which cells' centres lie within a shape, shape (rows, columns)."""
    covered = np.zeros((window.rows, window.columns), dtype=np.bool_)
    if shape.is_empty:
        return covered
    x, y = window.centres()
    low_x, low_y, high_x, high_y = shape.bounds
    across = slice(*np.searchsorted(x, [low_x, high_x + window.cell_m]))
    along = slice(*np.searchsorted(y, [low_y, high_y + window.cell_m]))
    shapely.prepare(shape)
    grid_x, grid_y = np.meshgrid(x[across], y[along])
    covered[along, across] = shapely.contains_xy(shape, grid_x, grid_y)
    return covered


def _distance(taken: NDArray[np.bool_], cell_m: float) -> NDArray[np.float64]:
    """Metres from each cell's centre to the nearest taken one's; far where none is taken."""
    if not taken.any():
        return np.full(taken.shape, 1e3)
    return np.asarray(ndimage.distance_transform_edt(~taken, sampling=cell_m), dtype=np.float64)
