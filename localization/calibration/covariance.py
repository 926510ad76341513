"""The covariance that travels with extrinsics: to and from its upper triangle."""

import numpy as np
from numpy.typing import NDArray

from protocol.messages import CameraExtrinsics

Array = NDArray[np.float64]

_SIZE = 10


def calibration_covariance(extrinsics: CameraExtrinsics) -> Array | None:
    """The (10, 10) covariance of (rotation, translation, fx, fy, cx, cy); None when the message has none. ValueError when it has
    another number of values than an upper triangle."""
    if not extrinsics.covariance:
        return None
    full = np.zeros((_SIZE, _SIZE))
    full[np.triu_indices(_SIZE)] = extrinsics.covariance
    return full + np.triu(full, 1).T


def upper_triangle(covariance: Array) -> tuple[float, ...]:
    """Row by row, 55 values."""
    return tuple(float(v) for v in covariance[np.triu_indices(_SIZE)])
