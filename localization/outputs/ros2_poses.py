"""Poses as ROS 2 topics over DDS, for `localization.ros2_bridge`. Imports `cyclonedds`, which not every machine has."""

import logging
import math
from collections.abc import Iterable

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic

from localization.outputs.pace import Pace
from protocol.clock import Clock
from protocol.lab import Lab
from protocol.messages import TrackedPose
from protocol.ros2 import pose_topic
from protocol.ros2.interfaces import (
    Header,
    Point,
    Pose,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    Time,
)
from protocol.ros2.quality import DEFAULT

FRAME = "map"
_logger = logging.getLogger(__name__)


def ros_pose(tracked: TrackedPose) -> PoseWithCovarianceStamped:
    """The pose as ROS 2 has it. What cannot vary on a floor (z, roll, pitch) is 0, and so is its covariance."""
    xx, xy, xyaw, yy, yyaw, yawyaw = tracked.covariance
    covariance = [0.0] * 36
    for row, column, value in ((0, 0, xx), (0, 1, xy), (0, 5, xyaw), (1, 1, yy), (1, 5, yyaw), (5, 5, yawyaw)):
        covariance[6 * row + column] = covariance[6 * column + row] = value
    half = tracked.yaw / 2.0
    pose = Pose(Point(tracked.x, tracked.y, 0.0), Quaternion(0.0, 0.0, math.sin(half), math.cos(half)))
    return PoseWithCovarianceStamped(Header(Time.of(tracked.stamp_ns), FRAME), _with_covariance(pose, covariance))


def _with_covariance(pose: Pose, covariance: list[float]) -> PoseWithCovariance:
    made = PoseWithCovariance(pose)
    made.covariance[:] = covariance  # pyright: ignore[reportIndexIssue]  # an `array` is a list when it has a value
    return made


class Ros2Poses:
    """A writer per vehicle in one DDS domain. OSError when there is no way into it."""

    def __init__(self, lab: Lab, domain: int, clock: Clock) -> None:
        self._pace = Pace(clock, lab.outputs.ros2.rate_hz)
        try:
            participant = DomainParticipant(domain)
        except DDSException as error:
            raise OSError(f"no way to ROS 2 in DDS domain {domain}: {error}") from error
        self._writers: dict[str, DataWriter[PoseWithCovarianceStamped]] = {
            vehicle.id: DataWriter(
                participant, Topic(participant, pose_topic(vehicle), PoseWithCovarianceStamped), qos=DEFAULT
            )
            for vehicle in lab.vehicles
        }
        self._newest_ns: dict[str, int] = {}
        self.published, self.failed = 0, 0

    def publish(self, poses: Iterable[TrackedPose]) -> None:
        """Those that are due, and newer than what was published before; never waits, never raises."""
        for pose in poses:
            if pose.vehicle not in self._writers or pose.stamp_ns <= self._newest_ns.get(pose.vehicle, -1):
                continue
            self._newest_ns[pose.vehicle] = pose.stamp_ns
            if not self._pace.due((pose,)):
                continue
            try:
                self._writers[pose.vehicle].write(ros_pose(pose))
                self.published += 1
            except (DDSException, ValueError, OverflowError) as error:
                self.failed += 1
                _logger.warning("the pose of %s was not published: %s", pose.vehicle, error)
