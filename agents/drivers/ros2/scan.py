"""What a base's laser scan says: its echoes in the robot's frame, and the way ahead. Pure geometry."""

from collections.abc import Sequence

import numpy as np

from agents.drivers.ros2.config import Ros2DriverConfig
from agents.protection import RangeScan
from protocol.ros2.interfaces import LaserScan

_BEHIND_FRONT_M = 0.05
"""What lies this little behind the robot's front is still ahead (a scanner at the front has its errors); the rest of its own
footprint is the robot itself."""


def range_scan(scan: LaserScan, config: Ros2DriverConfig) -> RangeScan:
    """The echoes in the robot's frame."""
    return RangeScan.polar(
        scan.header.stamp.stamp_ns,
        np.asarray(scan.ranges, float),
        angle_min=scan.angle_min,
        angle_increment=scan.angle_increment,
        range_min_m=scan.range_min,
        range_max_m=scan.range_max,
        T_robot_scanner=config.T_robot_scanner,
    )


def front_range_m(scan: RangeScan, config: Ros2DriverConfig) -> float | None:
    """The distance from the robot's front to the nearest thing in its lane, 0 where it touches; None when there is nothing."""
    x, y = scan.points[:, 0], scan.points[:, 1]
    ahead = (x >= config.front_m - _BEHIND_FRONT_M) & (np.abs(y) <= config.half_width_m)
    return max(0.0, float(np.min(x[ahead])) - config.front_m) if np.any(ahead) else None


def is_sound(scan: LaserScan) -> bool:
    """Whether the scan's own numbers can be used at all."""
    numbers: Sequence[float] = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
    return bool(np.all(np.isfinite(numbers))) and bool(scan.ranges) and 0.0 <= scan.range_min < scan.range_max


def is_blind(scan: LaserScan) -> bool:
    """Whether every beam says 0 or no number: a scanner that is covered or broken. One that sees a wide floor says infinity
    (REP 117), or something beyond its reach."""
    ranges = np.asarray(scan.ranges, float)
    return bool(np.all((ranges == 0.0) | np.isnan(ranges)))
