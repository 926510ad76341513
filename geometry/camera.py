"""The pinhole camera with Brown-Conrady distortion, as data.

Only the parameters live here. Projection and its inverse belong to their users, who implement them apart: the simulated
lab must not share an error with the estimator that it tests.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class CameraModel:
    """Image size in pixels, focal lengths and principal point in pixels (the first pixel's centre is (0, 0)), and the
    distortion coefficients k1, k2, p1, p2, k3 in OpenCV's order."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if self.width <= 0 or self.height <= 0:
            raise ValueError(f"an image of {self.width} x {self.height} pixels does not exist")
        if not (self.fx > 0 and self.fy > 0):
            raise ValueError(f"focal lengths must be positive, got {self.fx} and {self.fy}")
        if not all(math.isfinite(v) for v in (self.fx, self.fy, self.cx, self.cy, *self.distortion)):
            raise ValueError("camera parameters must be finite")

    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix K, shape (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def distortion_array(self) -> NDArray[np.float64]:
        """k1, k2, p1, p2, k3 as an array of shape (5,)."""
        return np.array(self.distortion)
