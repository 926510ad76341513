"""The agent end to end: a server over HTTP and UDP and a base over UDP, all real sockets on the loopback."""

import asyncio
import contextlib
import re
import socket
from collections.abc import AsyncIterator, Callable
from itertools import pairwise
from pathlib import Path

import pytest

from agents.__main__ import main
from agents.agent import Agent, AgentConfig
from agents.drivers import DriverSite, SimDriver, SimDriverConfig, make_driver
from agents.link.stops import LOOPBACK_BROADCAST
from agents.motion import STOP
from agents.pacing import Pacer
from geometry import SE2
from launcher.stop_broadcast import StopBroadcast
from protocol.clock import SimulatedClock, SystemClock
from protocol.datagram import Verdict
from protocol.lab import load_lab
from protocol.messages import Command, EmergencyStop, Outcome, ReasonCode
from tests.agents.fake_base import FakeBase
from tests.agents.fake_server import FakeServer
from tests.agents.orders import Orders
from tests.agents.plant import distance, tracked
from tests.agents.waiting import until

ROBOT = "wifibot-14"
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as _probe:
    _probe.bind(("127.0.0.1", 0))
    _FREE_PORT = int(_probe.getsockname()[1])
_SHIPPED = load_lab("labs/gulliver.yaml")
LAB = _SHIPPED.model_copy(update={"ports": _SHIPPED.ports.model_copy(update={"stop_udp": _FREE_PORT})})
KEY = b"a shared key of the whole lab"


class World:
    """Server, base, camera, guidance and the agent between them. `order` is what the guidance says; None: silence."""

    def __init__(self) -> None:
        self.clock = SystemClock()
        self.server = FakeServer(ROBOT, key=KEY)
        self.base = FakeBase(ROBOT, SE2(1.0, 1.0, 0.0), KEY)
        self.orders = Orders(ROBOT)
        self.order: Callable[[int], Command] | None = None
        self.camera_works = True
        self.last_command_s = 0.0
        self.agent: Agent | None = None
        self._tasks: list[asyncio.Task[None]] = []

    async def start(self, token: str = "secret") -> None:
        await self.base.start()
        await self.server.start()
        await self.start_agent(token)
        self._tasks += [asyncio.create_task(self._camera()), asyncio.create_task(self._guidance())]

    async def start_agent(self, token: str = "secret") -> None:
        vehicle = LAB.vehicle(ROBOT)
        config = SimDriverConfig("127.0.0.1", self.base.port, ROBOT, vehicle.limits, KEY, vehicle.scanner)
        driver = SimDriver(config, self.clock)
        self.agent = Agent(AgentConfig(LAB, vehicle, self.server.url, token, KEY), driver, self.clock)
        self._agent_task = asyncio.create_task(self.agent.run())
        self._tasks.append(self._agent_task)

    async def stop_agent(self) -> None:
        self._agent_task.cancel()
        await asyncio.wait({self._agent_task})

    async def stop(self) -> None:
        for task in self._tasks:
            task.cancel()
        for result in await asyncio.gather(*self._tasks, return_exceptions=True):
            if isinstance(result, Exception):
                raise result
        await self.server.stop()
        await self.base.stop()

    async def _camera(self) -> None:
        while True:
            stamp_ns, pose = self.clock.now_ns(), self.base.plant.pose
            await asyncio.sleep(1 / 15)
            if self.camera_works and self.server.registrations:
                self.server.send_pose(tracked(ROBOT, pose, stamp_ns))

    async def _guidance(self) -> None:
        while True:
            if self.order is not None and self.server.streams:
                self.server.send(self.order(self.clock.now_ns()))
                self.last_command_s = self.clock.monotonic_s()
            await asyncio.sleep(0.1)

    def go(self, x: float = 7.0, y: float = 1.0, speed: float = 0.4) -> None:
        self.order = lambda now_ns: self.orders.move_to(now_ns, x, y, speed=speed)

    @property
    def speed(self) -> float:
        return abs(self.base.plant.twist.linear_mps)

    async def moving(self) -> None:
        await until(lambda: self.speed > 0.25, "the robot drives")

    async def still(self) -> None:
        await until(lambda: self.base.plant.twist == STOP, "the robot stands")

    def first_zero_after(self, instant_s: float) -> float | None:
        return next((at for at, twist in self.base.setpoints if at >= instant_s and twist == STOP), None)


@pytest.fixture
async def world() -> AsyncIterator[World]:
    world = World()
    await world.start()
    try:
        yield world
    finally:
        await world.stop()


async def test_obeys_reports_and_reaches(world: World) -> None:
    world.go(1.6, 1.0, speed=0.8)
    await until(lambda: Outcome.REACHED in [r.outcome for r in world.server.responses], "reached", 15.0)
    assert distance(world.base.plant.pose, 1.6, 1.0) <= 0.15
    await world.still()
    outcomes = [r.outcome for r in world.server.responses if r.outcome != Outcome.REFUSED]
    assert outcomes == [Outcome.ACCEPTED, Outcome.REACHED]
    reached = world.server.responses[-1]
    assert reached.reached_ns is not None and reached.reached_ns >= reached.command_stamp_ns
    registration = world.server.registrations[0]
    assert registration["kind"] == "wifibot" and registration["session"]
    statuses = world.server.statuses
    assert max(status.linear_mps for status in statuses) > 0.2
    last = statuses[-1]
    assert (last.robot, last.area, last.ip, last.faults, last.stopped_by) == (ROBOT, "camp", "127.0.0.1", (), None)
    assert last.x is not None and last.y is not None
    assert distance(world.base.plant.pose, last.x, last.y) < 0.03
    assert last.battery == pytest.approx(0.9)


async def test_stands_still_without_a_command_and_says_why(world: World) -> None:
    await until(lambda: world.server.statuses and world.server.statuses[-1].x is not None, "a localized status")
    status = world.server.statuses[-1]
    assert status.stopped_by is not None and status.stopped_by.code is ReasonCode.COMMAND_STALE
    assert all(twist == STOP for _, twist in world.base.setpoints)
    await until(lambda: len(world.base.setpoints) > 10, "zero commanded, not just left unsaid")


async def test_statuses_come_ten_times_a_second(world: World) -> None:
    await until(lambda: world.server.statuses, "a status")
    before = len(world.server.statuses)
    await asyncio.sleep(1.0)
    assert 8 <= len(world.server.statuses) - before <= 12
    numbers = [status.sequence for status in world.server.statuses]
    assert numbers == sorted(set(numbers))


async def test_stops_half_a_second_after_commands_fall_silent(world: World) -> None:
    world.go()
    await world.moving()
    world.order = None
    await world.still()
    stopped_s = world.first_zero_after(world.last_command_s)
    assert stopped_s is not None
    assert 0.45 <= stopped_s - world.last_command_s <= 0.75
    await until(lambda: world.server.statuses[-1].stopped_by is not None, "the reason")
    reason = world.server.statuses[-1].stopped_by
    assert reason is not None and reason.code is ReasonCode.COMMAND_STALE


async def test_stops_half_a_second_after_poses_fall_silent(world: World) -> None:
    world.go()
    await world.moving()
    world.camera_works = False
    silent_s = world.clock.monotonic_s()
    await world.still()
    stopped_s = world.first_zero_after(silent_s)
    assert stopped_s is not None and 0.3 <= stopped_s - silent_s <= 0.75
    world.camera_works = True
    await world.moving()


async def test_an_order_to_wait_is_obeyed_at_once(world: World) -> None:
    world.go()
    await world.moving()
    world.order = None
    before = len(world.base.setpoints)
    command = world.orders.waiting(world.clock.now_ns())
    assert world.agent is not None
    world.server.send(command)
    await until(lambda: any(t == STOP for _, t in world.base.setpoints[before:]), "the stop")
    await world.still()
    assert world.agent.pilot.gate.current == command


async def test_an_emergency_stop_stops_at_once_and_holds_until_released(world: World) -> None:
    world.go()
    await world.moving()
    world.server.send(EmergencyStop(engaged=True, epoch=1, by="anna", reason="smoke"))
    sent_s = world.clock.monotonic_s()
    await world.still()
    stopped_s = world.first_zero_after(sent_s)
    assert stopped_s is not None and stopped_s - sent_s < 0.2  # of which 0.1 s is for a busy machine
    assert len([t for at, t in world.base.setpoints if at > sent_s and t != STOP]) <= 2, (
        "one on its way, one more at most"
    )
    await asyncio.sleep(0.7)
    assert not [t for at, t in world.base.setpoints if at > stopped_s and t != STOP]
    status = world.server.statuses[-1]
    assert status.stopped_by is not None and status.stopped_by.code is ReasonCode.EMERGENCY_STOP
    world.server.send(EmergencyStop(engaged=False, epoch=2))
    await world.moving()


async def test_what_is_in_the_protective_field_stops_it_whatever_the_server_says(world: World) -> None:
    world.go()
    await world.moving()
    world.base.ranges_mm = [160] * 5  # 0.11 m before its front: at 0.25 m/s the field reaches 0.13 m
    seen_s = world.clock.monotonic_s()
    await world.still()
    stopped_s = world.first_zero_after(seen_s)
    assert stopped_s is not None and stopped_s - seen_s < 0.15  # of which 0.1 s is for a busy machine
    await until(lambda: world.server.statuses[-1].stopped_by is not None, "the reason")
    reason = world.server.statuses[-1].stopped_by
    assert reason is not None and reason.code is ReasonCode.PROTECTIVE_FIELD
    assert reason.since_ns is not None and 0 <= world.clock.now_ns() - reason.since_ns < 2_000_000_000
    world.base.ranges_mm = [0] * 5
    await world.moving()
    assert world.clock.monotonic_s() - stopped_s > 0.9, "clear for a while first"


async def test_a_silent_scanner_stops_it(world: World) -> None:
    world.go()
    await world.moving()
    world.base.scans = False
    await world.still()
    await until(lambda: world.server.statuses[-1].faults, "the fault")
    assert "safety scanner" in world.server.statuses[-1].faults[0]


async def test_answers_to_a_stop_by_broadcast_leave_no_gap_in_the_servers_statuses(world: World) -> None:
    clock, statuses = world.clock, world.server.statuses
    await until(lambda: len(statuses) > 1, "statuses")
    for number in range(3):
        stop = EmergencyStop(engaged=True, epoch=number + 1, stamp_ns=clock.now_ns(), by="anna")
        await StopBroadcast(KEY, clock, [ROBOT]).send(stop, [(LOOPBACK_BROADCAST, LAB.ports.stop_udp)], "127.0.0.1")
    told = len(statuses)
    await until(lambda: len(statuses) > told + 1, "more statuses")
    assert {later.sequence - before.sequence for before, later in pairwise(statuses)} == {1}


async def test_a_stop_by_broadcast_stops_it_with_a_dead_server_and_until_a_newer_release(world: World) -> None:
    world.go()
    await world.moving()
    await world.server.stop()
    clock = world.clock
    stop = EmergencyStop(engaged=True, epoch=clock.now_ns() // 1_000_000, stamp_ns=clock.now_ns(), by="anna")
    broadcast = StopBroadcast(KEY, clock, [ROBOT])
    sent_s = clock.monotonic_s()
    await broadcast.send(stop, [(LOOPBACK_BROADCAST, LAB.ports.stop_udp)], "127.0.0.1")
    stopped_s = world.first_zero_after(sent_s)
    assert stopped_s is not None and stopped_s - sent_s < 0.2, "not after half a second without commands"
    assert broadcast.answers[ROBOT].stop_epoch == stop.epoch
    await world.server.start()
    await until(lambda: world.server.streams, "the stream")
    assert world.server.latch.engaged is False
    await asyncio.sleep(0.5)
    assert world.speed == 0.0
    await until(lambda: world.server.statuses[-1].stop_epoch == stop.epoch, "a status that tells the server")
    world.server.send(EmergencyStop(engaged=False, epoch=stop.epoch + 1))
    await world.moving()


async def test_an_emergency_stop_survives_a_restart_of_the_server(world: World) -> None:
    world.go()
    await world.moving()
    world.server.send(EmergencyStop(engaged=True, epoch=1))
    await world.still()
    await world.server.stop()
    await world.server.start()
    registrations = len(world.server.registrations)
    await until(lambda: world.server.streams, "a new stream", 10.0)
    await until(lambda: len(world.server.registrations) > registrations, "a new registration, before it is due", 2.0)
    await asyncio.sleep(0.4)
    assert world.speed == 0.0
    world.server.send(EmergencyStop(engaged=False, epoch=2))
    await world.moving()


async def test_survives_a_restart_of_the_server(world: World) -> None:
    world.go()
    await world.moving()
    await world.server.stop()
    await world.still()
    await world.server.start()
    await world.moving()


async def test_notices_a_server_that_hangs(world: World) -> None:
    world.go()
    await world.moving()
    world.server.mute = True
    await world.still()
    before = world.server.requests
    await until(lambda: world.server.requests > before, "a new attempt", 3.0)
    world.server.mute = False
    await world.moving()


async def test_refuses_an_older_guidance(world: World) -> None:
    world.orders = Orders(ROBOT, epoch=7)
    world.order = world.orders.waiting
    await until(lambda: Outcome.ACCEPTED in [r.outcome for r in world.server.responses], "waiting")
    older = Orders(ROBOT, epoch=6)
    for _ in range(5):
        world.server.send(older.move_to(world.clock.now_ns(), 7.0, 1.0))
        await asyncio.sleep(0.05)
    await until(lambda: "newer guidance" in world.server.responses[-1].reason, "a refusal")
    assert [r.command_order[0] for r in world.server.responses if "newer guidance" in r.reason] == [6]
    assert all(twist == STOP for _, twist in world.base.setpoints)


async def test_garbage_on_the_command_stream_changes_nothing(world: World) -> None:
    world.go()
    await world.moving()
    for text in ("", "{}", "not JSON", '{"robot": "wifibot-14", "movement": "Fly"}', "[" * 2000):
        world.server.send(text)
    foreign = Orders("wifibot-15").waiting(world.clock.now_ns()).model_copy(update={"epoch": 99})
    world.server.send(foreign)
    await asyncio.sleep(0.5)
    assert world.speed > 0.25


async def test_forged_old_repeated_and_foreign_poses_have_no_effect(world: World) -> None:
    await until(lambda: world.server.statuses and world.server.statuses[-1].x is not None, "localized")
    assert world.agent is not None
    counts, here = world.agent.socket.counts, world.base.plant.pose
    wrong, now_ns = SE2(5.0, 3.0, 1.0), world.clock.now_ns()
    good = world.server.send_pose(tracked(ROBOT, here, now_ns))
    before = counts.undecodable, counts.foreign, dict(counts.verdicts)
    world.server.send_pose(tracked(ROBOT, wrong, now_ns + 1), key=b"not the key")
    world.server.send_bytes(b"LP" + b"\0" * 40)
    world.server.send_bytes(b"L")
    world.server.send_bytes(good)
    world.server.send_pose(tracked(ROBOT, wrong, now_ns + 2), sequence=7)
    world.server.send_pose(tracked("wifibot-15", wrong, now_ns + 3))
    await until(lambda: counts.foreign == before[1] + 1, "all datagrams")
    assert counts.undecodable == before[0] + 3
    assert counts.verdicts[Verdict.DUPLICATE] == before[2][Verdict.DUPLICATE] + 1
    assert counts.verdicts[Verdict.OUT_OF_ORDER] == before[2][Verdict.OUT_OF_ORDER] + 1
    seen = len(world.server.statuses)
    await until(lambda: len(world.server.statuses) > seen + 2, "more statuses")
    for status in world.server.statuses:
        if status.x is not None and status.y is not None:
            assert distance(here, status.x, status.y) < 0.01


async def test_responses_are_delivered_though_the_server_fails_at_first(world: World) -> None:
    world.server.response_failures = 3
    world.order = world.orders.waiting
    await until(lambda: Outcome.ACCEPTED in [r.outcome for r in world.server.responses], "the response")


async def test_a_wrong_token_is_told_and_tried_again_slowly(caplog: pytest.LogCaptureFixture) -> None:
    world = World()
    await world.start(token="wrong")
    try:
        await until(lambda: world.server.requests >= 2, "requests")
        await asyncio.sleep(1.0)
        assert world.server.requests <= 4
        assert "does not know the token (401)" in caplog.text
        assert world.speed == 0.0
    finally:
        await world.stop()


async def test_a_restarted_base_stops_until_it_is_aligned_again(world: World) -> None:
    world.go()
    await world.moving()
    world.base.restart()
    await world.moving()
    assert world.base.plant.odometry.x < 2.0
    x = world.base.plant.pose.x + 0.6
    world.go(x, 1.0, speed=0.8)
    await until(lambda: Outcome.REACHED in [r.outcome for r in world.server.responses], "reached", 10.0)
    assert abs(world.base.plant.pose.y - 1.0) < 0.15


async def test_a_robot_whose_base_is_gone_says_so(world: World) -> None:
    world.go()
    await world.moving()
    port = world.base.port
    await world.base.stop()
    await until(lambda: world.server.statuses[-1].faults, "a fault in the status")
    reason = world.server.statuses[-1].stopped_by
    assert reason is not None and reason.code is ReasonCode.DRIVER_FAULT
    world.base = FakeBase(ROBOT, world.base.plant.pose, KEY)
    await world.base.start(port)
    await world.moving()


async def test_the_end_of_the_agent_stops_the_base(world: World) -> None:
    world.go()
    await world.moving()
    await world.stop_agent()
    ended_s = world.clock.monotonic_s()
    await world.still()
    assert world.base.setpoints[-1][1] == STOP
    assert world.base.setpoints[-1][0] <= ended_s + 0.1


async def test_a_restarted_agent_goes_on(world: World) -> None:
    world.go()
    await world.moving()
    await world.stop_agent()
    await world.still()
    await world.start_agent()
    await world.moving()
    assert world.server.registrations[0]["session"] != world.server.registrations[-1]["session"]


async def test_the_pacer_keeps_its_rate_and_counts_overruns() -> None:
    clock = SimulatedClock()
    pacer = Pacer(clock, 20.0)
    rounds: list[float] = []

    async def loop() -> None:
        while True:
            rounds.append(clock.monotonic_s())
            if len(rounds) == 3:
                clock.wait(0.12)  # a round that takes too long
            await pacer.wait()

    task = asyncio.create_task(loop())
    await clock.advance(0.4)
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task
    assert pacer.overruns == 1
    assert rounds == pytest.approx([0.0, 0.05, 0.1, 0.25, 0.3, 0.35, 0.4])


@pytest.mark.parametrize(
    ("arguments", "environment", "message"),
    [
        (["wifibot-14"], {}, "LILLIPUT_LAB"),
        (["wifibot-99"], {"LILLIPUT_LAB": "labs/gulliver.yaml"}, "no vehicle 'wifibot-99'.*wifibot-14"),
        (["wifibot-14", "--lab", "nowhere.yaml"], {}, "nowhere.yaml"),
        (["wifibot-14", "--server", "8000"], {"LILLIPUT_LAB": "labs/gulliver.yaml"}, "http://HOST:PORT"),
        (["wifibot-14"], {"LILLIPUT_LAB": "labs/gulliver.yaml", "LILLIPUT_UDP_KEY": "xyz"}, "hexadecimal"),
    ],
)
def test_wrong_settings_are_told_in_a_sentence(arguments: list[str], environment: dict[str, str], message: str) -> None:
    with pytest.raises(SystemExit, match=message):
        main(arguments, environment)


def test_an_unknown_driver_is_told(tmp_path: Path) -> None:
    text = re.sub(
        r"    wifibot-1[45]: \[\[.*\n", "", Path("labs/gulliver.yaml").read_text()
    )  # tours are for simulated ones
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        text.replace(
            "    driver: sim\n    tag: {family: tag36h11, id: 14",
            "    driver: tractor\n    tag: {family: tag36h11, id: 14",
        )
    )
    with pytest.raises(SystemExit, match="driver 'tractor'"):
        main(["wifibot-14", "--lab", str(lab)], {})


def test_the_driver_of_the_lab_file_talks_to_the_lab() -> None:
    assert isinstance(make_driver(DriverSite(LAB.vehicle(ROBOT), LAB, SystemClock(), KEY)), SimDriver)
