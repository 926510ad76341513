"""How points where rays meet a horizontal plane move with the camera's calibration and lens, to first order.

What the covariance of a calibration means on the floor, for `tag_pose`, the fit to a lens as described, and the figures shown.
"""

import numpy as np
from numpy.typing import NDArray

from geometry import CameraModel
from localization.projection import CameraView, PlaneHits, undistort

Array = NDArray[np.float64]


def calibration_jacobians(view: CameraView, pixels: Array, height_m: float) -> Array:
    """How the points where rays through `pixels` (N, 2) meet the plane z = height_m move: shape (N, 2, 10), metres per rad,
    m and px of (rotation, translation, fx, fy, cx, cy), in the order of `CameraExtrinsics.covariance`.
    PointsAtInfinityError as `CameraView.hits`."""
    plane = undistort(view.model, pixels)
    distorted, bend = distortion(view.model, plane)
    heights = np.full(len(plane), height_m)
    hits = view.hits(plane, heights)
    return by_calibration(view, distorted, heights, hits, hits.jacobians @ bend / (view.model.fx, view.model.fy))


def by_calibration(view: CameraView, distorted: Array, heights: Array, hits: PlaneHits, per_pixel: Array) -> Array:
    """The same of `hits` on planes at `heights` (N,), whose rays have the distorted image points (N, 2) at depth 1;
    `per_pixel` (N, 2, 2) is how the hits move with their pixels.

    A ray that is turned by delta (a left perturbation) about the camera's centre C meets the plane at
    P + (1 - slope e_z^T) (delta x (P - C)), slope being P's displacement per metre of height; a pixel
    (u, v) = (fx x_d + cx, fy y_d + cy) that stays where it is has another x_d, y_d when the lens is another.
    """
    jacobians = np.zeros((len(distorted), 2, 10))
    slope_x, slope_y = hits.slopes[:, 0], hits.slopes[:, 1]
    away = hits.points - view.T_map_camera.translation[:2]
    x, y = away[:, 0], away[:, 1]
    drop = heights - view.T_map_camera.translation[2]
    jacobians[:, 0, 0], jacobians[:, 0, 1], jacobians[:, 0, 2] = -slope_x * y, drop + slope_x * x, -y
    jacobians[:, 1, 0], jacobians[:, 1, 1], jacobians[:, 1, 2] = -drop - slope_y * y, slope_y * x, x
    jacobians[:, 0, 3] = jacobians[:, 1, 4] = 1.0
    jacobians[:, :, 5] = -hits.slopes
    jacobians[:, :, 6:8] = -per_pixel * distorted[:, None]
    jacobians[:, :, 8:10] = -per_pixel
    return jacobians


def distortion(model: CameraModel, plane: Array) -> tuple[Array, Array]:
    """Distorted image points (N, 2) of undistorted ones, and the derivatives (N, 2, 2) of the undistorted by the distorted
    (Brown-Conrady as in OpenCV's documentation; the inverse of the forward model's Jacobian)."""
    k1, k2, p1, p2, k3 = model.distortion
    x, y = plane[:, 0], plane[:, 1]
    xx, yy, xy = x * x, y * y, x * y
    r2 = xx + yy
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2))
    distorted = np.empty_like(plane)
    distorted[:, 0] = x * radial + 2.0 * p1 * xy + p2 * (r2 + 2.0 * xx)
    distorted[:, 1] = y * radial + p1 * (r2 + 2.0 * yy) + 2.0 * p2 * xy
    along_x = radial + slope * xx + 2.0 * p1 * y + 6.0 * p2 * x
    along_y = radial + slope * yy + 6.0 * p1 * y + 2.0 * p2 * x
    across = slope * xy + 2.0 * p1 * x + 2.0 * p2 * y
    inverse = np.empty((len(plane), 2, 2))
    inverse[:, 0, 0], inverse[:, 1, 1] = along_y, along_x
    inverse[:, 0, 1] = inverse[:, 1, 0] = -across
    inverse /= (along_x * along_y - across * across)[:, None, None]
    return distorted, inverse
