"""SE(2): poses and rigid motions in the plane.

`T_a_b` is the pose of frame b seen from frame a; it maps points given in b to points given in a, so
`T_a_b @ T_b_c` is `T_a_c`.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.angles import wrap_angle

_SMALL_ANGLE_RAD = 1e-6
"""Below this the quotients sin(a)/a and (1-cos(a))/a are taken from their Taylor series."""


@dataclass(frozen=True, slots=True)
class SE2:
    """A pose in the plane: x, y in metres, yaw in radians, counter-clockwise, within (-pi, pi]."""

    x: float
    y: float
    yaw: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x) and math.isfinite(self.y) and math.isfinite(self.yaw)):
            raise ValueError(f"a pose must be finite, got ({self.x}, {self.y}, {self.yaw})")
        object.__setattr__(self, "yaw", wrap_angle(self.yaw))

    @classmethod
    def identity(cls) -> Self:
        return cls(0.0, 0.0, 0.0)

    @classmethod
    def exp(cls, vx: float, vy: float, omega: float) -> Self:
        """The motion of a body that holds the twist (vx, vy in m/s, omega in rad/s) for one second."""
        s, c = _sinc_pair(omega)
        return cls(s * vx - c * vy, c * vx + s * vy, omega)

    def log(self) -> tuple[float, float, float]:
        """The twist (vx, vy, omega) that reaches this pose in one second; the inverse of `exp`."""
        s, c = _sinc_pair(self.yaw)
        scale = 1.0 / (s * s + c * c)
        return ((s * self.x + c * self.y) * scale, (-c * self.x + s * self.y) * scale, self.yaw)

    def __matmul__(self, other: "SE2") -> "SE2":
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return SE2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            self.yaw + other.yaw,
        )

    def inverse(self) -> "SE2":
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return SE2(-c * self.x - s * self.y, s * self.x - c * self.y, -self.yaw)

    def between(self, other: "SE2") -> "SE2":
        """`other` seen from this pose."""
        return self.inverse() @ other

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Maps points of shape (N, 2) or (2,), in metres, from the inner frame to the outer one; keeps the shape."""
        array = np.asarray(points, dtype=np.float64)
        if array.shape[-1] != 2:
            raise ValueError(f"points must have shape (..., 2), got {array.shape}")
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return array @ np.array([[c, s], [-s, c]]) + np.array([self.x, self.y])

    def as_matrix(self) -> NDArray[np.float64]:
        """The homogeneous matrix, shape (3, 3)."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return np.array([[c, -s, self.x], [s, c, self.y], [0.0, 0.0, 1.0]])

    def distance_to(self, other: "SE2") -> float:
        """Euclidean distance of the two positions in metres."""
        return math.hypot(other.x - self.x, other.y - self.y)


def _sinc_pair(angle: float) -> tuple[float, float]:
    """sin(a)/a and (1 - cos(a))/a, the latter as 2 sin(a/2)^2 / a, which loses no digits at small angles."""
    if abs(angle) < _SMALL_ANGLE_RAD:
        return 1.0 - angle * angle / 6.0, angle / 2.0
    return math.sin(angle) / angle, 2.0 * math.sin(angle / 2.0) ** 2 / angle
