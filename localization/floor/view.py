"""Where each point of the floor is in a camera's image: the tables with which frames are sampled on the floor plane.

Built once per extrinsics; a frame is first shrunk until its pixels are hardly finer than the samples (each then is an
average over the floor around it, which is also what takes the noise away), then looked up.
"""

import math
from dataclasses import dataclass
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE3, CameraModel
from mapping.grid import FloorGrid
from protocol.messages import CameraExtrinsics

_BORDER_PX = 2.0
"""Samples nearer to the image border (in shrunken pixels) are left out: interpolation has only half of them."""


@dataclass(frozen=True, slots=True, eq=False)
class FloorView:
    """A camera's window on the floor.

    `grid` are the cells it sees any part of; `map_x`, `map_y` the pixel (of the shrunken image, size `shrunk`) of each fine
    sample, shape (rows * n, columns * n) with n samples per cell and axis; `visible` whether the sample is in the image.
    `eye` is the camera's position in the map frame (3,), metres.
    """

    grid: FloorGrid
    per_cell: int
    map_x: NDArray[np.float32]
    map_y: NDArray[np.float32]
    visible: NDArray[np.bool_]
    shrunk: tuple[int, int]
    eye: NDArray[np.float64]
    outline: tuple[tuple[float, float], ...]

    @property
    def fine_m(self) -> float:
        """Distance of neighbouring samples, metres."""
        return self.grid.cell_m / self.per_cell

    def sample(self, pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
        """The floor in the frame: grey levels (rows * n, columns * n) or with a colour axis (..., 3); 0 where not visible."""
        small = cv2.resize(pixels, self.shrunk, interpolation=cv2.INTER_AREA)
        floor = cv2.remap(small, self.map_x, self.map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return floor.astype(np.float32)

    def to_fine(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (N, 2) of the floor, metres, map frame -> (column, row) among the samples; whole numbers are sample centres."""
        origin = np.array([self.grid.origin_x, self.grid.origin_y])
        return (points - origin) / self.fine_m - 0.5


def floor_view(
    model: CameraModel, extrinsics: CameraExtrinsics, lab_grid: FloorGrid, *, fine_m: float, pixel_m: float
) -> FloorView | None:
    """The part of `lab_grid` that the camera sees, None when it sees none of it. Samples lie about `fine_m` apart (a whole
    number per cell); `pixel_m` is what a pixel of the shrunken image is to cover of the floor below the camera."""
    T_camera_map = SE3.from_rotvec(extrinsics.rotvec, extrinsics.translation).inverse()
    per_cell = max(1, round(lab_grid.cell_m / fine_m))
    fine_m = lab_grid.cell_m / per_cell
    x = lab_grid.origin_x + (np.arange(lab_grid.columns * per_cell) + 0.5) * fine_m
    y = lab_grid.origin_y + (np.arange(lab_grid.rows * per_cell) + 0.5) * fine_m
    factor = max(1, round(pixel_m * max(model.fx, model.fy) / max(0.1, abs(extrinsics.translation[2]))))
    shrunk = (max(1, model.width // factor), max(1, model.height // factor))
    # A coarse look first: projecting every sample of a large hall for each of its cameras would take long.
    corners_x = lab_grid.origin_x + np.arange(lab_grid.columns + 1) * lab_grid.cell_m
    corners_y = lab_grid.origin_y + np.arange(lab_grid.rows + 1) * lab_grid.cell_m
    _, _, seen = _project(model, T_camera_map, corners_x, corners_y, shrunk)
    if not seen.any():
        return None
    rows, columns = np.nonzero(seen)
    row0, row1 = max(0, int(rows.min()) - 1), min(lab_grid.rows, int(rows.max()) + 1)
    column0, column1 = max(0, int(columns.min()) - 1), min(lab_grid.columns, int(columns.max()) + 1)
    map_x, map_y, visible = _project(
        model,
        T_camera_map,
        x[column0 * per_cell : column1 * per_cell],
        y[row0 * per_cell : row1 * per_cell],
        shrunk,
    )
    if not visible.any():
        return None
    grid = FloorGrid.empty(
        lab_grid.origin_x + column0 * lab_grid.cell_m,
        lab_grid.origin_y + row0 * lab_grid.cell_m,
        lab_grid.cell_m,
        columns=column1 - column0,
        rows=row1 - row0,
    )
    return FloorView(
        grid,
        per_cell,
        map_x,
        map_y,
        visible,
        shrunk,
        np.array(extrinsics.translation, dtype=np.float64),
        _outline(visible, grid, fine_m),
    )


def _project(
    model: CameraModel,
    T_camera_map: SE3,
    x: NDArray[np.floating],
    y: NDArray[np.floating],
    shrunk: tuple[int, int],
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
    """Pixels (x, y) in the shrunken image of the floor points x (C,) times y (R,), each (R, C), and which are inside."""
    grid_x, grid_y = np.meshgrid(x, y)
    points = np.column_stack((grid_x.ravel(), grid_y.ravel(), np.zeros(grid_x.size)))
    seen_from_camera = T_camera_map.apply(points)
    depth = seen_from_camera[:, 2]
    ahead = depth > 0.05
    safe_depth = np.where(ahead, depth, 1.0)
    radius = np.hypot(seen_from_camera[:, 0], seen_from_camera[:, 1]) / safe_depth
    # Beyond the image's own corners the distortion polynomial may fold back into the image.
    usable = ahead & (radius <= 1.02 * _largest_radius(model))
    pixels = np.full((len(points), 2), -1e6)
    if usable.any():
        projected, _ = cv2.projectPoints(
            seen_from_camera[usable], np.zeros(3), np.zeros(3), model.matrix(), model.distortion_array()
        )
        pixels[usable] = projected.reshape(-1, 2)
    width, height = shrunk
    map_x = (pixels[:, 0] + 0.5) * width / model.width - 0.5
    map_y = (pixels[:, 1] + 0.5) * height / model.height - 0.5
    inside = (
        usable
        & (map_x >= _BORDER_PX)
        & (map_x <= width - 1 - _BORDER_PX)
        & (map_y >= _BORDER_PX)
        & (map_y <= height - 1 - _BORDER_PX)
    )
    shape = grid_x.shape
    return (
        map_x.astype(np.float32).reshape(shape),
        map_y.astype(np.float32).reshape(shape),
        inside.reshape(shape),
    )


def _largest_radius(model: CameraModel) -> float:
    """Distance of the farthest image point from the optical axis on the plane z = 1 of the camera frame."""
    w, h = model.width - 1.0, model.height - 1.0
    border = np.array(
        [[0, 0], [w / 2, 0], [w, 0], [w, h / 2], [w, h], [w / 2, h], [0, h], [0, h / 2]], dtype=np.float64
    )
    rays = cv2.undistortPoints(border.reshape(-1, 1, 2), model.matrix(), model.distortion_array()).reshape(-1, 2)
    return float(np.hypot(rays[:, 0], rays[:, 1]).max())


def _outline(visible: NDArray[np.bool_], grid: FloorGrid, fine_m: float) -> tuple[tuple[float, float], ...]:
    """The border of what is visible as a polygon, metres, within 2 cm."""
    contours, _ = cv2.findContours(visible.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    largest = max(contours, key=cv2.contourArea)
    polygon = cast("NDArray[np.int32]", cv2.approxPolyDP(largest, 0.02 / fine_m, closed=True)).reshape(-1, 2)
    return tuple(
        (grid.origin_x + (float(column) + 0.5) * fine_m, grid.origin_y + (float(row) + 0.5) * fine_m)
        for column, row in polygon
    )


def moved(a: CameraExtrinsics, b: CameraExtrinsics) -> bool:
    """Whether the camera hangs so differently (over 5 mm or 2.5 mrad, near a centimetre on the floor) that what was sampled
    before no longer lies on what is sampled now. Estimates of one and the same mounting differ by less."""
    T_a, T_b = (SE3.from_rotvec(e.rotvec, e.translation) for e in (a, b))
    return math.dist(a.translation, b.translation) > 0.005 or T_a.angle_to(T_b) > 0.0025
