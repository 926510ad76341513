"""Robots get their own poses by UDP, in order, signed when there is a key."""

import asyncio
import socket
from collections.abc import Iterator

import pytest

from localization.robot_poses import RobotPoses
from protocol.clock import SimulatedClock
from protocol.datagram import TRACKER, Datagram, unpack
from protocol.errors import DecodeError
from protocol.messages import Registration, TrackedPose


def pose(vehicle: str, x: float = 1.0) -> TrackedPose:
    return TrackedPose(vehicle, 5, x, 2.0, 0.5, 0.1, 0.0, 0.2, (1e-6, 0, 0, 1e-6, 0, 1e-6), ("cam0",), "camp")


class Robot:
    """A robot's socket on loopback."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)

    def registration(self, host: str = "127.0.0.1") -> Registration:
        return Registration(robot=self.name, host=host, udp_port=self.socket.getsockname()[1])

    async def receive(self, key: bytes | None = None) -> Datagram:
        data = await asyncio.wait_for(asyncio.get_running_loop().sock_recv(self.socket, 2048), 5.0)
        return unpack(data, key)

    def heard_nothing(self) -> bool:
        try:
            self.socket.recv(2048)
        except BlockingIOError:
            return True
        return False


@pytest.fixture
def robots() -> Iterator[list[Robot]]:
    made = [Robot("robot-10"), Robot("robot-11")]
    yield made
    for robot in made:
        robot.socket.close()


async def opened(clock: SimulatedClock, key: bytes | None = None, rate_hz: float = 0.0) -> RobotPoses:
    sender = RobotPoses(clock, key, rate_hz)
    await sender.open()
    return sender


async def test_each_robot_gets_its_own_pose(robots: list[Robot]) -> None:
    clock = SimulatedClock()
    sender = await opened(clock)
    for robot in robots:
        await sender.register(robot.registration())
    sender.send([pose("robot-10", 1.0), pose("robot-11", 2.0), pose("unregistered")])
    first, second = [await robot.receive() for robot in robots]
    assert (first.sender, first.message) == (TRACKER, pose("robot-10", 1.0))
    assert second.message == pose("robot-11", 2.0)
    assert second.sequence > first.sequence
    assert first.stamp_ns == clock.now_ns()
    assert all(robot.heard_nothing() for robot in robots)
    sender.close()


async def test_datagrams_are_signed_with_the_key(robots: list[Robot]) -> None:
    sender = await opened(SimulatedClock(), key=b"secret")
    await sender.register(robots[0].registration())
    sender.send([pose("robot-10")])
    assert (await robots[0].receive(b"secret")).message == pose("robot-10")
    sender.send([pose("robot-10")])
    with pytest.raises(DecodeError, match="signature"):
        await robots[0].receive(b"another")
    sender.close()


async def test_a_new_registration_moves_the_robot(robots: list[Robot]) -> None:
    sender = await opened(SimulatedClock())
    old, new = robots
    new.name = "robot-10"
    await sender.register(old.registration())
    await sender.register(new.registration())
    sender.send([pose("robot-10")])
    await new.receive()
    assert old.heard_nothing()
    sender.close()


async def test_the_rate_is_kept(robots: list[Robot]) -> None:
    clock = SimulatedClock()
    sender = await opened(clock, rate_hz=10.0)
    await sender.register(robots[0].registration())
    for _ in range(60):  # one second of sixty updates
        sender.send([pose("robot-10")])
        clock.wait(1 / 60)
    assert 10 <= sender.sent <= 11
    sender.close()


async def test_a_host_name_is_resolved_and_nonsense_changes_nothing(robots: list[Robot]) -> None:
    sender = await opened(SimulatedClock())
    await sender.register(robots[0].registration(host="localhost"))
    await sender.register(robots[0].registration(host=".not a host."))
    sender.send([pose("robot-10")])
    await robots[0].receive()
    sender.close()


async def test_a_robot_that_is_gone_does_not_disturb_the_others(robots: list[Robot]) -> None:
    sender = await opened(SimulatedClock())
    gone, here = robots
    for robot in robots:
        await sender.register(robot.registration())
    gone.socket.close()
    for _ in range(5):
        sender.send([pose("robot-10"), pose("robot-11")])
        await here.receive()
    sender.close()
