"""Several cameras' floor rasters merged into one obstacle map (spec mapping, "Ceiling cameras").

Rules, safe before tidy:
- Occupied is what any living camera calls occupied; observed is what any living camera observes.
- A camera that is silent for longer than a second observes nothing. What it last called occupied stays occupied (and
  unobserved) until a living camera observes the place: whatever stood there has not been seen leaving.
- What a robot covers or hides is not observed by that camera and says nothing; it is not remembered, since a robot that waits
  for somebody who stood in its blind spot would wait for ever. The robot itself is guarded by its pose.
- Tall things smear away from the camera, because their tops fall on the floor farther out. The foot of a thing lies in its
  silhouette for every camera, so of one connected patch those cells are taken back which another camera sees free, lying
  behind (seen from the first camera) a part of the patch that another camera confirms, and farther than `KEEP_M` from any
  such part. A patch that nobody confirms stays whole: the other camera may be blind to it, as for black on black. Low things
  smear less than `KEEP_M` and therefore never shrink where both cameras see them, and never vanish at all.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.grid import FloorGrid
from protocol.messages import FloorRaster

TTL_S = 1.0
"""How long a camera's raster counts as what it sees now."""
KEEP_M = 0.2
"""Distance from a confirmed cell within which nothing is taken back: calibration errors, the smear of low things, and how
far a walker comes between two cameras' frames."""
_BINS = 360
_UNDER_CAMERA_M = 0.3
"""So near to the point below the camera there is no direction in which something could smear."""


@dataclass(slots=True, eq=False)
class _View:
    """A camera's newest raster and where it lies in the lab's grid."""

    grid: FloorGrid
    stamp_ns: int
    window: tuple[slice, slice]


class ObstacleMap:
    """The lab's obstacle grid; `area` (empty) says where it is. Times are wall-clock nanoseconds."""

    def __init__(self, area: FloorGrid, cameras: Iterable[str]) -> None:
        self._area = area
        self._cameras = frozenset(cameras)
        self._views: dict[str, _View] = {}
        self._eyes: dict[str, tuple[float, float]] = {}
        self._remembered = np.zeros_like(area.occupied)

    def place_camera(self, camera: str, x: float, y: float) -> None:
        """Where a camera hangs (metres, map frame). Without it, nothing of what the camera sees is taken back."""
        self._eyes[camera] = (x, y)

    def add(self, raster: FloorRaster) -> bool:
        """Takes a camera's raster; False when it is older than the one known. DecodeError or ValueError, naming the camera,
        for a raster that contradicts itself, is of an unknown camera or does not share the lab's cells."""
        if raster.source not in self._cameras:
            raise ValueError(f"raster of {raster.source!r}, which is no camera of the lab")
        known = self._views.get(raster.source)
        if known is not None and raster.stamp_ns < known.stamp_ns:
            return False
        grid = FloorGrid.from_raster(raster)
        try:
            window = grid.window_in(self._area)
        except ValueError as error:
            raise ValueError(f"raster of {raster.source!r}: {error}") from error
        self._views[raster.source] = _View(grid, raster.stamp_ns, window)
        return True

    def merged(self, now_ns: int) -> FloorGrid:
        """The obstacle map at this time."""
        living = {name: self._views[name] for name in self.living(now_ns)}
        shape = self._area.occupied.shape
        votes_occupied, votes_observed = np.zeros(shape, np.uint8), np.zeros(shape, np.uint8)
        for view in living.values():
            votes_occupied[view.window] += view.grid.occupied
            votes_observed[view.window] += view.grid.observed
        occupied = np.zeros(shape, np.bool_)
        for name, view in living.items():
            occupied[view.window] |= self._believed(name, view, votes_occupied, votes_observed)
        observed = votes_observed > 0
        for name in self._views.keys() - living.keys():
            silent = self._views[name]
            self._remembered[silent.window] |= silent.grid.occupied
        self._remembered &= ~observed
        for name in self._views.keys() - living.keys():
            # Remembered once; what a living camera then saw free must not come back. The stamp stays, against old rasters.
            silent = self._views[name]
            nothing = np.zeros_like(silent.grid.occupied)
            silent.grid = silent.grid.with_cells(nothing, nothing)
        return self._area.with_cells(occupied | self._remembered, observed)

    def living(self, now_ns: int) -> tuple[str, ...]:
        """The cameras that count as observing. One whose clock is ahead does not: nobody could tell when it falls silent."""
        return tuple(sorted(name for name, view in self._views.items() if abs(now_ns - view.stamp_ns) <= TTL_S * 1e9))

    def _believed(
        self, name: str, view: _View, votes_occupied: NDArray[np.uint8], votes_observed: NDArray[np.uint8]
    ) -> NDArray[np.bool_]:
        """What a camera calls occupied without the smear that others see through, shape of its grid."""
        seen = view.grid.occupied
        eye = self._eyes.get(name)
        if eye is None or not seen.any():
            return seen
        other_occupied = votes_occupied[view.window] - seen.astype(np.uint8)
        other_observed = votes_observed[view.window] - view.grid.observed.astype(np.uint8)
        confirmed = seen & (other_occupied > 0)
        doubted = seen & (other_observed > 0) & ~confirmed
        if not confirmed.any() or not doubted.any():
            return seen
        reach = math.ceil(KEEP_M / view.grid.cell_m)
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1,) * 2)
        doubted &= cv2.dilate(confirmed.astype(np.uint8), disc) == 0
        if not doubted.any():
            return seen
        _, patches = cv2.connectedComponents(seen.astype(np.uint8), connectivity=8)
        patch_of = np.asarray(patches)
        believed = seen.copy()
        for patch in np.unique(patch_of[doubted]):
            part = patch_of == patch
            if (part & confirmed).any():
                believed &= ~_behind(view.grid, eye, doubted & part, confirmed & part)
        return believed


def _behind(
    grid: FloorGrid, eye: tuple[float, float], cells: NDArray[np.bool_], screen: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Those of `cells` that the eye sees behind a cell of `screen`: in the same direction and farther out."""
    screen_bins, screen_distances = _polar(grid, eye, screen)
    nearest = np.full(_BINS, np.inf)
    np.minimum.at(nearest, screen_bins, screen_distances)
    # A cell is wider than a bin nearby: its neighbours count as the same direction.
    spread = max(
        1, math.ceil(_BINS * grid.cell_m / (2 * math.pi * max(_UNDER_CAMERA_M, float(screen_distances.min()))))
    )
    nearest = np.min([np.roll(nearest, shift) for shift in range(-spread, spread + 1)], axis=0)
    bins, distances = _polar(grid, eye, cells)
    behind = np.zeros_like(cells)
    behind[cells] = (distances > nearest[bins]) & (distances > _UNDER_CAMERA_M)
    return behind


def _polar(
    grid: FloorGrid, eye: tuple[float, float], cells: NDArray[np.bool_]
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Direction (bin number) and distance (m) of the cells' centres from the point below the eye, in row order."""
    offsets = grid.centres(cells) - np.array(eye)
    angles = np.arctan2(offsets[:, 1], offsets[:, 0])
    bins = np.floor((angles + math.pi) / (2 * math.pi) * _BINS).astype(np.intp) % _BINS
    return bins, np.hypot(offsets[:, 0], offsets[:, 1])
