"""What one camera says of a vehicle in one frame, taken apart into what is new in every frame and what is not."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from localization.tag_pose import Upper, from_upper, vehicle_pose
from protocol.lab import VehicleSpec
from protocol.messages import Detection, FrameDetections

Array = NDArray[np.float64]

_LEAST_M, _LEAST_RAD = 1e-5, 1e-5
"""Nothing is surer than that; it keeps noise invertible where a detection says that all of it is systematic."""
_ROUNDING = 1e-5
"""A standard deviation this small beside the whole is not worth a factor: rounding could have left it of none."""


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """A vehicle's pose (3,) as one camera saw it at a capture time. `noise` (3, 3) is the covariance of what is new in this
    frame, `bias` (3, 3), lower triangular, the factor of what all of the camera's frames share: bias bias^T is its covariance."""

    camera: str
    stamp_ns: int
    pose: Array
    noise: Array
    bias: Array

    @property
    def covariance(self) -> Array:
        """Both together, (3, 3)."""
        return self.noise + self.bias @ self.bias.T


def sight_of(vehicle: VehicleSpec, detection: Detection, frame: FrameDetections) -> Sight:
    """The rotation centre's pose from its tag's."""
    both = np.array([from_upper(detection.covariance), from_upper(detection.systematic)])
    pose, (covariance, systematic) = vehicle_pose(
        SE2(detection.x, detection.y, detection.yaw), both, vehicle.tag.pose_on_vehicle()
    )
    noise = covariance - systematic
    noise[0, 0] += _LEAST_M**2
    noise[1, 1] += _LEAST_M**2
    noise[2, 2] += _LEAST_RAD**2
    return Sight(frame.camera, frame.stamp_ns, np.array([pose.x, pose.y, pose.yaw]), noise, cholesky(systematic))


def is_usable(detection: Detection) -> bool:
    """Finite, with a covariance that is one, no smaller than its systematic part."""
    numbers = (detection.x, detection.y, detection.yaw, *detection.covariance, *detection.systematic)
    if not all(map(math.isfinite, numbers)):
        return False
    a, b, c, d, e, f = (whole - part for whole, part in zip(detection.covariance, detection.systematic, strict=True))
    slack = 1e-9 * max(detection.covariance)  # all of it may be systematic, but for rounding
    return _least_minor(detection.covariance) > 0.0 and _least_minor((a + slack, b, c, d + slack, e, f + slack)) > 0.0


def cholesky(covariance: Array) -> Array:
    """The lower triangular factor (3, 3) of a covariance that may be singular: what has no variance gets no factor. In plain
    numbers, a call of LAPACK takes several times as long."""
    (a, _, _), (b, d, _), (c, e, f) = covariance.tolist()
    l00 = math.sqrt(max(a, 0.0))
    l10, l20 = (b / l00, c / l00) if l00 > 0 else (0.0, 0.0)
    l11 = math.sqrt(max(d - l10 * l10, 0.0))
    l21 = (e - l20 * l10) / l11 if l11 > _ROUNDING * math.sqrt(max(d, 0.0)) else 0.0
    l22 = math.sqrt(max(f - l20 * l20 - l21 * l21, 0.0))
    return np.array([[l00, 0.0, 0.0], [l10, l11, 0.0], [l20, l21, l22]])


def _least_minor(values: Upper) -> float:
    """The least of the leading principal minors: positive for a positive definite matrix alone (Sylvester's criterion)."""
    a, b, c, d, e, f = values
    return min(a, a * d - b * b, a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d))
