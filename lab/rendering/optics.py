"""Where light falls: the simulated camera's projection and its inverse, for the renderer alone.

Pinhole camera with Brown-Conrady distortion (k1, k2, p1, p2, k3) in OpenCV's convention (the first pixel's centre is (0, 0)).
Written from the formulas with nothing but arithmetic; it shares no code with what estimates poses from the images.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry import CameraModel
from protocol.lab import SimulatedMount

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]

_NODE_PX = 8
"""Spacing of the pixels whose rays are solved for; between them rays are interpolated by cubics (error below 1e-6 px)."""
_BORDER_PX = 2
"""Rays are also known this far outside the image, for sampling inside border pixels and for blur."""
_MIN_DEPTH_M = 0.05


def mount_rotation(mount: SimulatedMount) -> Float64:
    """R_map_camera (3, 3): Rz(yaw) Rx(pi + tilt_x) Ry(tilt_y)."""
    a, b, c = mount.yaw, math.pi + mount.tilt_x, mount.tilt_y
    rz = np.array([[math.cos(a), -math.sin(a), 0.0], [math.sin(a), math.cos(a), 0.0], [0.0, 0.0, 1.0]])
    rx = np.array([[1.0, 0.0, 0.0], [0.0, math.cos(b), -math.sin(b)], [0.0, math.sin(b), math.cos(b)]])
    ry = np.array([[math.cos(c), 0.0, math.sin(c)], [0.0, 1.0, 0.0], [-math.sin(c), 0.0, math.cos(c)]])
    return rz @ rx @ ry


class Optics:
    """One camera at its true place.

    `slopes` (height + 2 B, width + 2 B, 2), float32, B = `border`: the viewing ray of every pixel as its displacement in
    map x and y per metre *down*; the ray of pixel (u, v) meets height h at position_xy + (position_z - h) * slopes.
    """

    border = _BORDER_PX

    def __init__(self, model: CameraModel, mount: SimulatedMount) -> None:
        self.model = model
        self.position = np.array(mount.position)
        self._rotation = mount_rotation(mount)
        rays, self._farthest = _rays(model)
        x, y = rays[..., 0], rays[..., 1]
        r = self._rotation
        down = -(r[2, 0] * x + r[2, 1] * y + r[2, 2])
        if float(down.min()) <= 0.0:
            raise ValueError("a simulated camera must look down: part of its image is above the horizon")
        self.slopes: Float32 = np.stack(
            ((r[0, 0] * x + r[0, 1] * y + r[0, 2]) / down, (r[1, 0] * x + r[1, 1] * y + r[1, 2]) / down), axis=-1
        ).astype(np.float32)

    def project(self, points: ArrayLike) -> Float64 | None:
        """Pixels (N, 2) of map points (N, 3) in metres; None when any is not in front of the camera. Far outside the
        image, where the polynomial of the lens means nothing, the distortion of the image's border is kept."""
        seen = (np.asarray(points, dtype=np.float64) - self.position) @ self._rotation
        if float(seen[:, 2].min()) < _MIN_DEPTH_M:
            return None
        x, y = seen[:, 0] / seen[:, 2], seen[:, 1] / seen[:, 2]
        shrink = np.minimum(1.0, self._farthest / np.maximum(np.hypot(x, y), 1e-12))
        distorted_x, distorted_y = _distort(self.model, x * shrink, y * shrink)
        m = self.model
        return np.stack((m.fx * distorted_x / shrink + m.cx, m.fy * distorted_y / shrink + m.cy), axis=-1)

    def pixels_per_metre(self, height_m: float) -> float:
        """Scale of the image for things at that height, near the principal point."""
        m = self.model
        return (m.fx + m.fy) / 2.0 / max(_MIN_DEPTH_M, float(self.position[2]) - height_m)

    def window(self, x0: int, y0: int, x1: int, y1: int) -> Float32:
        """`slopes` of the pixels x0 <= u < x1, y0 <= v < y1 (a view)."""
        b = self.border
        return self.slopes[y0 + b : y1 + b, x0 + b : x1 + b]


def _distort(model: CameraModel, x: Float64, y: Float64) -> tuple[Float64, Float64]:
    """Normalised image coordinates behind the lens (OpenCV's documentation of the camera model)."""
    k1, k2, p1, p2, k3 = model.distortion
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return (
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    )


def _undistort(model: CameraModel, target_x: Float64, target_y: Float64) -> tuple[Float64, Float64]:
    """Solves `_distort` for its input with Newton's method. ValueError when the lens folds the image over itself."""
    k1, k2, p1, p2, k3 = model.distortion
    x, y = target_x.copy(), target_y.copy()
    for _ in range(12):
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))  # derivative of `radial` by r2, times two
        along_x = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x
        along_y = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x
        across = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y
        determinant = along_x * along_y - across * across
        if float(determinant.min()) <= 0.0:
            break
        at_x, at_y = _distort(model, x, y)
        error_x, error_y = target_x - at_x, target_y - at_y
        x = x + (along_y * error_x - across * error_y) / determinant
        y = y + (along_x * error_y - across * error_x) / determinant
        if max(float(np.abs(error_x).max()), float(np.abs(error_y).max())) < 1e-12:
            return x, y
    raise ValueError(f"the distortion {model.distortion} cannot be inverted inside an image of this size")


def _rays(model: CameraModel) -> tuple[Float64, float]:
    """Undistorted normalised coordinates of every pixel, (height + 2 B, width + 2 B, 2), and the greatest radius among
    them."""
    us, vs = np.arange(-_BORDER_PX, model.width + _BORDER_PX), np.arange(-_BORDER_PX, model.height + _BORDER_PX)
    nodes_u, weights_u = _cubic_weights(us)
    nodes_v, weights_v = _cubic_weights(vs)
    grid_x, grid_y = np.meshgrid((nodes_u - model.cx) / model.fx, (nodes_v - model.cy) / model.fy)
    x, y = _undistort(model, grid_x, grid_y)
    rays = np.stack((weights_v @ x @ weights_u.T, weights_v @ y @ weights_u.T), axis=-1)
    return rays, float(np.hypot(x, y).max())


def _cubic_weights(at: NDArray[np.int_]) -> tuple[Float64, Float64]:
    """Nodes (M,) around the positions `at` (N,), and the (N, M) matrix of Lagrange's cubic interpolation between them."""
    first = int(at[0]) - _NODE_PX
    count = (int(at[-1]) - first) // _NODE_PX + 3
    position = (at - first) / _NODE_PX
    left = np.floor(position).astype(int)
    t = position - left
    weights = np.zeros((len(at), count))
    rows = np.arange(len(at))
    weights[rows, left - 1] = -t * (t - 1.0) * (t - 2.0) / 6.0
    weights[rows, left] = (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0
    weights[rows, left + 1] = -(t + 1.0) * t * (t - 2.0) / 2.0
    weights[rows, left + 2] = (t + 1.0) * t * (t - 1.0) / 6.0
    return first + _NODE_PX * np.arange(count, dtype=np.float64), weights
