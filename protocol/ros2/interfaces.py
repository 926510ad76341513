"""The ROS 2 messages that we read and write, field by field as in their .msg files (common_interfaces), named as ROS 2 names
them on DDS. Final types: plain CDR without headers of members, little-endian where we write it.

Metres, radians, m/s, rad/s; lengths of arrays as in the definitions.
"""

from dataclasses import dataclass, field
from typing import Any

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, float32, float64, int32, sequence, uint32


def _zeros() -> Any:  # an `array` is a list when it has a value
    return [0.0] * 36


@dataclass
@final
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32

    @classmethod
    def of(cls, stamp_ns: int) -> "Time":
        """From nanoseconds since the epoch."""
        return cls(sec=stamp_ns // 1_000_000_000, nanosec=stamp_ns % 1_000_000_000)

    @property
    def stamp_ns(self) -> int:
        return int(self.sec) * 1_000_000_000 + int(self.nanosec)


@dataclass
@final
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
@final
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
@final
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3
    angular: Vector3


@dataclass
@final
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
@final
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dataclass
@final
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Point
    orientation: Quaternion


@dataclass
@final
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    """`covariance`: 6 x 6, row by row, of x, y, z and the rotations about x, y, z."""

    pose: Pose
    covariance: array[float64, 36] = field(default_factory=_zeros)


@dataclass
@final
class PoseWithCovarianceStamped(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovarianceStamped_"):
    header: Header
    pose: PoseWithCovariance


@dataclass
@final
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: Twist
    covariance: array[float64, 36] = field(default_factory=_zeros)


@dataclass
@final
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    """The pose in the frame of the header (where the base was started), the twist in that of the child (the base)."""

    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
@final
class LaserScan(IdlStruct, typename="sensor_msgs::msg::dds_::LaserScan_"):
    """`ranges[i]` lies at `angle_min + i * angle_increment`, counter-clockwise about the scanner's z; outside of `range_min` ..
    `range_max` it says nothing."""

    header: Header
    angle_min: float32
    angle_max: float32
    angle_increment: float32
    time_increment: float32
    scan_time: float32
    range_min: float32
    range_max: float32
    ranges: sequence[float32]
    intensities: sequence[float32]
