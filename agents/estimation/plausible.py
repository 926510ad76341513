"""What may enter an estimator: numbers that are numbers, within what any floor and any base can be."""

import math

from agents.drivers.driver import OdometryReading
from protocol.messages import TrackedPose

_FAR = 1e6
"""Metres, radians; variances too. No floor is larger, and squares of it are far from overflow."""
_FASTEST = 100.0
"""m/s and rad/s."""
_ROUNDING = 1e-6


def is_plausible_pose(pose: TrackedPose) -> bool:
    """Finite, near enough, with a covariance that is one (no negative direction)."""
    numbers = (pose.x, pose.y, pose.yaw, *pose.covariance)
    return all(math.isfinite(number) and abs(number) <= _FAR for number in numbers) and _is_semidefinite(
        pose.covariance
    )


def is_plausible_odometry(reading: OdometryReading) -> bool:
    """Near enough and slow enough; poses and twists are finite by their own constructors."""
    pose, twist = reading.pose, reading.twist
    near = abs(pose.x) <= _FAR and abs(pose.y) <= _FAR
    return near and abs(twist.linear_mps) <= _FASTEST and abs(twist.angular_radps) <= _FASTEST


def _is_semidefinite(covariance: tuple[float, float, float, float, float, float]) -> bool:
    """Sylvester's criterion on all principal minors, with room for rounding."""
    xx, xy, xt, yy, yt, tt = covariance
    if min(xx, yy, tt) < 0.0:
        return False
    pairs = ((xx, yy, xy), (xx, tt, xt), (yy, tt, yt))
    if any(a * b - c * c < -_ROUNDING * a * b for a, b, c in pairs):
        return False
    determinant = xx * (yy * tt - yt * yt) - xy * (xy * tt - yt * xt) + xt * (xy * yt - yy * xt)
    return determinant >= -_ROUNDING * xx * yy * tt
