"""What a laser scan says of the way ahead: pure geometry."""

from collections.abc import Sequence

import numpy as np

from agents.drivers.ros2.config import Ros2DriverConfig
from protocol.ros2.interfaces import LaserScan

_BEHIND_FRONT_M = 0.05
"""What lies this little behind the robot's front is still ahead (a scanner at the front has its errors); the rest of its own
footprint is the robot itself."""


def front_range_m(scan: LaserScan, config: Ros2DriverConfig) -> float | None:
    """The distance from the robot's front to the nearest thing in its lane, 0 where it touches; None when there is nothing.
    Ranges that are no numbers, or outside of what the scanner can measure, say nothing."""
    ranges = np.asarray(scan.ranges, float)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges)) + config.T_robot_scanner.yaw
    with np.errstate(invalid="ignore"):
        measured = np.isfinite(ranges) & (ranges >= scan.range_min) & (ranges <= scan.range_max) & np.isfinite(angles)
    r, a = ranges[measured], angles[measured]
    x = config.T_robot_scanner.x + r * np.cos(a)
    y = config.T_robot_scanner.y + r * np.sin(a)
    ahead = (x >= config.front_m - _BEHIND_FRONT_M) & (np.abs(y) <= config.half_width_m)
    return max(0.0, float(np.min(x[ahead])) - config.front_m) if np.any(ahead) else None


def is_sound(scan: LaserScan) -> bool:
    """Whether the scan's own numbers can be used at all."""
    numbers: Sequence[float] = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
    return bool(np.all(np.isfinite(numbers))) and bool(scan.ranges)
