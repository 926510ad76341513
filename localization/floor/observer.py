"""Floor obstacles of one camera: what on the floor is not floor (spec mapping, "Ceiling cameras"; spec gpss, "obstacles").

A frame is sampled on the floor plane and compared with the learned background; cells of 5 cm in which half of the samples
deviate are occupied, holes closed, specks dropped. Tagged robots are not obstacles to themselves: what they cover or hide is
not observed. Everything else that stands on the floor is marked from its foot to where its top falls on the floor seen from
this camera; the mapper takes back what another camera sees free (`mapping.fusion`).
"""

import logging
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.floor.background import Background, Comparison
from localization.floor.picture import FloorPainter
from localization.floor.silhouettes import looks_like, robot_mask
from localization.floor.store import background_path, load_background, save_background
from localization.floor.view import FloorView, floor_view, moved
from mapping.grid import CELL_M, FloorGrid
from mapping.tiles import FloorTile
from protocol.frames import Frame
from protocol.lab import Lab, VehicleSpec
from protocol.messages import CameraExtrinsics, FloorRaster, TrackedPose

_logger = logging.getLogger(__name__)

_FINE_M = 0.025
"""Distance of the samples that are compared: four per cell."""
_PICTURE_M = 0.0125
_EVERY_S = 0.12
"""Frames nearer to the last one used are left out: 7.5 Hz of a camera at 15, 30 or 60 Hz."""
_OCCUPIED_SAMPLES = 2
_SMALLEST_BLOB = 3
"""Cells; smaller specks are noise or a robot's rim. Anything 10 cm wide covers more."""
_KEEP_AWAY_CELLS = 2
"""The background is not followed so near to something occupied: its shadow and reflection would be learned."""
_SHADE_M = 0.25
"""No floor is learned so near to a robot: its shadow and what shines back from it would be, and their place be occupied when
it leaves."""
_SAVE_EVERY_S = 60.0
_FIRST_SAVE_S = 10.0
_IMPLAUSIBLE_SHARE = 0.4
"""A kept background from which more than this share of the floor deviates at the start is not of this floor and light."""


class FloorObserver:
    """One camera's eye on the floor. Not thread-safe.

    `state` is the folder in which the learned background survives restarts; None keeps nothing.
    """

    def __init__(self, lab: Lab, camera_id: str, state: Path | None = None) -> None:
        self._camera = lab.camera(camera_id)
        self._vehicles = {vehicle.id: vehicle for vehicle in lab.vehicles}
        self._lab_grid = FloorGrid.covering(lab.bounds(), CELL_M)
        self._path = None if state is None else background_path(state, camera_id)
        self._extrinsics: CameraExtrinsics | None = None
        self._view: FloorView | None = None
        self._painter: FloorPainter | None = None
        self._background: Background | None = None
        self._on_trial = False
        self._last_ns: int | None = None
        self._saved_ns: int | None = None

    def observe(
        self,
        frame: Frame,
        extrinsics: CameraExtrinsics,
        poses: Mapping[str, TrackedPose],
        *,
        robots_are_known: bool = True,
    ) -> FloorRaster | None:
        """The floor raster at the frame's capture time; None for a frame that is left out (it comes too soon after the last
        one, or the camera sees no floor of the lab). While the floor is being learned, nothing is observed yet.

        `poses` are the newest known ones by vehicle id. Unless `robots_are_known`, one may stand in view that none of them
        is of: then no floor is learned, for it would be learned with the robot on it, and its place be occupied when it leaves.
        ValueError for a frame of another size than the lab file says.
        """
        expected = (self._camera.height, self._camera.width)
        if frame.pixels.shape[:2] != expected:
            height, width = frame.pixels.shape[:2]
            raise ValueError(
                f"camera {self._camera.id!r}: frame of {width} x {height}, "
                f"the lab file says {self._camera.width} x {self._camera.height}"
            )
        if self._last_ns is not None and 0 <= frame.stamp_ns - self._last_ns < _EVERY_S * 1e9:
            return None
        elapsed_s = 0.0 if self._last_ns is None else max(0.0, (frame.stamp_ns - self._last_ns) * 1e-9)
        self._last_ns = frame.stamp_ns
        self._look_through(extrinsics)
        view = self._view
        if view is None:
            return None
        floor = view.sample(frame.pixels)
        robots = self._robots(poses)
        masked = robot_mask(view, robots, frame.stamp_ns)
        open_floor = view.visible & ~masked
        background, comparison = self._compare(view, extrinsics, floor, open_floor)
        if comparison.blind:
            return self._raster(view, frame.stamp_ns, None, None)
        for vehicle, pose in robots:
            if looks_like(view, vehicle, pose, frame.stamp_ns, comparison.known, comparison.difference):
                # The robot stood there while the floor was learned: it is part of the background.
                background.forget(robot_mask(view, [(vehicle, pose)], frame.stamp_ns, margin_m=0.1))
        observed = _cells(open_floor & comparison.known, view.per_cell) >= view.per_cell**2
        deviating = _cells(comparison.deviating & open_floor, view.per_cell) >= _OCCUPIED_SAMPLES
        occupied = _cleaned(deviating & observed) & observed
        near = cv2.dilate(occupied.astype(np.uint8), np.ones((2 * _KEEP_AWAY_CELLS + 1,) * 2, np.uint8)) > 0
        free = open_floor & ~np.kron(near, np.ones((view.per_cell,) * 2, np.bool_))
        background.follow(comparison, free, elapsed_s)
        if robots_are_known:
            shaded = robot_mask(view, robots, frame.stamp_ns, margin_m=_SHADE_M)
            background.learn(comparison.normalised, open_floor & ~shaded)
        self._paint(frame, robots, occupied)
        self._save_when_due(frame.stamp_ns)
        return self._raster(view, frame.stamp_ns, occupied, observed)

    def picture(self) -> FloorTile | None:
        """A new picture of this camera's part of the floor, at most every two seconds; None in between."""
        return None if self._painter is None else self._painter.tile()

    def save(self) -> None:
        """Keeps the learned background, as at a camera's orderly end. A disk that does not take it costs a warning."""
        if self._path is None or self._background is None or self._view is None or self._extrinsics is None:
            return
        if self._on_trial or not self._background.known.any():
            return
        try:
            save_background(self._path, self._background, self._view, self._extrinsics)
        except OSError as error:
            _logger.warning("cannot keep the background of %s: %s", self._camera.id, error)

    def _look_through(self, extrinsics: CameraExtrinsics) -> None:
        """Builds the tables anew when the camera was moved; what was learned then no longer holds."""
        if self._extrinsics is not None and not moved(self._extrinsics, extrinsics):
            return
        model = self._camera.model()
        self._extrinsics = extrinsics
        self._background = None
        self._view = floor_view(model, extrinsics, self._lab_grid, fine_m=_FINE_M, pixel_m=_FINE_M / 2)
        fine = floor_view(model, extrinsics, self._lab_grid, fine_m=_PICTURE_M, pixel_m=_PICTURE_M)
        self._painter = None if fine is None else FloorPainter(fine)
        if self._view is None:
            _logger.warning("camera %s sees no floor of the lab's areas", self._camera.id)

    def _robots(self, poses: Mapping[str, TrackedPose]) -> list[tuple[VehicleSpec, TrackedPose]]:
        return [(self._vehicles[name], pose) for name, pose in poses.items() if name in self._vehicles]

    def _compare(
        self, view: FloorView, extrinsics: CameraExtrinsics, floor: NDArray[np.float32], open_floor: NDArray[np.bool_]
    ) -> tuple[Background, Comparison]:
        """The frame against the background in use; a kept one must first prove that it is of this floor."""
        if self._background is None or self._background.mean.shape != floor.shape:
            kept = None if self._path is None else load_background(self._path, view, extrinsics, floor.shape)
            self._on_trial = kept is not None
            self._background = kept or Background(floor.shape)
        comparison = self._background.compare(floor, open_floor)
        if self._on_trial and not comparison.blind:
            compared = comparison.known & open_floor
            share = np.count_nonzero(comparison.deviating & open_floor) / max(1, np.count_nonzero(compared))
            if share > _IMPLAUSIBLE_SHARE:
                _logger.warning(
                    "the kept background of %s differs from %d %% of the floor, learning it anew",
                    self._camera.id,
                    round(100 * share),
                )
                self._background = Background(floor.shape)
                comparison = self._background.compare(floor, open_floor)
            self._on_trial = False
        return self._background, comparison

    def _paint(self, frame: Frame, robots: list[tuple[VehicleSpec, TrackedPose]], occupied: NDArray[np.bool_]) -> None:
        painter, view = self._painter, self._view
        if painter is None or view is None or not painter.due(frame.stamp_ns):
            return
        obstacles = view.grid.with_cells(occupied, occupied).placed_in(painter.view.grid).occupied
        painter.paint(frame.pixels, frame.stamp_ns, robot_mask(painter.view, robots, frame.stamp_ns), obstacles)

    def _save_when_due(self, stamp_ns: int) -> None:
        if self._saved_ns is None or stamp_ns < self._saved_ns:
            self._saved_ns = stamp_ns - round((_SAVE_EVERY_S - _FIRST_SAVE_S) * 1e9)
        elif stamp_ns - self._saved_ns >= _SAVE_EVERY_S * 1e9:
            self._saved_ns = stamp_ns
            self.save()

    def _raster(
        self,
        view: FloorView,
        stamp_ns: int,
        occupied: NDArray[np.bool_] | None,
        observed: NDArray[np.bool_] | None,
    ) -> FloorRaster:
        nothing = np.zeros_like(view.grid.occupied)
        grid = view.grid.with_cells(
            nothing if occupied is None else occupied, nothing if observed is None else observed
        )
        return grid.to_raster(self._camera.id, stamp_ns)


def _cells(samples: NDArray[np.bool_], per_cell: int) -> NDArray[np.int64]:
    """How many samples of each cell are set: (rows * n, columns * n) -> (rows, columns)."""
    rows, columns = samples.shape[0] // per_cell, samples.shape[1] // per_cell
    return samples.reshape(rows, per_cell, columns, per_cell).sum(axis=(1, 3), dtype=np.int64)


def _cleaned(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Gaps of one cell closed, specks dropped."""
    # A border of free cells: closing must not fill along the edge of the view.
    framed = cv2.copyMakeBorder(cells.astype(np.uint8), 2, 2, 2, 2, cv2.BORDER_CONSTANT, value=0)
    closed = cv2.morphologyEx(framed, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))[2:-2, 2:-2]
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(np.ascontiguousarray(closed), connectivity=8)
    large = np.asarray(statistics[:, cv2.CC_STAT_AREA] >= _SMALLEST_BLOB, dtype=np.bool_)
    large[0] = False
    return large[np.asarray(labels, dtype=np.intp)]
