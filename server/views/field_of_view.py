"""The floor that a camera sees: its image border, undistorted, as rays met with the plane z = 0.

Distortion is inverted by fixed-point iteration on the Brown-Conrady model (Brown 1966; as OpenCV names its coefficients),
in numpy alone. Good to a centimetre or so, which a drawing needs; localization has its own, exact one.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from geometry import SE3, CameraModel

_PER_SIDE = 6
_ITERATIONS = 20
_FARTHEST_M = 100.0
"""Rays that meet the floor beyond this, or never, end here."""


@lru_cache(maxsize=256)
def floor_outline(
    camera: CameraModel, rotvec: tuple[float, float, float], translation: tuple[float, float, float]
) -> tuple[tuple[float, float], ...]:
    """The outline in metres, map frame, of what a camera with T_map_camera (`rotvec` in rad, `translation` in m) sees of
    the floor; empty when it looks away from it."""
    T_map_camera = SE3.from_rotvec(rotvec, translation)
    rays = undistorted(camera, _border(camera))
    directions = np.column_stack([rays, np.ones(len(rays))]) @ T_map_camera.rotation.T
    height = float(T_map_camera.translation[2])
    down = -directions[:, 2]
    if height <= 0 or not (down > 1e-9).any():
        return ()
    horizontal = np.hypot(directions[:, 0], directions[:, 1])
    with np.errstate(divide="ignore"):
        along = np.where(down > 1e-9, height / np.maximum(down, 1e-9), np.inf)
        along = np.minimum(along, _FARTHEST_M / np.maximum(horizontal, 1e-9))
    points = T_map_camera.translation[:2] + directions[:, :2] * along[:, None]
    return tuple((round(float(x), 3), round(float(y), 3)) for x, y in points)


def undistorted(camera: CameraModel, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels (N, 2) to points (N, 2) on the plane one focal length ahead, by fixed-point iteration."""
    k1, k2, p1, p2, k3 = camera.distortion
    distorted = (pixels - np.array([camera.cx, camera.cy])) / np.array([camera.fx, camera.fy])
    points = distorted.copy()
    for _ in range(_ITERATIONS):
        x, y = points[:, 0], points[:, 1]
        r2 = np.minimum(x * x + y * y, 1e3)
        # Beyond the model's reach the polynomial may turn over; a factor near zero would throw the point away.
        radial = np.maximum(1 + r2 * (k1 + r2 * (k2 + r2 * k3)), 0.1)
        tangential = np.column_stack([2 * p1 * x * y + p2 * (r2 + 2 * x * x), p1 * (r2 + 2 * y * y) + 2 * p2 * x * y])
        points = (distorted - tangential) / radial[:, None]
    return points


def _border(camera: CameraModel) -> NDArray[np.float64]:
    """Pixels around the image's border, shape (4 * _PER_SIDE, 2); the first pixel's centre is (0, 0)."""
    left, top, right, bottom = -0.5, -0.5, camera.width - 0.5, camera.height - 0.5
    steps = np.arange(_PER_SIDE) / _PER_SIDE
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
    sides = [a + (b - a) * steps[:, None] for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    return np.concatenate(sides)
