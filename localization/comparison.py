"""What a new calibration changes, in pixels at the floor tags and in metres on the floor: what a person decides by."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, SE3, CameraModel
from localization.calibration import FloorSighting, JointCalibration
from localization.projection import CameraView, extrinsics_pose, undistort
from localization.tags import tag_corners
from protocol.lab import Lab
from protocol.messages import CameraComparison, CameraExtrinsics, FloorTagComparison

Array = NDArray[np.float64]

_GRID = (9, 7)
"""Columns and rows of the pixels at which the floor is looked at, corners of the image included."""
_LEAST_DESCENT = 0.1
"""Rays that go down less steeply (sine of 6 degrees) meet the floor too far away to count as what the camera is there for."""
_PARAMETERS = 10
_STEPS = np.array([1e-6] * 6 + [1e-3] * 4)
"""Of the numeric derivative: rad and m, then pixels; far below what matters, far above rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class InUse:
    """What is in force before: extrinsics by camera, and T_map_tag of the floor tags as they are expected."""

    extrinsics: Mapping[str, CameraExtrinsics]
    floor_tags: Mapping[int, SE2]


def compare_cameras(
    lab: Lab, sightings: Sequence[FloorSighting], looked_anew: Collection[str], before: InUse, joint: JointCalibration
) -> dict[str, CameraComparison]:
    """By camera of the joint result. Every one of them must have its sighting among `sightings`."""
    seen = {sighting.camera: sighting for sighting in sightings}
    return {
        camera: _compare_camera(lab, seen[camera], camera in looked_anew, before, joint)
        for camera in sorted(joint.extrinsics)
    }


def compare_floor_tags(
    sightings: Sequence[FloorSighting], before: InUse, joint: JointCalibration
) -> dict[int, FloorTagComparison]:
    """By floor tag of the joint result."""
    return {
        tag: FloorTagComparison(
            shift_m=pose.distance_to(before.floor_tags[tag]) if tag in before.floor_tags else 0.0,
            cameras=tuple(sorted(sighting.camera for sighting in sightings if tag in sighting.corners)),
        )
        for tag, pose in sorted(joint.floor_tags.items())
    }


def corner_rms_px(
    lab: Lab,
    sighting: FloorSighting,
    extrinsics: CameraExtrinsics,
    floor_tags: Mapping[int, SE2],
    tags: Collection[int],
) -> float:
    """RMS distance of the corners seen of `tags` from where extrinsics and floor tags put them; 0 without any."""
    known = sorted(set(tags) & set(sighting.corners) & set(floor_tags))
    if not known:
        return 0.0
    view = CameraView(lab.camera(sighting.camera).model(), extrinsics_pose(extrinsics))
    square = tag_corners(lab.floor_tags.size_m)
    corners = np.concatenate([floor_tags[tag].apply(square) for tag in known])
    expected, _ = view.project(np.column_stack([corners, np.zeros(len(corners))]))
    seen = np.concatenate([sighting.corners[tag] for tag in known])
    return float(np.sqrt(np.square(expected - seen).sum(axis=1).mean()))


def floor_shift_m(model: CameraModel, before: SE3, after: SE3) -> tuple[float, float]:
    """Mean and greatest distance between the floor points that the same pixels show by two poses T_map_camera; (0, 0) for a
    camera that sees no floor by both."""
    plane = undistort(model, _pixels(model))
    plane = plane[_comes_down(plane, before) & _comes_down(plane, after)]
    if not len(plane):
        return 0.0, 0.0
    moved = CameraView(model, after).hits(plane, 0.0).points - CameraView(model, before).hits(plane, 0.0).points
    distances = np.linalg.norm(moved, axis=1)
    return float(distances.mean()), float(distances.max())


def floor_std_m(model: CameraModel, extrinsics: CameraExtrinsics) -> float | None:
    """Standard deviation (RMS over the floor in view, both axes together) of floor points that the calibration leaves open:
    J P J^T with the Jacobian J of the point by rotation, translation and the four intrinsics, taken numerically. None when
    the covariance is not known or no floor is in view."""
    if len(extrinsics.covariance) != _PARAMETERS * (_PARAMETERS + 1) // 2:
        return None
    covariance = np.zeros((_PARAMETERS, _PARAMETERS))
    rows, columns = np.triu_indices(_PARAMETERS)
    covariance[rows, columns] = covariance[columns, rows] = extrinsics.covariance
    pose, pixels = extrinsics_pose(extrinsics), _pixels(model)
    pixels = pixels[_comes_down(undistort(model, pixels), pose)]
    if not len(pixels):
        return None
    jacobian = np.stack(
        [
            (_shifted(model, pose, pixels, index, step) - _shifted(model, pose, pixels, index, -step)) / (2 * step)
            for index, step in enumerate(_STEPS)
        ],
        axis=2,
    )
    variances = np.einsum("nip,pq,niq->n", jacobian, covariance, jacobian)
    return float(np.sqrt(max(0.0, float(variances.mean()))))


def _compare_camera(
    lab: Lab, sighting: FloorSighting, is_new: bool, before: InUse, joint: JointCalibration
) -> CameraComparison:
    model, after = lab.camera(sighting.camera).model(), joint.extrinsics[sighting.camera]
    old = before.extrinsics.get(sighting.camera)
    pose = extrinsics_pose(after)
    old_pose = None if old is None else extrinsics_pose(old)
    shift = None if old_pose is None else floor_shift_m(model, old_pose, pose)
    return CameraComparison(
        is_new=is_new,
        frames=sighting.frames,
        corner_noise_px=sighting.corner_noise_px,
        floor_tags=after.floor_tags,
        left_out=joint.left_out.get(sighting.camera, ()),
        reprojection_before_px=None
        if old is None
        else corner_rms_px(lab, sighting, old, before.floor_tags, after.floor_tags),
        reprojection_after_px=corner_rms_px(lab, sighting, after, joint.floor_tags, after.floor_tags),
        floor_shift_mean_m=None if shift is None else shift[0],
        floor_shift_max_m=None if shift is None else shift[1],
        camera_moved_m=None if old_pose is None else float(np.linalg.norm(pose.translation - old_pose.translation)),
        camera_turned_rad=None if old_pose is None else pose.angle_to(old_pose),
        floor_std_before_m=None if old is None else floor_std_m(model, old),
        floor_std_after_m=floor_std_m(model, after),
    )


def _pixels(model: CameraModel) -> Array:
    """Pixels over the whole image, shape (N, 2)."""
    columns, rows = _GRID
    u, v = np.meshgrid(np.linspace(0.0, model.width - 1, columns), np.linspace(0.0, model.height - 1, rows))
    return np.column_stack([u.ravel(), v.ravel()])


def _comes_down(plane: Array, T_map_camera: SE3) -> NDArray[np.bool_]:
    """Whether the rays through undistorted points (N, 2) meet the floor in front of the camera and not far away."""
    rays = np.column_stack([plane, np.ones(len(plane))])
    down = -(rays @ T_map_camera.rotation[2])
    return down > _LEAST_DESCENT * np.linalg.norm(rays, axis=1)


def _shifted(model: CameraModel, pose: SE3, pixels: Array, parameter: int, step: float) -> Array:
    """Floor points of the pixels, shape (N, 2), with one of the ten parameters changed (order of `CameraExtrinsics`)."""
    change = np.zeros(_PARAMETERS)
    change[parameter] = step
    turned = SE3.from_rotvec(change[:3], np.zeros(3)).rotation @ pose.rotation
    fx, fy, cx, cy = (float(v) for v in change[6:])
    changed = replace(model, fx=model.fx + fx, fy=model.fy + fy, cx=model.cx + cx, cy=model.cy + cy)
    view = CameraView(changed, SE3(turned, pose.translation + change[3:6]))
    return view.hits(undistort(changed, pixels), 0.0).points
