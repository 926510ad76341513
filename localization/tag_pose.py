"""Poses of tags that lie level at known heights, and how far they may be trusted (spec localization, "Better than the
reports").

The rays of the four corners meet the plane at the tag's height; a rigid fit of the known square to the four points gives
x, y, yaw. PnP would have to find depth and tilt from a few pixels; here they are known. All tags of a frame are done at once.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from localization.calibration_jacobians import by_calibration, distortion
from localization.projection import CameraView, PlaneHits, PointsAtInfinityError
from localization.tags import tag_corners
from protocol.messages import CameraExtrinsics

Array = NDArray[np.float64]

Upper = tuple[float, float, float, float, float, float]
"""xx, xy, xyaw, yy, yyaw, yawyaw of a covariance (m^2, m rad, rad^2), as in the messages."""


class NotATagError(ValueError):
    """Four points on the plane that are not the square that the tag is; the text says by how much."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseNoise:
    """What limits a pose.

    `corner_px`: standard deviation of a corner, each axis, new in every frame. The rest is the same in every frame of one
    camera: `calibration`, the (10, 10) covariance of its extrinsics and lens (`extrinsics_covariance`); where that is not known
    (None), `calibration_px`, how far off the extrinsics put a point of the floor; `height_m`: how far off the tag's height was
    measured, which counts away from the camera's foot. `max_misfit`: how far the corners may be off the tag's square, relative
    to its size."""

    corner_px: float = 0.10
    calibration_px: float = 0.30
    height_m: float = 0.0015
    max_misfit: float = 0.05
    calibration: Array | None = field(default=None, repr=False)


_CALIBRATION_LEVER_M = 1.0
"""Extrinsics that shift the floor by s turn it by about s over the distance of the floor tags; this is less than that."""


@dataclass(frozen=True, slots=True, eq=False)
class TagPose:
    """T_map_tag in the plane of the tag and its covariance (3, 3) over x, y, yaw, of which `systematic` (3, 3) is the part
    that is the same in the next frame too; `misfit_m` is the RMS distance of the corners from the fitted square."""

    pose: SE2
    covariance: Array
    systematic: Array
    misfit_m: float


def tag_pose(view: CameraView, plane: Array, size_m: float, height_m: float, noise: PoseNoise) -> TagPose:
    """One tag of `tag_poses`, from its corners `plane` (4, 2). PointsAtInfinityError, NotATagError."""
    (found,) = tag_poses(view, plane[None], [size_m], [height_m], noise)
    if isinstance(found, TagPose):
        return found
    raise found


def tag_poses(
    view: CameraView, planes: Array, sizes_m: Sequence[float], heights_m: Sequence[float], noise: PoseNoise
) -> list[TagPose | NotATagError | PointsAtInfinityError]:
    """The poses from undistorted corners `planes` (N, 4, 2) of level tags of those sizes at those heights, each or why not.

    Pixel noise reaches x, y, yaw through the lens and the rays: each corner's 2x2 Jacobian grows with the depth and with the
    ray's obliqueness to the plane; the fit is linear in the corners near the solution. Errors of the calibration and of the
    height move all four corners together and go the same way (first-order propagation, Barfoot 2017, sec. 2.2.8).
    """
    count = len(planes)
    if count == 0:
        return []
    corners = planes.reshape(4 * count, 2)
    heights = np.repeat(np.asarray(heights_m, dtype=np.float64), 4)
    try:
        hits = view.hits(corners, heights)
    except PointsAtInfinityError as error:
        if count == 1:
            return [error]
        one_by_one = zip(planes, sizes_m, heights_m, strict=True)
        return [tag_poses(view, plane[None], [size], [height], noise)[0] for plane, size, height in one_by_one]
    sizes = np.asarray(sizes_m, dtype=np.float64)
    points = hits.points.reshape(count, 4, 2)
    centres = points.mean(axis=1)
    offsets = points - centres[:, None]
    squares = tag_corners(1.0) * sizes[:, None, None]
    # Procrustes in the plane: the yaw that turns the square onto the points in the least-squares sense.
    dot = (squares * offsets).sum(axis=(1, 2))
    cross = (squares[..., 0] * offsets[..., 1] - squares[..., 1] * offsets[..., 0]).sum(axis=1)
    yaws = np.arctan2(cross, dot)
    c, s = np.cos(yaws)[:, None], np.sin(yaws)[:, None]
    turned = np.empty_like(squares)
    turned[..., 0] = c * squares[..., 0] - s * squares[..., 1]
    turned[..., 1] = s * squares[..., 0] + c * squares[..., 1]
    misfits = np.sqrt(np.square(offsets - turned).sum(axis=2).mean(axis=1))
    # x, y are the mean of the corners; yaw is the mean of their displacements along the tangent, by the lever arm.
    gain = np.zeros((count, 3, 4, 2))
    gain[:, 0, :, 0] = gain[:, 1, :, 1] = 0.25
    lever2 = 2.0 * np.square(sizes)[:, None]
    gain[:, 2, :, 0], gain[:, 2, :, 1] = -turned[..., 1] / lever2, turned[..., 0] / lever2
    random, systematic = _covariances(view, corners, heights, hits, gain, noise)
    covariance = random + systematic
    return [
        TagPose(
            SE2(float(centres[i, 0]), float(centres[i, 1]), float(yaws[i])),
            covariance[i],
            systematic[i],
            float(misfits[i]),
        )
        if misfits[i] <= noise.max_misfit * sizes[i]
        else NotATagError(f"corners are {misfits[i] * 1e3:.1f} mm off a square of {sizes[i] * 1e3:.0f} mm")
        for i in range(count)
    ]


def _covariances(
    view: CameraView, corners: Array, heights: Array, hits: PlaneHits, gain: Array, noise: PoseNoise
) -> tuple[Array, Array]:
    """The random and the systematic covariance of the poses, (N, 3, 3) each. `gain` (N, 3, 4, 2) is how a pose moves with its
    corners on the plane."""
    count = len(gain)
    distorted, bend = distortion(view.model, corners)
    per_pixel = hits.jacobians @ bend / (view.model.fx, view.model.fy)
    flat = gain.reshape(count, 3, 8)
    through = noise.corner_px * (gain.transpose(0, 2, 1, 3) @ per_pixel.reshape(count, 4, 2, 2))
    through = through.transpose(0, 2, 1, 3).reshape(count, 3, 8)
    random = through @ through.transpose(0, 2, 1)
    lean = noise.height_m * (flat @ hits.slopes.reshape(count, 8, 1))
    systematic = lean @ lean.transpose(0, 2, 1)
    if noise.calibration is None:
        shift = noise.calibration_px * per_pixel.reshape(count, 4, 2, 2).mean(axis=1)
        systematic[:, :2, :2] += shift @ shift.transpose(0, 2, 1)
        systematic[:, 2, 2] += np.abs(np.linalg.det(shift)) / _CALIBRATION_LEVER_M**2
    else:
        moved = flat @ by_calibration(view, distorted, heights, hits, per_pixel).reshape(count, 8, 10)
        systematic += moved @ noise.calibration @ moved.transpose(0, 2, 1)
    return random, systematic


def extrinsics_covariance(extrinsics: CameraExtrinsics) -> Array | None:
    """The (10, 10) covariance that the message carries; None when it carries none. ValueError for another size."""
    if not extrinsics.covariance:
        return None
    rows, columns = np.triu_indices(10)
    if len(extrinsics.covariance) != len(rows):
        raise ValueError(
            f"extrinsics of {extrinsics.camera}: a covariance has {len(rows)} numbers, not {len(extrinsics.covariance)}"
        )
    covariance = np.zeros((10, 10))
    covariance[rows, columns] = covariance[columns, rows] = extrinsics.covariance
    return covariance


def vehicle_pose(tag: SE2, covariance: Array, T_vehicle_tag: SE2) -> tuple[SE2, Array]:
    """Pose and covariance (3, 3), or several (N, 3, 3), of the rotation centre of the vehicle that wears the tag; the offset
    turns yaw noise into position noise."""
    to_vehicle = T_vehicle_tag.inverse()
    pose = tag @ to_vehicle
    c, s = math.cos(tag.yaw), math.sin(tag.yaw)
    jacobian = np.eye(3)
    jacobian[0, 2] = -s * to_vehicle.x - c * to_vehicle.y
    jacobian[1, 2] = c * to_vehicle.x - s * to_vehicle.y
    return pose, jacobian @ covariance @ jacobian.T


def upper(covariance: Array) -> Upper:
    """The upper triangle of a (3, 3) covariance."""
    (xx, xy, xt), (_, yy, yt), (_, _, tt) = covariance.tolist()
    return (xx, xy, xt, yy, yt, tt)


def from_upper(values: Upper) -> Array:
    """The (3, 3) covariance of an upper triangle."""
    xx, xy, xt, yy, yt, tt = values
    return cast("Array", np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]]))
