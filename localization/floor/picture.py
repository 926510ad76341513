"""A camera's picture of its part of the floor, robots and obstacles left out as far as the floor was ever seen without them."""

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.floor.view import FloorView
from mapping.tiles import FloorTile

_PAINT_EVERY_S = 1.0
_TILE_EVERY_S = 2.0
_BLEND = 0.25
"""Weight of a new frame where the floor was painted before: noise fades, changes come through in a few seconds."""
_JPEG_QUALITY = 85


class FloorPainter:
    """Accumulates the picture; times are the frames' capture times."""

    def __init__(self, view: FloorView) -> None:
        self._view = view
        self._floor: NDArray[np.float32] | None = None
        self._painted = np.zeros(view.visible.shape, np.bool_)
        self._painted_ns: int | None = None
        self._tile_ns: int | None = None

    @property
    def view(self) -> FloorView:
        return self._view

    def due(self, stamp_ns: int) -> bool:
        """Whether a frame of that time is wanted."""
        return _due(self._painted_ns, stamp_ns, _PAINT_EVERY_S)

    def paint(
        self, pixels: NDArray[np.uint8], stamp_ns: int, robots: NDArray[np.bool_], obstacles: NDArray[np.bool_]
    ) -> None:
        """Adds a frame. `robots` (shape of the view's samples) is left out always, `obstacles` (rows, columns of the grid)
        where the floor below was seen before."""
        floor = self._view.sample(pixels)
        if self._floor is None or self._floor.shape != floor.shape:
            self._floor = floor
            self._painted = np.zeros(self._view.visible.shape, np.bool_)
        in_the_way = np.kron(obstacles, np.ones((self._view.per_cell,) * 2, np.bool_))
        usable = self._view.visible & ~robots
        first = usable & ~self._painted
        again = usable & self._painted & ~in_the_way
        self._floor[first] = floor[first]
        self._floor[again] += _BLEND * (floor[again] - self._floor[again])
        self._painted |= first
        self._painted_ns = stamp_ns

    def tile(self) -> FloorTile | None:
        """The picture, when it changed and the last one is two seconds old; else None."""
        if self._floor is None or self._painted_ns is None or not self._painted.any():
            return None
        if not _due(self._tile_ns, self._painted_ns, _TILE_EVERY_S):
            return None
        picture = self._floor.copy()
        # Floor that was hidden so far takes the floor's usual colour instead of showing a robot that may long be gone.
        picture[~self._painted] = np.median(picture[self._painted], axis=0)
        north_up = np.ascontiguousarray(np.clip(np.rint(picture), 0, 255).astype(np.uint8)[::-1])
        done, jpeg = cv2.imencode(".jpg", north_up, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
        if not done:
            return None
        self._tile_ns = self._painted_ns
        return FloorTile(self._view.grid.bounds, self._view.outline, jpeg.tobytes())


def _due(last_ns: int | None, stamp_ns: int, every_s: float) -> bool:
    """A step back in time (a recording that starts over) counts as due."""
    return last_ns is None or not 0 <= stamp_ns - last_ns < every_s * 1e9
