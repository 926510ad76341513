"""Emergency stops by UDP broadcast, over real sockets on the loopback: heard by every agent, believed once, only with the key."""

import asyncio
import socket
from collections.abc import AsyncIterator

import pytest

from agents.link import StopListener, stop_host
from agents.link.stops import LOOPBACK_BROADCAST, MOST_OFF_S
from agents.safety import EmergencyStopLatch
from protocol.clock import SystemClock
from protocol.datagram import Datagram, pack, unpack
from protocol.messages import DriveSetpoint, EmergencyStop, Status
from tests.agents.waiting import until

KEY = b"k" * 32
CLOCK = SystemClock()


class Ears:
    """An agent's part of it: the latch and the listener."""

    def __init__(self, robot: str, key: bytes | None = KEY) -> None:
        self.robot, self.latch = robot, EmergencyStopLatch()
        self.latch.update(EmergencyStop(engaged=False, epoch=4))
        self.faults: tuple[str, ...] = ()
        self.heard: list[EmergencyStop] = []
        self.listener = StopListener(key, CLOCK, self._on_stop, self._status)

    def _on_stop(self, stop: EmergencyStop) -> None:
        self.heard.append(stop)
        self.latch.update(stop)

    def _status(self, sequence: int) -> Status:
        epoch = self.latch.epoch if self.latch.engaged else None
        now_ns = CLOCK.now_ns()
        return Status(
            robot=self.robot,
            sequence=sequence,
            stamp_ns=now_ns,
            linear_mps=0.0,
            angular_radps=0.0,
            stop_epoch=epoch,
            faults=self.faults,
        )


class Mouth(asyncio.DatagramProtocol):
    """Somebody who sends datagrams to all agents of this machine."""

    def __init__(self, port: int) -> None:
        self.answers: list[bytes] = []
        self._port = port
        self._transport: asyncio.DatagramTransport | None = None

    async def open(self) -> None:
        loop = asyncio.get_running_loop()
        self._transport, _ = await loop.create_datagram_endpoint(
            lambda: self, local_addr=("127.0.0.1", 0), allow_broadcast=True
        )

    def datagram_received(self, data: bytes, addr: tuple[str | int, int]) -> None:
        self.answers.append(data)

    def say(self, data: bytes) -> None:
        assert self._transport is not None
        self._transport.sendto(data, (LOOPBACK_BROADCAST, self._port))

    def close(self) -> None:
        assert self._transport is not None
        self._transport.close()


def stop_datagram(
    number: int = 1, *, engaged: bool = True, epoch: int = 0, off_s: float = 0.0, key: bytes | None = KEY
) -> bytes:
    stamp_ns = CLOCK.now_ns() + round(off_s * 1e9)
    stop = EmergencyStop(engaged=engaged, epoch=epoch or stamp_ns // 1_000_000, stamp_ns=stamp_ns, by="anna")
    return pack(Datagram("stop-1", number, stamp_ns, stop), key)


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
async def hall() -> AsyncIterator[tuple[list[Ears], Mouth]]:
    """Three agents on one machine, which share the port."""
    port, ears = free_port(), [Ears(f"robot-{number}") for number in range(3)]
    for each in ears:
        await each.listener.open(LOOPBACK_BROADCAST, port)
    mouth = Mouth(port)
    await mouth.open()
    yield ears, mouth
    mouth.close()
    for each in ears:
        each.listener.close()
    await asyncio.sleep(0)


async def test_one_datagram_stops_every_robot_and_each_answers(hall: tuple[list[Ears], Mouth]) -> None:
    ears, mouth = hall
    mouth.say(stop_datagram())
    await until(lambda: all(each.latch.engaged for each in ears) and len(mouth.answers) == 3, "three stops and answers")
    said = [unpack(answer, KEY).message for answer in mouth.answers]
    assert {status.robot for status in said if isinstance(status, Status)} == {each.robot for each in ears}
    assert all(isinstance(status, Status) and status.stop_epoch is not None for status in said)


async def test_a_robot_whose_texts_are_long_answers_without_them(hall: tuple[list[Ears], Mouth]) -> None:
    ears, mouth = hall
    for each in ears:
        each.faults = ("\N{WARNING SIGN}" * 200,) * 3
    mouth.say(stop_datagram())
    await until(lambda: len(mouth.answers) == 3, "answers")
    said = [unpack(answer, KEY).message for answer in mouth.answers]
    assert all(isinstance(status, Status) and status.stop_epoch and not status.faults for status in said)


async def test_a_repetition_is_answered_but_stops_nothing_a_second_time(hall: tuple[list[Ears], Mouth]) -> None:
    ears, mouth = hall
    data = stop_datagram()
    mouth.say(data)
    await until(lambda: len(mouth.answers) == 3, "answers")
    for each in ears:
        each.latch.update(EmergencyStop(engaged=False, epoch=each.latch.epoch + 1))
    mouth.say(data)
    await until(lambda: len(mouth.answers) == 6, "answers again")
    assert not any(each.latch.engaged for each in ears), "recorded and sent again after the release"
    mouth.say(stop_datagram(2))
    await until(lambda: all(each.latch.engaged for each in ears), "a second stop")
    assert [len(each.heard) for each in ears] == [2, 2, 2]


async def test_what_is_forged_unsigned_of_another_time_or_no_stop_is_ignored(hall: tuple[list[Ears], Mouth]) -> None:
    ears, mouth = hall
    ignored = [
        b"garbage",
        stop_datagram(1, key=b"x" * 32),
        stop_datagram(2, key=None),
        stop_datagram(3, off_s=-MOST_OFF_S - 1),
        stop_datagram(4, off_s=MOST_OFF_S + 1),
        stop_datagram(5, engaged=False),
        pack(Datagram("stop-1", 6, CLOCK.now_ns(), DriveSetpoint("robot-0", 6, 0.5, 0.0)), KEY),
    ]
    for data in ignored:
        mouth.say(data)
    await until(lambda: all(each.listener.ignored == len(ignored) for each in ears), "all of it ignored")
    assert not any(each.heard for each in ears)
    assert mouth.answers == []


async def test_a_clock_that_is_off_does_not_keep_a_stop_from_stopping(hall: tuple[list[Ears], Mouth]) -> None:
    ears, mouth = hall
    mouth.say(stop_datagram(off_s=-MOST_OFF_S + 2))
    await until(lambda: all(each.latch.engaged for each in ears), "a stop of a slow clock")
    assert not ears[0].latch.update(EmergencyStop(engaged=False, epoch=4))


async def test_no_sender_can_make_an_epoch_up_that_no_release_exceeds(hall: tuple[list[Ears], Mouth]) -> None:
    ears, mouth = hall
    mouth.say(stop_datagram(epoch=8 * 10**18))
    await until(lambda: all(each.latch.engaged for each in ears), "a stop")
    assert all(each.latch.epoch <= CLOCK.now_ns() // 1_000_000 for each in ears)


async def test_a_port_that_others_have_is_tried_again() -> None:
    taken = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    taken.bind((LOOPBACK_BROADCAST, 0))  # without sharing it
    port: int = taken.getsockname()[1]
    ears = Ears("robot-0")
    with pytest.raises(OSError, match="in use"):
        await ears.listener.open(LOOPBACK_BROADCAST, port)
    taken.close()
    await ears.listener.open(LOOPBACK_BROADCAST, port)
    ears.listener.close()
    await asyncio.sleep(0)


def test_agents_beside_their_server_listen_on_this_machine_alone() -> None:
    assert stop_host("127.0.0.1") == stop_host("localhost") == LOOPBACK_BROADCAST
    assert stop_host("10.0.0.5") == "0.0.0.0"
