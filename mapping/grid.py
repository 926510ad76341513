"""The 2D grid on the floor: where something stands and what the cameras see at all (spec mapping, "Ceiling cameras").

One camera's raster, the merged map of the lab and what guidance asks its obstacle boxes are all this type. Bit fields on
the wire, boolean arrays here. No image processing, so that the server may use it.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from protocol.errors import DecodeError
from protocol.messages import FloorRaster

CELL_M = 0.05
"""Cell size of the camera rasters and of the obstacle map."""
MAX_CELLS = 16_000_000
"""400 m x 100 m of 5 cm cells; a header that announces more is taken for an error."""
_ALIGNMENT = 1e-3
"""How far, in cells, two grids' corners may miss each other and still share cells."""


@dataclass(frozen=True, slots=True, eq=False)
class PolygonContent:
    """What a grid knows of a polygon: the centres of the occupied cells in it, shape (N, 2), metres, map frame; and which
    share of it is observed (0..1; what lies outside the grid is not observed)."""

    occupied: NDArray[np.float64]
    observed_share: float

    @property
    def blocked(self) -> bool:
        """Whether any cell in the polygon is occupied."""
        return len(self.occupied) > 0


@dataclass(frozen=True, slots=True, eq=False)
class FloorGrid:
    """Cell (row, column) covers x from `origin_x + column * cell_m` and y from `origin_y + row * cell_m` (map frame, metres;
    rows grow with y). `occupied` and `observed` are boolean, shape (rows, columns), read-only. A cell can be occupied
    without being observed: something was seen there, and nobody has looked since."""

    origin_x: float
    origin_y: float
    cell_m: float
    occupied: NDArray[np.bool_]
    observed: NDArray[np.bool_]

    def __post_init__(self) -> None:
        if not (math.isfinite(self.origin_x) and math.isfinite(self.origin_y)):
            raise ValueError(f"a grid's origin must be finite, got ({self.origin_x}, {self.origin_y})")
        if not (math.isfinite(self.cell_m) and self.cell_m > 0):
            raise ValueError(f"a grid's cells have a positive size, got {self.cell_m} m")
        occupied, observed = np.array(self.occupied, dtype=np.bool_), np.array(self.observed, dtype=np.bool_)
        if occupied.ndim != 2 or occupied.shape != observed.shape or occupied.size == 0:
            raise ValueError(f"occupied and observed must share a 2D shape, got {occupied.shape} and {observed.shape}")
        occupied.setflags(write=False)
        observed.setflags(write=False)
        object.__setattr__(self, "occupied", occupied)
        object.__setattr__(self, "observed", observed)

    @classmethod
    def empty(cls, origin_x: float, origin_y: float, cell_m: float, *, columns: int, rows: int) -> Self:
        """Nothing occupied, nothing observed. ValueError for a size that cannot be."""
        if columns <= 0 or rows <= 0 or columns * rows > MAX_CELLS:
            raise ValueError(f"a grid of {columns} x {rows} cells cannot be (at most {MAX_CELLS} cells)")
        nothing = np.zeros((rows, columns), dtype=np.bool_)
        return cls(origin_x, origin_y, cell_m, nothing, nothing)

    @classmethod
    def covering(cls, bounds: tuple[float, float, float, float], cell_m: float = CELL_M) -> Self:
        """The empty grid over (min x, min y, max x, max y), its corners on whole multiples of the cell size, so that all
        grids of one cell size share their cells."""
        low_x, low_y = (math.floor(value / cell_m + 1e-9) for value in bounds[:2])
        high_x, high_y = (math.ceil(value / cell_m - 1e-9) for value in bounds[2:])
        return cls.empty(
            low_x * cell_m, low_y * cell_m, cell_m, columns=max(1, high_x - low_x), rows=max(1, high_y - low_y)
        )

    @classmethod
    def from_raster(cls, raster: FloorRaster) -> Self:
        """DecodeError, naming the source, when the raster contradicts itself."""
        what = f"raster of {raster.source!r}"
        if not (raster.columns > 0 and raster.rows > 0 and raster.columns * raster.rows <= MAX_CELLS):
            raise DecodeError(f"{what} has {raster.columns} columns and {raster.rows} rows")
        if not (math.isfinite(raster.origin_x) and math.isfinite(raster.origin_y)):
            raise DecodeError(f"{what} has its origin at ({raster.origin_x}, {raster.origin_y})")
        if not (math.isfinite(raster.cell_m) and raster.cell_m > 0):
            raise DecodeError(f"{what} has cells of {raster.cell_m} m")
        cells = raster.columns * raster.rows
        needed = -(-cells // 8)
        for name, data in (("occupied", raster.occupied), ("observed", raster.observed)):
            if len(data) != needed:
                raise DecodeError(
                    f"{what}: {name} has {len(data)} bytes, {raster.columns} x {raster.rows} cells need {needed}"
                )
        shape = (raster.rows, raster.columns)
        return cls(
            raster.origin_x,
            raster.origin_y,
            raster.cell_m,
            _unpacked(raster.occupied, shape),
            _unpacked(raster.observed, shape),
        )

    def to_raster(self, source: str, stamp_ns: int) -> FloorRaster:
        """The message; `source` is a camera id or the lab's instance."""
        return FloorRaster(
            source,
            stamp_ns,
            self.origin_x,
            self.origin_y,
            self.cell_m,
            self.columns,
            self.rows,
            np.packbits(self.occupied).tobytes(),
            np.packbits(self.observed).tobytes(),
        )

    @property
    def rows(self) -> int:
        return int(self.occupied.shape[0])

    @property
    def columns(self) -> int:
        return int(self.occupied.shape[1])

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """min x, min y, max x, max y in metres."""
        return (
            self.origin_x,
            self.origin_y,
            self.origin_x + self.columns * self.cell_m,
            self.origin_y + self.rows * self.cell_m,
        )

    def with_cells(self, occupied: NDArray[np.bool_], observed: NDArray[np.bool_]) -> "FloorGrid":
        """The same place with other contents, shapes (rows, columns)."""
        if occupied.shape != self.occupied.shape:
            raise ValueError(f"the grid has shape {self.occupied.shape}, got {occupied.shape}")
        return FloorGrid(self.origin_x, self.origin_y, self.cell_m, occupied, observed)

    def centres(self, cells: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Centres (x, y) of the cells marked in a (rows, columns) array, shape (N, 2), row by row."""
        rows, columns = np.nonzero(cells)
        x = self.origin_x + (columns + 0.5) * self.cell_m
        y = self.origin_y + (rows + 0.5) * self.cell_m
        return np.column_stack((x, y)).astype(np.float64, copy=False)

    def occupied_centres(self) -> NDArray[np.float64]:
        """Centres (x, y) of the occupied cells, shape (N, 2), row by row."""
        return self.centres(self.occupied)

    def placed_in(self, other: "FloorGrid") -> "FloorGrid":
        """These contents seen through the other grid's window: cells outside of this grid are neither occupied nor observed.
        ValueError unless both share their cells (same size, corners on common multiples)."""
        row, column = self._offset_in(other)
        occupied, observed = np.zeros_like(other.occupied), np.zeros_like(other.observed)
        top, left = max(0, row), max(0, column)
        bottom, right = min(other.rows, row + self.rows), min(other.columns, column + self.columns)
        if top < bottom and left < right:
            target = (slice(top, bottom), slice(left, right))
            source = (slice(top - row, bottom - row), slice(left - column, right - column))
            occupied[target] = self.occupied[source]
            observed[target] = self.observed[source]
        return other.with_cells(occupied, observed)

    def window_in(self, other: "FloorGrid") -> tuple[slice, slice]:
        """Rows and columns of the other grid that this one takes up. ValueError unless both share their cells and this grid lies
        within the other."""
        row, column = self._offset_in(other)
        if row < 0 or column < 0 or row + self.rows > other.rows or column + self.columns > other.columns:
            raise ValueError(f"a grid over {self.bounds} does not lie within {other.bounds}")
        return slice(row, row + self.rows), slice(column, column + self.columns)

    def merged(self, other: "FloorGrid") -> "FloorGrid":
        """This grid's window with both contents: occupied where either says so, observed where either looks. ValueError as
        in `placed_in`."""
        placed = other.placed_in(self)
        return self.with_cells(self.occupied | placed.occupied, self.observed | placed.observed)

    def look(self, polygon: ArrayLike) -> PolygonContent:
        """What is known of a polygon (N, 2), metres, map frame. A cell belongs to it when its centre does; a polygon that
        crosses itself has an inside wherever it winds around a point, so that a path's own loops leave no holes. One too
        thin for any centre is not observed. ValueError unless it has three finite corners."""
        corners = np.asarray(polygon, dtype=np.float64)
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3 or not np.isfinite(corners).all():
            raise ValueError(f"a polygon has three or more finite corners (N, 2), got shape {corners.shape}")
        in_cells = (corners - (self.origin_x, self.origin_y)) / self.cell_m
        low, high = in_cells.min(axis=0), in_cells.max(axis=0)
        left, bottom = (max(0, math.floor(value)) for value in low)
        right, top = min(self.columns, math.ceil(high[0])), min(self.rows, math.ceil(high[1]))
        if left >= right or bottom >= top:
            return PolygonContent(np.empty((0, 2)), 0.0)
        inside = _inside(
            in_cells, np.arange(left, right, dtype=np.float64) + 0.5, np.arange(bottom, top, dtype=np.float64) + 0.5
        )
        window = (slice(bottom, top), slice(left, right))
        rows, columns = np.nonzero(self.occupied[window] & inside)
        x = self.origin_x + (columns + left + 0.5) * self.cell_m
        y = self.origin_y + (rows + bottom + 0.5) * self.cell_m
        cells = float(np.count_nonzero(inside))
        if low[0] < 0 or low[1] < 0 or high[0] > self.columns or high[1] > self.rows:
            cells = max(cells, _area(in_cells))
        seen = float(np.count_nonzero(self.observed[window] & inside))
        occupied = np.column_stack((x, y)).astype(np.float64, copy=False)
        return PolygonContent(occupied, seen / cells if cells > 0 else 0.0)

    def _offset_in(self, other: "FloorGrid") -> tuple[int, int]:
        """Row and column of this grid's first cell in the other one."""
        if abs(self.cell_m - other.cell_m) > 1e-9:
            raise ValueError(f"grids of {self.cell_m} m and {other.cell_m} m cells cannot be merged")
        row = (self.origin_y - other.origin_y) / other.cell_m
        column = (self.origin_x - other.origin_x) / other.cell_m
        if abs(row - round(row)) > _ALIGNMENT or abs(column - round(column)) > _ALIGNMENT:
            raise ValueError(
                f"grids do not share their cells: origins ({self.origin_x}, {self.origin_y}) and "
                f"({other.origin_x}, {other.origin_y}), cells of {other.cell_m} m"
            )
        return round(row), round(column)


def _unpacked(data: bytes, shape: tuple[int, int]) -> NDArray[np.bool_]:
    bits = np.unpackbits(np.frombuffer(data, np.uint8), count=shape[0] * shape[1])
    return bits.astype(np.bool_).reshape(shape)


def _inside(corners: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points of the raster x (C,) times y (R,) the polygon (N, 2) winds around, shape (R, C): the winding number by
    signed crossings of a ray towards +x."""
    start, end = corners, np.roll(corners, -1, axis=0)
    rise = end[:, 1] - start[:, 1]
    upward = (start[:, 1] <= y[:, None]) & (end[:, 1] > y[:, None])
    downward = (start[:, 1] > y[:, None]) & (end[:, 1] <= y[:, None])
    direction = upward.astype(np.int32) - downward.astype(np.int32)
    above = y[:, None] - start[:, 1]
    share = np.divide(above, rise, out=np.zeros_like(above), where=direction != 0)
    crossing = start[:, 0] + share * (end[:, 0] - start[:, 0])
    right_of = x[None, :, None] < crossing[:, None, :]
    return np.einsum("re,rce->rc", direction, right_of) != 0


def _area(corners: NDArray[np.float64]) -> float:
    """Shoelace formula."""
    x, y = corners[:, 0], corners[:, 1]
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))
