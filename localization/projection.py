"""Between the pixels of one calibrated camera and the map frame, point by point (spec localization, pipeline step 4).

Pinhole and Brown-Conrady distortion by OpenCV's points-only functions. `CameraView` is made anew for each calibration.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE3, CameraModel
from protocol.messages import CameraExtrinsics

Array = NDArray[np.float64]

_UNDISTORTION: Any = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-10)
_BORDER_SLACK = 1.15
"""Rays this much outside the image's own may still be projected; further out the distortion polynomial may fold back."""


class PointsAtInfinityError(ValueError):
    """Rays that never meet the plane they are intersected with."""


def undistort(model: CameraModel, pixels: Array) -> Array:
    """Pixels of shape (N, 2) to the undistorted image plane at depth 1 (x right, y down), shape (N, 2)."""
    points = np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2)
    plane = cv2.undistortPoints(points, model.matrix(), model.distortion_array(), criteria=_UNDISTORTION)
    return plane.reshape(-1, 2).astype(np.float64, copy=False)


def extrinsics_pose(extrinsics: CameraExtrinsics) -> SE3:
    """T_map_camera of the message."""
    return SE3.from_rotvec(extrinsics.rotvec, extrinsics.translation)


@dataclass(frozen=True, slots=True, eq=False)
class PlaneHits:
    """Where rays meet a horizontal plane: `points` (N, 2), metres in the map frame; `jacobians` (N, 2, 2), how the points
    move per unit of the undistorted image plane (divided by the focal length: per pixel); `slopes` (N, 2), how they move per
    metre of the plane's height."""

    points: Array
    jacobians: Array
    slopes: Array


class Extent(NamedTuple):
    """An upright rectangle in the map frame, metres."""

    left: float
    bottom: float
    right: float
    top: float

    def is_near(self, x: float, y: float, margin_m: float) -> bool:
        """Whether the point is inside, or outside by no more than the margin along each axis."""
        return self.left - margin_m <= x <= self.right + margin_m and self.bottom - margin_m <= y <= self.top + margin_m


class CameraView:
    """One camera with its pose. Points in the map frame are metres, pixels are OpenCV's."""

    def __init__(self, model: CameraModel, T_map_camera: SE3) -> None:
        self.model = model
        self.T_map_camera = T_map_camera
        self._rotation = T_map_camera.rotation
        self._centre = T_map_camera.translation
        T_camera_map = T_map_camera.inverse()
        self._rvec, self._tvec = T_camera_map.rotvec(), np.array(T_camera_map.translation)
        self._map_to_camera = T_camera_map.rotation
        self._matrix, self._distortion = model.matrix(), model.distortion_array()
        self._border = undistort(model, _border(model))
        self._widest = _BORDER_SLACK * float(np.linalg.norm(self._border, axis=1).max())
        self._extents: dict[float, Extent] = {}

    def hits(self, plane: Array, height_m: float | Array) -> PlaneHits:
        """Intersects the rays through undistorted image points (N, 2) with the plane z = height_m, the same for all or (N,).

        With C the camera's centre and d = R (x, y, 1)^T: P = C + (h - C_z) d / d_z, differentiated by the quotient rule.
        PointsAtInfinityError when a ray does not come down (or up) to the plane.
        """
        rotation, centre = self._rotation, self._centre
        directions = plane @ rotation[:, :2].T + rotation[:, 2]
        depth = height_m - centre[2]
        dz = directions[:, 2]
        if not bool(np.all(dz * depth > 1e-9)):
            raise PointsAtInfinityError(f"a ray does not meet the plane z = {height_m} m")
        ratio = directions[:, :2] / dz[:, None]
        scale = depth / dz
        jacobians = scale[:, None, None] * (rotation[:2, :2] - ratio[:, :, None] * rotation[2, :2])
        return PlaneHits(centre[:2] + np.reshape(depth, (-1, 1)) * ratio, jacobians, ratio)

    def extent(self, height_m: float) -> "Extent":
        """The smallest upright rectangle around what the picture shows of the plane z = height_m; everything when a ray of its
        border does not meet it."""
        extent = self._extents.get(height_m)
        if extent is None:
            try:
                points = self.hits(self._border, height_m).points
            except PointsAtInfinityError:
                extent = Extent(-math.inf, -math.inf, math.inf, math.inf)
            else:
                (left, bottom), (right, top) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
                extent = Extent(left, bottom, right, top)
            self._extents[height_m] = extent
        return extent

    def project(self, points: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Pixels (N, 2) of points (N, 3), also outside the image, and whether they mean anything, shape (N,): points behind
        the camera or far outside its view have no pixel."""
        in_camera = (points - self._centre) @ self._map_to_camera.T
        z = in_camera[:, 2]
        meant = (z > 1e-3) & (np.hypot(in_camera[:, 0], in_camera[:, 1]) <= self._widest * np.maximum(z, 1e-3))
        raw, _ = cv2.projectPoints(points, self._rvec, self._tvec, self._matrix, self._distortion)
        return cast("Array", raw.reshape(-1, 2)), meant

    def distance_m(self, points: Array) -> Array:
        """How far points (N, 3) are from the camera's centre, shape (N,)."""
        return cast("Array", np.linalg.norm(points - self._centre, axis=1))


def _border(model: CameraModel, steps: int = 16) -> Array:
    """Pixels along the image's edge, shape (4 * steps, 2)."""
    along = np.linspace(0.0, 1.0, steps)
    zero, one = np.zeros(steps), np.ones(steps)
    unit = np.concatenate(
        [np.stack(pair, axis=1) for pair in ((along, zero), (along, one), (zero, along), (one, along))]
    )
    return unit * (model.width - 1, model.height - 1)
