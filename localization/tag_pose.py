"""The pose of a tag that lies level at a known height, and how far it may be trusted (spec localization, "Better than the
reports").

The rays of the four corners meet the plane at the tag's height; a rigid fit of the known square to the four points gives
x, y, yaw. PnP would have to find depth and tilt from a few pixels; here they are known.
"""

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from localization.projection import CameraView
from localization.tags import tag_corners

Array = NDArray[np.float64]

Upper = tuple[float, float, float, float, float, float]
"""xx, xy, xyaw, yy, yyaw, yawyaw of a covariance (m^2, m rad, rad^2), as in the messages."""


class NotATagError(ValueError):
    """Four points on the plane that are not the square that the tag is; the text says by how much."""


@dataclass(frozen=True, slots=True)
class PoseNoise:
    """What limits a pose. `corner_px`: standard deviation of a corner, each axis, new in every frame; `calibration_px`: how far
    off the extrinsics put a point of the floor, the same in every frame of one camera; `height_m`: how far off the tag's height
    was measured, which counts away from the camera's foot; `max_misfit`: how far the corners may be off the tag's square,
    relative to its size."""

    corner_px: float = 0.10
    calibration_px: float = 0.30
    height_m: float = 0.0015
    max_misfit: float = 0.05


_CALIBRATION_LEVER_M = 1.0
"""Extrinsics that shift the floor by s turn it by about s over the distance of the floor tags; this is less than that."""


@dataclass(frozen=True, slots=True, eq=False)
class TagPose:
    """T_map_tag in the plane of the tag and its covariance (3, 3) over x, y, yaw; `misfit_m` is the RMS distance of the
    corners from the fitted square."""

    pose: SE2
    covariance: Array
    misfit_m: float


def tag_pose(view: CameraView, plane: Array, size_m: float, height_m: float, noise: PoseNoise) -> TagPose:
    """The pose from the undistorted corners `plane` (4, 2) of a level tag of that size at that height.

    Pixel noise reaches x, y, yaw through the rays: each corner's 2x2 Jacobian grows with the depth and with the ray's
    obliqueness to the plane; the fit is linear in the corners near the solution. Distortion's own scale, a few per cent, is
    left out. PointsAtInfinityError, NotATagError.
    """
    hits = view.hits(plane, height_m)
    square = tag_corners(size_m)
    centre = hits.points.mean(axis=0)
    offsets = hits.points - centre
    # Procrustes in the plane: the yaw that turns the square onto the points in the least-squares sense.
    dot = float((square * offsets).sum())
    cross = float((square[:, 0] * offsets[:, 1] - square[:, 1] * offsets[:, 0]).sum())
    yaw = math.atan2(cross, dot)
    c, s = math.cos(yaw), math.sin(yaw)
    turned = square @ np.array([[c, s], [-s, c]])
    misfit_m = float(np.sqrt(np.square(offsets - turned).sum(axis=1).mean()))
    if misfit_m > noise.max_misfit * size_m:
        raise NotATagError(f"corners are {misfit_m * 1e3:.1f} mm off a square of {size_m * 1e3:.0f} mm")
    # x, y are the mean of the corners; yaw is the mean of their displacements along the tangent, by the lever arm.
    tangents = np.column_stack([-turned[:, 1], turned[:, 0]]) / float(np.square(square).sum())
    gain = np.zeros((3, 4, 2))
    gain[0, :, 0] = gain[1, :, 1] = 0.25
    gain[2] = tangents
    per_pixel = hits.jacobians / np.array([view.model.fx, view.model.fy])
    through = noise.corner_px * np.einsum("aij,ijk->aik", gain, per_pixel).reshape(3, 8)
    covariance = through @ through.T
    lean = noise.height_m * hits.slopes.mean(axis=0)
    covariance[:2, :2] += np.outer(lean, lean)
    shift = noise.calibration_px * per_pixel.mean(axis=0)
    covariance[:2, :2] += shift @ shift.T
    covariance[2, 2] += abs(float(np.linalg.det(shift))) / _CALIBRATION_LEVER_M**2
    return TagPose(SE2(float(centre[0]), float(centre[1]), yaw), covariance, misfit_m)


def vehicle_pose(tag: SE2, covariance: Array, T_vehicle_tag: SE2) -> tuple[SE2, Array]:
    """Pose and covariance of the rotation centre of the vehicle that wears the tag; the offset turns yaw noise into
    position noise."""
    to_vehicle = T_vehicle_tag.inverse()
    pose = tag @ to_vehicle
    c, s = math.cos(tag.yaw), math.sin(tag.yaw)
    jacobian = np.eye(3)
    jacobian[0, 2] = -s * to_vehicle.x - c * to_vehicle.y
    jacobian[1, 2] = c * to_vehicle.x - s * to_vehicle.y
    return pose, jacobian @ covariance @ jacobian.T


def upper(covariance: Array) -> Upper:
    """The upper triangle of a (3, 3) covariance."""
    m = covariance
    return (float(m[0, 0]), float(m[0, 1]), float(m[0, 2]), float(m[1, 1]), float(m[1, 2]), float(m[2, 2]))


def from_upper(values: Upper) -> Array:
    """The (3, 3) covariance of an upper triangle."""
    xx, xy, xt, yy, yt, tt = values
    return cast("Array", np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]]))
