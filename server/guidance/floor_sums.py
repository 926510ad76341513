"""Whether any of a rectangle of the floor is taken, or unseen, without looking at its cells: a summed-area table of the grid.

Most robots have nothing near their obstacle box most of the time; this tells which, so that only the others are looked at
exactly.
"""

import numpy as np
from numpy.typing import NDArray

from mapping.grid import FloorGrid

Bounds = tuple[float, float, float, float]
"""min x, min y, max x, max y in metres."""


_BLOCK = 4
"""Cells to a block's side, which the table counts instead of cells: 16 times less of it."""


class FloorSums:
    """Of one obstacle grid."""

    def __init__(self, grid: FloorGrid) -> None:
        self._grid = grid
        self._doubtful = _summed(_blocks(grid.occupied | ~grid.observed))

    def all_clear(self, bounds: Bounds) -> bool:
        """Whether every block that the rectangle touches is seen and free; not so outside of the grid."""
        grid = self._grid
        block_m = _BLOCK * grid.cell_m
        left, bottom = int((bounds[0] - grid.origin_x) // block_m), int((bounds[1] - grid.origin_y) // block_m)
        right, top = int((bounds[2] - grid.origin_x) // block_m) + 1, int((bounds[3] - grid.origin_y) // block_m) + 1
        sums = self._doubtful
        if left < 0 or bottom < 0 or top >= sums.shape[0] or right >= sums.shape[1]:
            return False
        return bool(sums[top, right] - sums[bottom, right] - sums[top, left] + sums[bottom, left] == 0)


def _blocks(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Blocks in which any cell is marked; those beyond the border of the grid are not whole and are left out."""
    rows, columns = (size // _BLOCK * _BLOCK for size in cells.shape)
    across = np.logical_or.reduce([cells[offset:rows:_BLOCK, :columns] for offset in range(_BLOCK)])
    return np.logical_or.reduce([across[:, offset::_BLOCK] for offset in range(_BLOCK)])


def _summed(cells: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Entry (row, column): how many cells are marked below and left of that corner, shape (rows + 1, columns + 1)."""
    sums = np.zeros((cells.shape[0] + 1, cells.shape[1] + 1), dtype=np.int32)
    np.cumsum(cells, axis=0, dtype=np.int32, out=sums[1:, 1:])
    np.cumsum(sums[1:, 1:], axis=1, out=sums[1:, 1:])
    return sums
