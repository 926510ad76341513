"""Poses leave by every output that is switched on, each at its rate; what fails is counted and stops nobody else."""

import asyncio
import logging
import math
import socket
import struct
import threading
from collections.abc import Callable, Iterator

import pytest

from localization.outputs import GulliViewReceiver, RedisPoses, RobotPoses, UdpSender, outputs_of
from localization.outputs.resolving import UnresolvedHostError, resolve
from localization.outputs.udp_sender import Counts
from protocol.bus import Bus
from protocol.channels import POSES, REGISTRATIONS
from protocol.clock import SimulatedClock
from protocol.datagram import TRACKER, Datagram, unpack
from protocol.errors import DecodeError
from protocol.lab import GulliViewLayout, GulliViewOutput, Lab, Output
from protocol.lab import Outputs as OutputsSettings
from protocol.messages import Registration, TrackedPose
from tests.localization.synthetic import small_lab
from tests.redis_fixture import RedisServer

STAMP_NS = 1_700_000_000_123_000_000


def pose(vehicle: str = "robot-10", x: float = 1.0, y: float = 0.5, yaw: float = 0.3) -> TrackedPose:
    return TrackedPose(vehicle, STAMP_NS, x, y, yaw, 0.3, 0.4, 0.2, (1e-6, 0, 0, 1e-6, 0, 1e-6), ("right",), "room")


class Ear:
    """A socket on loopback that somebody sends to."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        self.port: int = self.socket.getsockname()[1]

    def registration(self, robot: str, host: str = "127.0.0.1") -> Registration:
        return Registration(robot=robot, host=host, udp_port=self.port)

    def all(self) -> list[bytes]:
        """What has arrived; on loopback a datagram is there when `sendto` returns."""
        heard: list[bytes] = []
        while True:
            try:
                heard.append(self.socket.recv(2048))
            except BlockingIOError:
                return heard

    def poses(self, key: bytes | None = None) -> list[Datagram]:
        return [unpack(data, key) for data in self.all()]


@pytest.fixture
def ears() -> Iterator[tuple[Ear, Ear]]:
    made = Ear(), Ear()
    yield made
    for ear in made:
        ear.socket.close()


@pytest.fixture
def clock() -> SimulatedClock:
    return SimulatedClock()


@pytest.fixture
def sender(clock: SimulatedClock) -> Iterator[UdpSender]:
    with UdpSender(clock) as made:
        yield made


async def until(condition: Callable[[], bool]) -> None:
    """Lets the loop and its threads go on until the condition holds."""
    for _ in range(5000):
        if condition():
            return
        await asyncio.sleep(0.002)
    raise AssertionError("waited in vain")


# --- datagrams to registered robots ----------------------------------------------------------------------------------


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


# --- packets of the existing systems ---------------------------------------------------------------------------------


def receiver(
    sender: UdpSender,
    clock: SimulatedClock,
    layout: GulliViewLayout,
    ear: Ear,
    *,
    lab: Lab | None = None,
    **more: object,
) -> GulliViewReceiver:
    output = GulliViewOutput.model_validate({"layout": layout, "host": "127.0.0.1", "port": ear.port, **more})
    return GulliViewReceiver(sender, clock, lab or small_lab(), output)


def test_a_receiver_of_2025_unpacks_the_tag(sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]) -> None:
    sent = receiver(sender, clock, "gulliview-2025", ears[0])
    sent.send([pose()])
    (data,) = ears[0].all()
    assert len(data) == 256
    assert struct.unpack_from(">IIIQQII", data) == (1, 2, 0, STAMP_NS // 10**6, 0, 1, 1)
    tag_id, time_msec, x, y, z, theta, speed, camera = struct.unpack_from(">IQIIIffI", data, 36)
    assert (tag_id, time_msec, z, camera) == (10, STAMP_NS // 10**6, 300, 1)
    # The tag sits at (0.05, 0.02, 0.4) on the vehicle, which stands at (1.0, 0.5, 0.3).
    tag_x = 1.0 + 0.05 * math.cos(0.3) - 0.02 * math.sin(0.3)
    tag_y = 0.5 + 0.05 * math.sin(0.3) + 0.02 * math.cos(0.3)
    assert (y / 1000, x / 1000) == pytest.approx((tag_x, tag_y), abs=0.5e-3)
    assert math.pi / 2 - theta == pytest.approx(0.3 + 0.4, abs=1e-6)
    assert speed == pytest.approx(0.5)


def test_a_receiver_of_2023_unpacks_the_rotation_centre(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    sent = receiver(sender, clock, "gulliview-2023", ears[0], point="vehicle")
    sent.send([pose()])
    (data,) = ears[0].all()
    assert struct.unpack_from(">IIIQQII", data) == (1, 2, 0, STAMP_NS // 10**6, 0, 0, 1)
    tag_id, x, y, theta, speed, camera = struct.unpack_from(">IIIffI", data, 36)
    assert (tag_id, camera) == (10, 1)
    assert (x / 1298, y / 1298) == pytest.approx((1.0, 0.5), abs=0.5 / 1298)
    assert -theta == pytest.approx(0.3)
    assert speed == pytest.approx(0.5)


def test_the_gap_is_averaged_and_seq_rises_over_split_packets(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    lab = small_lab()
    crowd = tuple(
        lab.vehicles[0].model_copy(update={"id": f"v{n}", "tag": lab.vehicles[0].tag.model_copy(update={"id": 20 + n})})
        for n in range(14)
    )
    sent = receiver(sender, clock, "gulliview-2025", ears[0], lab=lab.model_copy(update={"vehicles": crowd}))
    for _ in range(3):
        sent.send([pose(f"v{n}") for n in range(14)])
        clock.wait(0.016)
    headers = [struct.unpack_from(">IIIQQII", data) for data in ears[0].all()]
    assert [header[2] for header in headers] == list(range(9))
    assert [header[4] for header in headers] == [0] * 3 + [16] * 6
    assert [header[6] for header in headers] == [6, 6, 2] * 3
    sent.send([])
    assert ears[0].all() == []


def test_several_receivers_have_rates_of_their_own(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    slow = receiver(sender, clock, "gulliview-2023", ears[0], rate_hz=5)
    fast = receiver(sender, clock, "gulliview-2025a", ears[1])
    for _ in range(60):
        for each in (slow, fast):
            each.send([pose()])
        clock.wait(1 / 60)
    assert len(ears[0].all()) in (5, 6)
    assert len(ears[1].all()) == 60


def test_negative_places_are_told_once_per_vehicle(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear], caplog: pytest.LogCaptureFixture
) -> None:
    sent = receiver(sender, clock, "gulliview-2025", ears[0], point="vehicle")
    for _ in range(2):
        sent.send([pose(x=-0.35), pose("robot-11")])
    assert [r.message for r in caplog.records if "negative" in r.message] == [
        "robot-10 is at (-0.35, 0.50) m: receivers of gulliview-2025 packets read negative coordinates as huge positive ones"
    ]
    data = ears[0].all()[0]
    assert struct.unpack_from(">IQII", data, 36)[3] == 2**32 - 350


async def test_a_receiver_by_name_is_looked_up_until_it_is_found(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear], caplog: pytest.LogCaptureFixture
) -> None:
    known: dict[str, str] = {}

    def lookup(host: str) -> str:
        if host not in known:
            raise UnresolvedHostError(f"{host!r} has no IPv4 address: unknown")
        return known[host]

    output = GulliViewOutput(layout="gulliview-2025", host="robots.example", port=ears[0].port)
    sent = GulliViewReceiver(sender, clock, small_lab(), output, lookup)
    running = asyncio.ensure_future(sent.run())
    await until(lambda: "no gulliview-2025 packets for robots.example" in caplog.text)
    sent.send([pose()])
    assert ears[0].all() == []
    known["robots.example"] = "127.0.0.1"
    heard: list[bytes] = []

    async def found() -> None:
        while not heard:
            await clock.advance(5.0)
            await asyncio.sleep(0.002)
            sent.send([pose()])
            heard.extend(ears[0].all())

    await asyncio.wait_for(found(), 10)
    running.cancel()
    with pytest.raises(asyncio.CancelledError):
        await running


# --- all together ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bus_on", [True, False])
async def test_outputs_are_as_the_lab_says(
    redis_server: RedisServer,
    sender: UdpSender,
    clock: SimulatedClock,
    ears: tuple[Ear, Ear],
    caplog: pytest.LogCaptureFixture,
    bus_on: bool,
) -> None:
    settings = OutputsSettings(
        redis=Output(enabled=bus_on),
        datagrams=Output(enabled=not bus_on),
        gulliview=(
            GulliViewOutput(layout="gulliview-2023", host="127.0.0.1", port=ears[1].port),
            GulliViewOutput(layout="gulliview-2025", host="127.0.0.1", port=ears[1].port, enabled=False),
        ),
    )
    lab = small_lab().model_copy(update={"outputs": settings})
    bus = Bus.connect(redis_server.url)
    outputs = outputs_of(lab, bus, sender, clock, None)
    outputs.register(ears[0].registration("robot-10"))
    outputs.send([pose()])
    await outputs.publish([pose()])
    assert len(ears[0].all()) == (0 if bus_on else 1)
    assert len(ears[1].all()) == 1
    assert await bus.latest_all(POSES) == ({"robot-10": pose()} if bus_on else {})
    assert "area 'room' reaches x = -0.5 m and y = -0.5 m" in caplog.text
    assert ("outputs.redis is off" in caplog.text) == (not bus_on)
    await bus.close()


async def test_redis_out_of_reach_costs_nobody_a_datagram(
    redis_server: RedisServer, sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    bus = Bus.connect(redis_server.url)
    poses = RedisPoses(bus, clock, Output())
    await poses.publish([pose()])
    redis_server.kill()
    await poses.publish([pose()])
    assert poses.published == 1
    assert bus.dropped == 1
    await bus.close()


async def test_what_was_sent_stands_in_the_log(
    redis_server: RedisServer,
    sender: UdpSender,
    clock: SimulatedClock,
    ears: tuple[Ear, Ear],
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.INFO)
    bus = Bus.connect(redis_server.url)
    outputs = outputs_of(small_lab(), bus, sender, clock, None)
    running = asyncio.ensure_future(outputs.run(clock))
    outputs.register(ears[0].registration("robot-10"))
    await asyncio.sleep(0)
    outputs.send([pose()])
    await clock.advance(61)
    assert "poses out: datagrams to robot-10: 1 sent, 0 failed; Redis: 0 published" in caplog.text
    running.cancel()
    with pytest.raises(asyncio.CancelledError):
        await running
    await bus.close()
