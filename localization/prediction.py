"""Where a tracked vehicle is at another time than its pose says: constant speed and turn rate. How old
a pose may be is its user's to say; `is_fresh` is the limit for looking for a tag."""

import math

from geometry import SE2
from protocol.lab import Limits
from protocol.messages import TrackedPose

MAX_GAP_S = 0.5
"""A pose older than this is no longer a track (spec localization: a track is lost after 0.5 s)."""
_SIGMAS = 3.0


def pose_at(pose: TrackedPose, stamp_ns: int) -> SE2:
    """The pose moved along its arc to `stamp_ns`: the velocity turns with the yaw rate, its middle direction counts."""
    dt = (stamp_ns - pose.stamp_ns) * 1e-9
    c, s = math.cos(pose.yaw_rate * dt / 2), math.sin(pose.yaw_rate * dt / 2)
    dx, dy = (c * pose.vx - s * pose.vy) * dt, (s * pose.vx + c * pose.vy) * dt
    return SE2(pose.x + dx, pose.y + dy, pose.yaw + pose.yaw_rate * dt)


def is_fresh(pose: TrackedPose, stamp_ns: int) -> bool:
    """Whether the pose may still be extrapolated to `stamp_ns`."""
    return abs(stamp_ns - pose.stamp_ns) <= MAX_GAP_S * 1e9


def uncertainty_m(pose: TrackedPose, stamp_ns: int, limits: Limits) -> float:
    """How far from `pose_at` the vehicle may be: its covariance, and braking or pulling away since then."""
    dt = abs(stamp_ns - pose.stamp_ns) * 1e-9
    sigma = max(pose.covariance[0], pose.covariance[3], 0.0) ** 0.5
    return _SIGMAS * sigma + 0.5 * max(limits.braking_mps2, limits.acceleration_mps2) * dt**2
