"""Bundle adjustment over cameras and floor tags: what explains every corner seen and every measure taken, weighed by how well
each is known (Triggs et al., "Bundle Adjustment - A Modern Synthesis", 2000, sections 3 and 4).

Unknowns are each camera's pose (left perturbation of its rotation, translation) and lens (relative focal length, principal
point), each floor tag's x, y, yaw, and one scale for the size that all tags were printed in. Corners in the images pull at
them, and so do the lab description's measures: maximum a posteriori, by Levenberg-Marquardt.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE2, SE3, CameraModel, wrap_angle
from localization.tags import tag_corners
from protocol.lab import Accuracy

Array = NDArray[np.float64]

_PRINT_SCALE = 0.002
"""Relative standard deviation of the printed size of all floor tags together: printers stretch paper by about that."""
_FREE_M, _FREE_RAD = 100.0, 10.0
"""The prior of a tag whose place is not believed: it may lie anywhere."""
_CAMERA, _LENS, _TAG = 6, 3, 3
_MOST_STEPS = 60
_SETTLED = 1e-9
"""Relative change of the cost at which the adjustment is done."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenTags:
    """One camera's part of the problem: `image` (4 n, 2), pixels, has the corners of `tags` (n ids) one after another,
    `sigma_px` is their standard deviation per axis."""

    camera: str
    model: CameraModel
    tags: tuple[int, ...]
    image: Array
    sigma_px: float

    @property
    def corners(self) -> dict[int, Array]:
        """The corners by tag, (4, 2) each."""
        return {tag: self.image[4 * k : 4 * k + 4] for k, tag in enumerate(self.tags)}


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """A hypothesis: T_map_camera and lens by camera, T_map_tag by floor tag, and the printed size relative to the nominal."""

    poses: Mapping[str, SE3]
    lenses: Mapping[str, CameraModel]
    tags: Mapping[int, SE2]
    print_scale: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Adjusted:
    """The most probable room. `cost` is the sum of the squared weighted residuals; `covariances` (9, 9) by camera are over
    (rotation, translation, relative focal length, cx, cy), `tag_covariances` (3, 3) over x, y, yaw."""

    room: Room
    cost: float
    covariances: Mapping[str, Array]
    tag_covariances: Mapping[int, Array]


class Adjustment:
    """The least-squares problem of one connected group of cameras. `measured` are the floor tags as described, `free` those of
    them whose measured place is not to be believed."""

    def __init__(
        self,
        cameras: Sequence[SeenTags],
        measured: Mapping[int, SE2],
        size_m: float,
        accuracy: Accuracy,
        free: Collection[int] = (),
    ) -> None:
        self._cameras = cameras
        self._square = tag_corners(size_m)
        self._accuracy = accuracy
        self._tags = sorted({tag for camera in cameras for tag in camera.tags})
        self._measured = {tag: measured[tag] for tag in self._tags}
        self._first_tag = (_CAMERA + _LENS) * len(cameras)
        self._column = {tag: self._first_tag + _TAG * k for k, tag in enumerate(self._tags)}
        self._unknowns = self._first_tag + _TAG * len(self._tags) + 1
        lens = [1.0 / accuracy.focal, 1.0 / accuracy.center_px, 1.0 / accuracy.center_px]
        known = [1.0 / accuracy.floor_tag_m, 1.0 / accuracy.floor_tag_m, 1.0 / accuracy.floor_tag_rad]
        unknown = [1.0 / _FREE_M, 1.0 / _FREE_M, 1.0 / _FREE_RAD]
        self._lens_weights = np.array(lens)
        self._tag_weights = {tag: np.array(unknown if tag in free else known) for tag in self._tags}

    def solve(self, start: Mapping[str, SE3]) -> Adjusted:
        """The most probable room near the poses `start`. numpy.linalg.LinAlgError when something is left undetermined."""
        room = Room(start, {camera.camera: camera.model for camera in self._cameras}, self._measured)
        residuals, jacobian = self._linearize(room)
        cost, damping = float(residuals @ residuals), 1e-4
        for _ in range(_MOST_STEPS):
            normal = jacobian.T @ jacobian
            damped = normal + damping * np.diag(np.diag(normal))
            step = np.linalg.solve(damped, -jacobian.T @ residuals).astype(np.float64)
            candidate = self._moved(room, step)
            new_residuals, new_jacobian = self._linearize(candidate)
            new_cost = float(new_residuals @ new_residuals)
            if not new_cost < cost:
                if damping > 1e8:
                    break
                damping *= 10.0
                continue
            settled = cost - new_cost <= _SETTLED * cost
            room, residuals, jacobian, cost = candidate, new_residuals, new_jacobian, new_cost
            damping = max(1e-12, 0.1 * damping)
            if settled:
                break
        return self._adjusted(room, cost, np.linalg.inv(jacobian.T @ jacobian).astype(np.float64))

    def _adjusted(self, room: Room, cost: float, covariance: Array) -> Adjusted:
        cameras = len(self._cameras)
        by_camera: dict[str, Array] = {}
        for k, seen in enumerate(self._cameras):
            pose = np.arange(_CAMERA * k, _CAMERA * (k + 1))
            lens = _CAMERA * cameras + np.arange(_LENS * k, _LENS * (k + 1))
            own = np.concatenate([pose, lens])
            by_camera[seen.camera] = covariance[np.ix_(own, own)]
        by_tag = {tag: covariance[c : c + _TAG, c : c + _TAG] for tag, c in self._column.items()}
        return Adjusted(room, cost, by_camera, by_tag)

    def _moved(self, room: Room, step: Array) -> Room:
        """The room after a step in all unknowns."""
        cameras = len(self._cameras)
        poses: dict[str, SE3] = {}
        lenses: dict[str, CameraModel] = {}
        for k, seen in enumerate(self._cameras):
            poses[seen.camera] = perturbed(room.poses[seen.camera], step[_CAMERA * k : _CAMERA * (k + 1)])
            focal, cx, cy = (float(v) for v in step[_CAMERA * cameras + _LENS * k :][:_LENS])
            old, nominal = room.lenses[seen.camera], seen.model
            lenses[seen.camera] = replace(
                old, fx=old.fx + focal * nominal.fx, fy=old.fy + focal * nominal.fy, cx=old.cx + cx, cy=old.cy + cy
            )
        tags: dict[int, SE2] = {}
        for tag, column in self._column.items():
            dx, dy, dyaw = (float(v) for v in step[column : column + _TAG])
            old = room.tags[tag]
            tags[tag] = SE2(old.x + dx, old.y + dy, old.yaw + dyaw)
        return Room(poses, lenses, tags, room.print_scale + float(step[-1]))

    def _linearize(self, room: Room) -> tuple[Array, Array]:
        """Weighted residuals (M,) and their derivatives (M, unknowns) at a room."""
        rows = [self._corner_rows(k, seen, room) for k, seen in enumerate(self._cameras)]
        rows += [self._lens_rows(k, seen, room) for k, seen in enumerate(self._cameras)]
        rows += [self._tag_rows(tag, room) for tag in self._tags]
        scale = np.zeros((1, self._unknowns))
        scale[0, -1] = 1.0 / _PRINT_SCALE
        rows.append((np.array([(room.print_scale - 1.0) / _PRINT_SCALE]), scale))
        return np.concatenate([residuals for residuals, _ in rows]), np.concatenate([slopes for _, slopes in rows])

    def _corner_rows(self, k: int, seen: SeenTags, room: Room) -> tuple[Array, Array]:
        pose, lens = room.poses[seen.camera], room.lenses[seen.camera]
        turned = np.concatenate([SE2(0.0, 0.0, room.tags[tag].yaw).apply(self._square) for tag in seen.tags])
        places = np.repeat([(room.tags[tag].x, room.tags[tag].y) for tag in seen.tags], 4, axis=0)
        points = np.column_stack([places + room.print_scale * turned, np.zeros(len(turned))])
        arms = points - pose.translation
        in_camera = arms @ pose.rotation
        if float(in_camera[:, 2].min()) < 1e-3:  # behind the camera: a step too far
            return np.full(2 * len(points), 1e6), np.zeros((2 * len(points), self._unknowns))
        nothing = np.zeros(3)
        raw, raw_slopes = cv2.projectPoints(in_camera, nothing, nothing, lens.matrix(), lens.distortion_array())
        per_camera_point = raw_slopes[:, 3:6].reshape(-1, 2, 3)
        per_point = per_camera_point @ pose.rotation.T
        jacobian = np.zeros((len(points), 2, self._unknowns))
        first = _CAMERA * k
        jacobian[:, :, first : first + 3] = per_point @ _skew(arms)
        jacobian[:, :, first + 3 : first + 6] = -per_point
        first = _CAMERA * len(self._cameras) + _LENS * k
        by_lens = raw_slopes[:, 6:10].reshape(-1, 2, 4)
        jacobian[:, :, first] = by_lens[:, :, 0] * seen.model.fx + by_lens[:, :, 1] * seen.model.fy
        jacobian[:, :, first + 1 : first + 3] = by_lens[:, :, 2:4]
        across = room.print_scale * np.column_stack([-turned[:, 1], turned[:, 0]])
        for n, tag in enumerate(seen.tags):
            own, column = slice(4 * n, 4 * n + 4), self._column[tag]
            jacobian[own, :, column : column + 2] = per_point[own, :, :2]
            jacobian[own, :, column + 2] = np.einsum("aij,aj->ai", per_point[own, :, :2], across[own])
        jacobian[:, :, -1] = np.einsum("aij,aj->ai", per_point[:, :, :2], turned)
        residuals = (raw.reshape(-1, 2) - seen.image).reshape(-1) / seen.sigma_px
        return residuals, jacobian.reshape(-1, self._unknowns) / seen.sigma_px

    def _lens_rows(self, k: int, seen: SeenTags, room: Room) -> tuple[Array, Array]:
        lens, nominal = room.lenses[seen.camera], seen.model
        first = _CAMERA * len(self._cameras) + _LENS * k
        slopes = np.zeros((_LENS, self._unknowns))
        slopes[:, first : first + _LENS] = np.diag(self._lens_weights)
        off = np.array([lens.fx / nominal.fx - 1.0, lens.cx - nominal.cx, lens.cy - nominal.cy])
        return off * self._lens_weights, slopes

    def _tag_rows(self, tag: int, room: Room) -> tuple[Array, Array]:
        weights, column = self._tag_weights[tag], self._column[tag]
        slopes = np.zeros((_TAG, self._unknowns))
        slopes[:, column : column + _TAG] = np.diag(weights)
        now, measured = room.tags[tag], self._measured[tag]
        off = np.array([now.x - measured.x, now.y - measured.y, wrap_angle(now.yaw - measured.yaw)])
        return off * weights, slopes


def perturbed(pose: SE3, step: Array) -> SE3:
    """The pose with its rotation turned by exp(step[:3]) from the left and shifted by step[3:6] (rad, m, map frame)."""
    turn = SE3.from_rotvec(step[:3], np.zeros(3))
    return SE3((turn @ SE3(pose.rotation, np.zeros(3))).rotation, pose.translation + step[3:6])


def _skew(vectors: Array) -> Array:
    """(N, 3) to the matrices (N, 3, 3) of their cross products."""
    x, y, z = vectors.T
    zero = np.zeros(len(vectors))
    return cast("Array", np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3))
