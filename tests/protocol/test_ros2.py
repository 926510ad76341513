"""ROS 2 on DDS: names, and the bytes of its plain CDR, written out by hand from the rules (DDS-XTypes 7.4.3, OMG CDR): four bytes
that say little-endian CDR, then each member at a multiple of its size, counted from there; strings and sequences begin with
their length, a string's counts its zero."""

import struct
from typing import Any

import pytest

from protocol.lab import Lab, Ros2Base, load_lab
from protocol.ros2 import domain_id, namespace_of, pose_topic, topic
from protocol.ros2.interfaces import (
    Header,
    LaserScan,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    Time,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from protocol.ros2.quality import DEFAULT, SENSOR_DATA

LAB: Lab = load_lab("labs/gulliver.yaml")
LITTLE_ENDIAN_CDR = bytes.fromhex("00010000")
STAMP_NS = 1_700_000_001_000_000_002
STAMP = bytes.fromhex("01f15365") + bytes.fromhex("02000000")  # 1700000001 s, 2 ns
HALF, ONE, TWO = bytes.fromhex("000000000000e03f"), bytes.fromhex("000000000000f03f"), bytes.fromhex("0000000000000040")
ZERO = bytes(8)


def serialized(message: Any) -> bytes:
    return message.serialize(use_version_2=False)


def test_twist_bytes() -> None:
    golden = LITTLE_ENDIAN_CDR + HALF + ZERO + ZERO + ZERO + ZERO + ONE
    assert serialized(Twist(Vector3(x=0.5), Vector3(z=1.0))) == golden
    assert len(golden) == 52


def test_pose_bytes() -> None:
    """The frame `map` ends at a multiple of eight: no padding before the doubles."""
    covariance: Any = [0.0] * 36
    covariance[0] = 0.5
    message = PoseWithCovarianceStamped(
        Header(Time.of(STAMP_NS), "map"), PoseWithCovariance(Pose(Point(1.0, 2.0, 0.0), Quaternion()), covariance)
    )
    golden = LITTLE_ENDIAN_CDR + STAMP + bytes.fromhex("04000000") + b"map\0"
    golden += ONE + TWO + ZERO  # position
    golden += ZERO + ZERO + ZERO + ONE  # orientation
    golden += HALF + 35 * ZERO
    assert serialized(message) == golden


def odometry_bytes() -> bytes:
    golden = STAMP + bytes.fromhex("05000000") + b"odom\0"
    golden += bytes(3)  # 17 bytes so far: the next length begins at 20
    golden += bytes.fromhex("0a000000") + b"base_link\0"
    golden += bytes(6)  # 34 bytes so far: the first double begins at 40
    golden += ONE + TWO + ZERO + ZERO + ZERO + ZERO + ONE + 36 * ZERO
    golden += HALF + ZERO + ZERO + ZERO + ZERO + ONE + 36 * ZERO
    return LITTLE_ENDIAN_CDR + golden


def test_odometry_bytes_in_both_directions() -> None:
    message = Odometry.deserialize(odometry_bytes())
    assert message.header.stamp.stamp_ns == STAMP_NS
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
    assert (message.pose.pose.position.x, message.pose.pose.position.y) == (1.0, 2.0)
    assert (message.twist.twist.linear.x, message.twist.twist.angular.z) == (0.5, 1.0)
    twist = TwistWithCovariance(Twist(Vector3(x=0.5), Vector3(z=1.0)))
    pose = PoseWithCovariance(Pose(Point(1.0, 2.0, 0.0), Quaternion()))
    assert serialized(Odometry(Header(Time.of(STAMP_NS), "odom"), "base_link", pose, twist)) == odometry_bytes()


def test_scan_bytes() -> None:
    golden = LITTLE_ENDIAN_CDR + STAMP + bytes.fromhex("06000000") + b"laser\0" + bytes(2)
    golden += struct.pack("<7f", -0.5, 0.5, 0.25, 0.0, 0.1, 0.15, 12.0)
    golden += bytes.fromhex("03000000") + struct.pack("<3f", 1.0, 2.0, float("inf"))
    golden += bytes.fromhex("00000000")
    scan: Any = LaserScan.deserialize(golden)
    assert (list(scan.ranges), list(scan.intensities)) == ([1.0, 2.0, float("inf")], [])
    assert (scan.angle_min, scan.range_max) == (-0.5, 12.0)
    assert serialized(scan) == golden


@pytest.mark.parametrize("kind", [Twist, PoseWithCovarianceStamped, Odometry, LaserScan])
def test_types_are_named_as_ros_2_names_them(kind: Any) -> None:
    package = {"Twist": "geometry_msgs", "Odometry": "nav_msgs", "LaserScan": "sensor_msgs"}.get(
        kind.__name__, "geometry_msgs"
    )
    assert kind.__idl__.idl_transformed_typename == f"{package}::msg::dds_::{kind.__name__}_"


def test_topics_and_namespaces_are_legal_names() -> None:
    vehicle = LAB.vehicle("wifibot-14")
    assert topic("robot_1", "cmd_vel") == "rt/robot_1/cmd_vel"
    assert pose_topic(vehicle) == "rt/robot_14/pose"
    assert namespace_of(vehicle) == "wifibot_14"
    for name, expected in (("2-fast", "robot_2_fast"), ("a--b_", "a_b"), ("7", "robot_7"), ("a_-_b", "a_b")):
        assert namespace_of(vehicle.model_copy(update={"id": name})) == expected
    own = vehicle.model_copy(update={"ros2": Ros2Base(namespace="fleet/tb4")})
    assert namespace_of(own) == "fleet/tb4"
    assert len({pose_topic(vehicle) for vehicle in LAB.vehicles}) == len(LAB.vehicles)


@pytest.mark.parametrize("name", ["/robot", "robot/", "1robot", "a__b", "a-b", "", "a//b"])
def test_a_namespace_that_ros_would_refuse_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="namespace"):
        Ros2Base(namespace=name)


def test_the_domain_is_the_lab_file_s_or_the_environment_s() -> None:
    assert domain_id(5, {"ROS_DOMAIN_ID": "7"}) == 5
    assert domain_id(None, {"ROS_DOMAIN_ID": "7"}) == 7
    assert domain_id(None, {}) == 0
    for text in ("-1", "233", "x", "٣"):
        with pytest.raises(ValueError, match="ROS_DOMAIN_ID must be a number from 0 to 232"):
            domain_id(None, {"ROS_DOMAIN_ID": text})


def test_qualities_are_those_of_ros_2() -> None:
    assert "Reliability.Reliable" in str(DEFAULT)
    assert "BestEffort" in str(SENSOR_DATA)
    for quality in (DEFAULT, SENSOR_DATA):
        assert "Durability.Volatile" in str(quality)
        assert "KeepLast" in str(quality)
