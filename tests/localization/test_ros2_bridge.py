"""Tracked poses as ROS 2 topics: what another DDS participant with its own types reads."""

import math
from collections.abc import Callable
from typing import Any

import pytest
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from localization.outputs.ros2_poses import Ros2Poses, ros_pose
from protocol.clock import SimulatedClock, SystemClock
from protocol.lab import Lab, Ros2Output, load_lab
from protocol.messages import TrackedPose
from tests.loopback_dds import domain_of_this_run, stay_on_loopback
from tests.ros2_types import RELIABLE, StampedPose

LAB = load_lab("labs/gulliver.yaml")
STAMP_NS = 1_700_000_000_123_456_789


def tracked(vehicle: str = "wifibot-14", stamp_ns: int = STAMP_NS, yaw: float = 2.0, x: float = 1.5) -> TrackedPose:
    covariance = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    return TrackedPose(vehicle, stamp_ns, x, -0.5, yaw, 0.1, 0.0, 0.0, covariance, ("cam0",), "camp")


def with_rate(rate_hz: float) -> Lab:
    outputs = LAB.outputs.model_copy(update={"ros2": Ros2Output(enabled=True, rate_hz=rate_hz)})
    return LAB.model_copy(update={"outputs": outputs})


def patiently(probe: Callable[[], Any], what: str) -> Any:
    clock = SystemClock()
    deadline_s = clock.monotonic_s() + 5.0
    while not (found := probe()):
        assert clock.monotonic_s() < deadline_s, f"not in time: {what}"
        clock.wait(0.005)
    return found


def test_a_pose_is_as_ros_2_has_it() -> None:
    message = ros_pose(tracked())
    assert (message.header.frame_id, message.header.stamp.stamp_ns) == ("map", STAMP_NS)
    position, q = message.pose.pose.position, message.pose.pose.orientation
    assert (position.x, position.y, position.z) == (1.5, -0.5, 0.0)
    assert (q.x, q.y, q.z, q.w) == (0.0, 0.0, math.sin(1.0), math.cos(1.0))
    given: Any = message.pose.covariance
    rows = [list(given[6 * row : 6 * row + 6]) for row in range(6)]
    assert [rows[0][0], rows[0][1], rows[0][5]] == [1.0, 2.0, 3.0]
    assert [rows[1][1], rows[1][5], rows[5][5]] == [4.0, 5.0, 6.0]
    assert all(rows[i][j] == rows[j][i] for i in range(6) for j in range(6))
    assert sum(value != 0.0 for row in rows for value in row) == 9


def test_another_participant_reads_each_vehicle_s_topic_and_there_is_no_other() -> None:
    stay_on_loopback()
    domain = domain_of_this_run()
    participant = DomainParticipant(domain)
    readers: dict[str, DataReader[StampedPose]] = {
        vehicle.id: DataReader(
            participant, Topic(participant, f"rt/robot_{vehicle.tag.id}/pose", StampedPose), qos=RELIABLE
        )
        for vehicle in LAB.vehicles
    }
    writers: Any = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)
    listeners: Any = BuiltinDataReader(participant, BuiltinTopicDcpsSubscription)
    poses = Ros2Poses(with_rate(0.0), domain, SystemClock())
    stamps = iter(range(STAMP_NS, STAMP_NS + 10**6))
    for number, (vehicle, reader) in enumerate(readers.items()):

        def read(vehicle: str = vehicle, reader: DataReader[StampedPose] = reader, x: float = number) -> Any:
            poses.publish([tracked(vehicle, next(stamps), x=x)])
            return reader.take(N=1)

        (message,) = patiently(read, f"the pose of {vehicle}")
        assert message.pose.pose.position.x == number
        assert message.header.frame_id == "map"
    written = {sample.topic_name for sample in writers.take(N=200)}
    mine = {f"rt/robot_{vehicle.tag.id}/pose" for vehicle in LAB.vehicles}
    assert {name for name in written if not name.startswith("DCPS")} == mine
    heard = {sample.topic_name for sample in listeners.take(N=200)}
    assert {name for name in heard if not name.startswith("DCPS")} <= mine, "the bridge listens to nothing"


class Ear:
    """Counts what a writer was given."""

    def __init__(self) -> None:
        self.heard: list[Any] = []

    def write(self, message: Any) -> None:
        self.heard.append(message)


def silent(rate_hz: float, clock: SimulatedClock) -> tuple[Ros2Poses, Ear]:
    stay_on_loopback()
    poses, ear = Ros2Poses(with_rate(rate_hz), domain_of_this_run(), clock), Ear()
    poses._writers["wifibot-14"] = ear  # pyright: ignore[reportPrivateUsage, reportArgumentType]
    return poses, ear


async def test_the_rate_is_kept() -> None:
    clock = SimulatedClock()
    poses, ear = silent(5.0, clock)
    for number in range(30):
        poses.publish([tracked(stamp_ns=number)])
        await clock.advance(0.1)
    assert len(ear.heard) == pytest.approx(15, abs=1)


def test_older_and_repeated_poses_and_those_of_strangers_are_left_out() -> None:
    poses, ear = silent(0.0, SimulatedClock())
    poses.publish([tracked(stamp_ns=5), tracked(stamp_ns=5), tracked(stamp_ns=4), tracked("nobody", 9)])
    assert [message.header.stamp.stamp_ns for message in ear.heard] == [5]


def test_it_is_off_unless_the_lab_file_says_otherwise() -> None:
    assert not LAB.outputs.ros2.enabled
