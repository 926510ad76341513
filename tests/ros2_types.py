"""ROS 2's messages as a robot's own software has them: written from the .msg files, without anything of ours."""

from dataclasses import dataclass
from typing import Any

import cyclonedds.idl.annotations as annotations
from cyclonedds.core import Policy, Qos
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int32, sequence, uint32
from cyclonedds.util import duration


@dataclass
@annotations.final
class Stamp(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
@annotations.final
class StdHeader(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Stamp
    frame_id: str


@dataclass
@annotations.final
class XYZ(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
@annotations.final
class Velocity(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: XYZ
    angular: XYZ


@dataclass
@annotations.final
class Position(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64
    y: float64
    z: float64


@dataclass
@annotations.final
class Rotation(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
@annotations.final
class PlainPose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Position
    orientation: Rotation


@dataclass
@annotations.final
class CovariantPose(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    pose: PlainPose
    covariance: array[float64, 36]


@dataclass
@annotations.final
class StampedPose(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovarianceStamped_"):
    header: StdHeader
    pose: CovariantPose


@dataclass
@annotations.final
class CovariantTwist(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: Velocity
    covariance: array[float64, 36]


@dataclass
@annotations.final
class Odom(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    header: StdHeader
    child_frame_id: str
    pose: CovariantPose
    twist: CovariantTwist


@dataclass
@annotations.final
class Scan(IdlStruct, typename="sensor_msgs::msg::dds_::LaserScan_"):
    header: StdHeader
    angle_min: float32
    angle_max: float32
    angle_increment: float32
    time_increment: float32
    scan_time: float32
    range_min: float32
    range_max: float32
    ranges: sequence[float32]
    intensities: sequence[float32]


RELIABLE = Qos(
    Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.Durability.Volatile, Policy.History.KeepLast(10)
)
SENSOR = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(5))


def header(stamp_ns: int, frame: str) -> StdHeader:
    return StdHeader(Stamp(stamp_ns // 10**9, stamp_ns % 10**9), frame)


def odom(stamp_ns: int, x: float, y: float, yaw: float, linear: float, angular: float) -> Odom:
    import math

    zeros: Any = [0.0] * 36
    pose = PlainPose(Position(x, y, 0.0), Rotation(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)))
    twist = Velocity(XYZ(linear, 0.0, 0.0), XYZ(0.0, 0.0, angular))
    return Odom(header(stamp_ns, "odom"), "base_link", CovariantPose(pose, zeros), CovariantTwist(twist, zeros))


def scan(stamp_ns: int, ranges: list[float], angle_min: float = -3.141592, range_max: float = 12.0) -> Scan:
    """A whole turn in as many steps as there are ranges."""
    step = 6.283185 / len(ranges)
    given: Any = ranges
    nothing: Any = []
    return Scan(header(stamp_ns, "laser"), angle_min, -angle_min, step, 0.0, 0.1, 0.1, range_max, given, nothing)
