"""Shortest ways over free floor from one place: Dijkstra's algorithm on the grid's eight-neighbourhood (scipy's, in C), so that
all places that a way might lead to are compared at once."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from server.planning.free_space import FreeSpace

_NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (1, -1))
_NOWHERE = -9999
"""What scipy writes for a cell without a predecessor."""


class ShortestWays:
    """The costs of the cheapest ways from `start` to every cell."""

    def __init__(self, space: FreeSpace, start: tuple[float, float]) -> None:
        self._space = space
        rows, columns, _ = space.cells_of([start])
        self._start = int(rows[0]) * space.shape[1] + int(columns[0])
        graph = _graph(space, self._start)
        cost, before = csgraph.dijkstra(graph, directed=False, indices=[self._start], return_predecessors=True)
        self._cost: NDArray[np.float64] = np.asarray(cost, dtype=np.float64)[0]
        self._before: NDArray[np.int32] = np.asarray(before, dtype=np.int32)[0]

    def costs(self, points: Sequence[tuple[float, float]]) -> NDArray[np.float64]:
        """What the way to each point costs, shape (N,): metres where there is room; infinite where none leads."""
        rows, columns, known = self._space.cells_of(points)
        return np.where(known, self._cost[rows * self._space.shape[1] + columns], np.inf)

    @property
    def all_costs(self) -> NDArray[np.float64]:
        """Of every cell, shape (rows, columns)."""
        return self._cost.reshape(self._space.shape)

    def way_to(self, point: tuple[float, float]) -> list[tuple[float, float]]:
        """The centres of the cells from the start to the point's; empty when none leads there."""
        rows, columns, known = self._space.cells_of([point])
        cell = int(rows[0]) * self._space.shape[1] + int(columns[0])
        if not known[0] or not np.isfinite(self._cost[cell]):
            return []
        cells = [cell]
        while cells[-1] != self._start and self._before[cells[-1]] != _NOWHERE:
            cells.append(int(self._before[cells[-1]]))
        return [self._space.centre(cell) for cell in reversed(cells)]


def _graph(space: FreeSpace, start: int) -> sparse.csr_array:
    """Edges between neighbouring allowed cells; the start has its edges even where it is not allowed itself."""
    allowed = space.allowed.copy()
    allowed.flat[start] = True
    height, width = space.shape
    index = np.arange(height * width, dtype=np.int32).reshape(height, width)
    froms, tos, weights = list[NDArray[np.int32]](), list[NDArray[np.int32]](), list[NDArray[np.float64]]()
    for down, right in _NEIGHBOURS:
        here = (slice(0, height - down), slice(max(0, -right), width - max(0, right)))
        there = (slice(down, height), slice(max(0, right), width + min(0, right)))
        joined = allowed[here] & allowed[there]
        froms.append(index[here][joined])
        tos.append(index[there][joined])
        step_m = space.cell_m * float(np.hypot(down, right))
        weights.append(step_m * (space.cost[here][joined] + space.cost[there][joined]) / 2)
    entries = (np.concatenate(weights), (np.concatenate(froms), np.concatenate(tos)))
    return sparse.coo_array(entries, shape=(height * width, height * width)).tocsr()
