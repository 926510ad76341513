"""What odometry says of a moment, for the Kalman filter: where it was, how the robot moved, and how little it says once it has
ended."""

import math

import numpy as np
from numpy.typing import NDArray

from agents.estimation.ekf_config import EkfConfig
from agents.estimation.ekf_model import Motion
from agents.estimation.history import OdometryHistory
from geometry import SE2

Array = NDArray[np.float64]

_AROUND_NS = 30_000_000
"""The velocity at a moment is taken from this much before and after it."""
_HOLD_S = 0.5
"""Without odometry the last twist is believed for this long."""
_LONGEST_S = 3600.0


def motion_around(history: OdometryHistory, stamp_ns: int, T_odom_robot: SE2) -> Motion:
    """How the robot moved at the moment, when odometry was at `T_odom_robot`; standing where odometry says nothing."""
    before = history.at(stamp_ns - _AROUND_NS) or T_odom_robot
    after = history.at(stamp_ns + _AROUND_NS) or T_odom_robot
    return Motion.between(before, after, 2 * _AROUND_NS / 1e9)


def odometry_at(history: OdometryHistory, stamp_ns: int, otherwise: SE2, config: EkfConfig) -> tuple[SE2, Array]:
    """T_odom_robot at the moment (`otherwise` where odometry does not reach back so far), and the covariance (3, 3) of what has
    happened since odometry was last heard: a constant unknown acceleration while its twist is held, then the whole of what
    that twist would have done."""
    newest = history.newest
    if newest is None or stamp_ns <= newest.stamp_ns:
        return history.at(stamp_ns) or otherwise, np.zeros((3, 3))
    silent_s = (stamp_ns - newest.stamp_ns) / 1e9
    held_s, beyond_s = min(silent_s, _HOLD_S), min(max(silent_s - _HOLD_S, 0.0), _LONGEST_S)
    linear, angular = newest.twist.linear_mps, newest.twist.angular_radps
    ahead = SE2.exp(held_s * linear, 0.0, held_s * angular)
    gained_s2 = 0.5 * held_s**2
    way = math.hypot(config.acceleration_mps2 * gained_s2, linear * beyond_s)
    turn = math.hypot(config.acceleration_radps2 * gained_s2, angular * beyond_s)
    return newest.pose @ ahead, np.diag([way**2, way**2, turn**2])
