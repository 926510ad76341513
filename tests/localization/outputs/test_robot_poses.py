"""Every registered robot gets its own pose, and only that; what fails for one robot disturbs no other."""

import threading

import pytest

from localization.outputs import RobotPoses, UdpSender
from localization.outputs.resolving import UnresolvedHostError, resolve
from localization.outputs.udp_sender import Counts
from protocol.channels import REGISTRATIONS
from protocol.clock import SimulatedClock
from protocol.datagram import TRACKER, unpack
from protocol.errors import DecodeError
from protocol.lab import Output
from tests.localization.outputs.listeners import Ear, pose, until


def test_each_robot_gets_its_own_pose(sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]) -> None:
    robots = RobotPoses(sender, clock, None)
    for ear, robot in zip(ears, ("robot-10", "robot-11"), strict=True):
        robots.register(ear.registration(robot))
    robots.send([pose("robot-10", 1.0), pose("robot-11", 2.0), pose("unregistered")])
    (first,), (second,) = (ear.poses() for ear in ears)
    assert (first.sender, first.message) == (TRACKER, pose("robot-10", 1.0))
    assert second.message == pose("robot-11", 2.0)
    assert second.sequence > first.sequence
    assert first.stamp_ns == clock.now_ns()
    assert (robots.counts.sent, robots.counts.failed) == (2, 0)


def test_datagrams_are_signed_with_the_key(sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]) -> None:
    robots = RobotPoses(sender, clock, b"secret")
    robots.register(ears[0].registration("robot-10"))
    robots.send([pose()])
    (data,) = ears[0].all()
    assert unpack(data, b"secret").message == pose()
    with pytest.raises(DecodeError, match="signature"):
        unpack(data, b"another")


def test_a_new_registration_moves_the_robot(sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]) -> None:
    robots = RobotPoses(sender, clock, None)
    old, new = ears
    robots.register(old.registration("robot-10"))
    robots.register(new.registration("robot-10"))
    robots.send([pose()])
    assert (len(old.all()), len(new.all())) == (0, 1)


def test_a_robot_that_registers_no_more_is_told_no_more(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    robots = RobotPoses(sender, clock, None)
    robots.register(ears[0].registration("robot-10"))
    clock.wait(REGISTRATIONS.stale_after_s - 1)
    robots.register(ears[0].registration("robot-10"))
    clock.wait(REGISTRATIONS.stale_after_s - 1)
    robots.send([pose()])
    assert len(ears[0].all()) == 1
    clock.wait(2)
    robots.send([pose()])
    assert ears[0].all() == []
    assert "no robot" in robots.describe()


def test_the_rate_is_kept_per_vehicle(sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]) -> None:
    robots = RobotPoses(sender, clock, None, Output(rate_hz=10.0))
    for ear, robot in zip(ears, ("robot-10", "robot-11"), strict=True):
        robots.register(ear.registration(robot))
    for _ in range(60):  # one second of sixty updates
        robots.send([pose("robot-10"), pose("robot-11")])
        clock.wait(1 / 60)
    assert [len(ear.all()) in (10, 11) for ear in ears] == [True, True]


async def test_a_host_name_is_resolved_and_nonsense_changes_nothing(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear], caplog: pytest.LogCaptureFixture
) -> None:
    robots = RobotPoses(sender, clock, None)
    robots.register(ears[0].registration("robot-10", host="localhost"))
    await until(lambda: "robot-10" in robots.describe())
    robots.register(ears[0].registration("robot-10", host=".not a host."))
    await until(lambda: "robot-10 registered from a host that is not known: '.not a host.'" in caplog.text)
    robots.send([pose()])
    assert len(ears[0].all()) == 1


async def test_a_name_server_that_does_not_answer_holds_nobody_up(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    answers, asked = threading.Event(), 0

    def slow(_host: str) -> str:
        nonlocal asked
        asked += 1
        answers.wait(10)
        return "127.0.0.1"

    robots = RobotPoses(sender, clock, None, lookup=slow)
    robots.register(ears[0].registration("robot-10", host="slow.example"))
    robots.register(ears[0].registration("robot-10", host="slow.example"))  # it registers again while that goes on
    robots.register(ears[1].registration("robot-11"))
    robots.send([pose("robot-10"), pose("robot-11")])
    assert (len(ears[0].all()), len(ears[1].all())) == (0, 1)
    answers.set()
    await until(lambda: "robot-10" in robots.describe())
    robots.send([pose("robot-10")])
    assert len(ears[0].all()) == 1
    assert asked == 1


async def test_resolving_says_what_has_no_address() -> None:
    assert await resolve("10.0.0.7") == "10.0.0.7"
    with pytest.raises(UnresolvedHostError, match="'no such host' has no IPv4 address"):
        await resolve("no such host")


def test_what_the_system_refuses_is_counted_and_told_now_and_then(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear], caplog: pytest.LogCaptureFixture
) -> None:
    counts, nowhere = Counts(), ("127.0.0.1", 0)  # the kernel refuses port 0, as it does a network that is down
    for _ in range(3):
        assert not sender.send(b"x", nowhere, "robot-10", counts)
        assert sender.send(b"x", ("127.0.0.1", ears[0].port), "robot-11", counts)
    assert (counts.sent, counts.failed) == (3, 3)
    assert ears[0].all() == [b"x"] * 3
    told = "poses for robot-10 do not leave for 127.0.0.1:0"
    assert caplog.text.count(told) == 1
    clock.wait(30)
    sender.send(b"x", nowhere, "robot-10", counts)
    assert caplog.text.count(told) == 2


def test_a_robot_whose_socket_is_gone_does_not_disturb_the_others(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    robots = RobotPoses(sender, clock, None)
    for ear, robot in zip(ears, ("robot-10", "robot-11"), strict=True):
        robots.register(ear.registration(robot))
    ears[0].socket.close()
    for _ in range(5):
        robots.send([pose("robot-10"), pose("robot-11")])
    assert len(ears[1].all()) == 5
