"""SE(3): poses and rigid motions in space, with the naming of `geometry.se2` (`T_a_b` maps points of b into a)."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.se2 import SE2

_SMALL_ANGLE_RAD = 1e-7
_ORTHONORMAL_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class SE3:
    """A pose in space: `rotation` (3, 3), orthonormal with determinant 1; `translation` (3,) in metres; read-only."""

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    def __post_init__(self) -> None:
        rotation = np.array(self.rotation, dtype=np.float64)
        translation = np.array(self.translation, dtype=np.float64)
        if rotation.shape != (3, 3) or translation.shape != (3,):
            raise ValueError(f"SE3 wants shapes (3, 3) and (3,), got {rotation.shape} and {translation.shape}")
        if not (np.isfinite(rotation).all() and np.isfinite(translation).all()):
            raise ValueError("a pose must be finite")
        error = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
        if error > _ORTHONORMAL_TOLERANCE or np.linalg.det(rotation) < 0:
            raise ValueError(f"not a rotation matrix (orthonormality error {error:.2g})")
        rotation.setflags(write=False)
        translation.setflags(write=False)
        object.__setattr__(self, "rotation", rotation)
        object.__setattr__(self, "translation", translation)

    @classmethod
    def identity(cls) -> Self:
        return cls(np.eye(3), np.zeros(3))

    @classmethod
    def from_rotvec(cls, rotvec: ArrayLike, translation: ArrayLike) -> Self:
        """From a rotation vector (3,) (axis times angle in radians) and a translation (3,) in metres."""
        return cls(
            _rotation_from_rotvec(np.asarray(rotvec, dtype=np.float64)), np.asarray(translation, dtype=np.float64)
        )

    @classmethod
    def from_se2(cls, pose: SE2, z: float = 0.0) -> Self:
        """A planar pose lifted to height `z` (metres)."""
        rotation = np.eye(3)
        rotation[:2, :2] = pose.as_matrix()[:2, :2]
        return cls(rotation, np.array([pose.x, pose.y, z]))

    def rotvec(self) -> NDArray[np.float64]:
        """Axis times angle, shape (3,), angle within [0, pi]."""
        return _rotvec_from_rotation(self.rotation)

    def to_se2(self) -> SE2:
        """The pose seen from above: x, y and the heading of the inner frame's x axis."""
        return SE2(
            float(self.translation[0]),
            float(self.translation[1]),
            math.atan2(float(self.rotation[1, 0]), float(self.rotation[0, 0])),
        )

    def __matmul__(self, other: "SE3") -> "SE3":
        return SE3(_orthonormal(self.rotation @ other.rotation), self.rotation @ other.translation + self.translation)

    def inverse(self) -> "SE3":
        return SE3(self.rotation.T, -self.rotation.T @ self.translation)

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Maps points of shape (N, 3) or (3,), in metres, from the inner frame to the outer one; keeps the shape."""
        array = np.asarray(points, dtype=np.float64)
        if array.shape[-1] != 3:
            raise ValueError(f"points must have shape (..., 3), got {array.shape}")
        return array @ self.rotation.T + self.translation

    def as_matrix(self) -> NDArray[np.float64]:
        """The homogeneous matrix, shape (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self.translation
        return matrix

    def angle_to(self, other: "SE3") -> float:
        """The angle in radians, within [0, pi], of the rotation between the two poses."""
        return float(np.linalg.norm(_rotvec_from_rotation(self.rotation.T @ other.rotation)))


def _rotation_from_rotvec(rotvec: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rodrigues' formula."""
    angle = float(np.linalg.norm(rotvec))
    x, y, z = (float(value) for value in rotvec)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < _SMALL_ANGLE_RAD:
        return _orthonormal(np.eye(3) + skew + 0.5 * skew @ skew)
    return np.eye(3) + math.sin(angle) / angle * skew + (1.0 - math.cos(angle)) / angle**2 * skew @ skew


def _rotvec_from_rotation(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """By way of the unit quaternion, which stays well conditioned near half a turn."""
    m = rotation
    # Four times the squares of the quaternion's components; the largest one is divided by (Shepperd's method).
    squares = np.array(
        [
            1.0 + m[0, 0] + m[1, 1] + m[2, 2],
            1.0 + m[0, 0] - m[1, 1] - m[2, 2],
            1.0 - m[0, 0] + m[1, 1] - m[2, 2],
            1.0 - m[0, 0] - m[1, 1] + m[2, 2],
        ]
    )
    products = {
        0: (m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]),
        1: (m[2, 1] - m[1, 2], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0]),
        2: (m[0, 2] - m[2, 0], m[1, 0] + m[0, 1], m[2, 1] + m[1, 2]),
        3: (m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[2, 1] + m[1, 2]),
    }
    largest = int(np.argmax(squares))
    others = products[largest]
    parts = [others[0], others[1], others[2]]
    parts.insert(largest, squares[largest])
    quaternion = np.array(parts) / (2.0 * math.sqrt(squares[largest]))
    if quaternion[0] < 0:
        quaternion = -quaternion
    vector = quaternion[1:]
    sine = float(np.linalg.norm(vector))
    angle = 2.0 * math.atan2(sine, float(quaternion[0]))
    # For small angles angle / sine tends to 2.
    return vector * (2.0 if sine < _SMALL_ANGLE_RAD else angle / sine)


def _orthonormal(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nearest rotation matrix, so that long chains of products do not drift off SO(3)."""
    u, _, vt = np.linalg.svd(rotation)
    return u @ vt
