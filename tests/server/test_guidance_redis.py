"""Guidance over a real Redis: one is active, a stand-by takes over, what is durable survives, nothing is written without the
lease."""

import asyncio
import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Iterator
from contextlib import aclosing, asynccontextmanager, suppress
from pathlib import Path

import pytest

from agents.safety import CommandGate, Verdict
from protocol import keys
from protocol.bus import Bus
from protocol.channels import COMMANDS, EMERGENCY_STOP, EVENTS, GUIDANCE, LAB_INSTANCE, OBSTACLES, POSES, STATUSES
from protocol.clock import SimulatedClock, SystemClock
from protocol.codec import decode, encode
from protocol.messages import (
    Assignment,
    AssignmentState,
    Command,
    EmergencyStop,
    Movement,
    QueuedRoute,
    Reason,
    ReasonCode,
    SpeedZone,
)
from server.guidance.fleet import Guidance
from server.guidance.parameters import GuidanceParameters
from server.guidance.service import GuidanceService
from server.guidance.snapshot import Outcome
from server.guidance.store import GuidanceStore
from tests.redis_fixture import RedisServer
from tests.server.guidance_scenario import LAB, ROBOT, Course, assignment, raster, status, tracked

COURSE = Course([(1.05, 1.0), (4.0, 1.0)])
SECOND = 1_000_000_000
EPOCHS_BEGIN_S = 1_577_836_800
ROOT = Path(__file__).parents[2]


async def until(condition: Callable[[], Awaitable[bool]], limit_s: float = 5.0) -> float:
    """Seconds until the condition held; fails after the limit."""
    began = time.monotonic()
    while not await condition():
        assert time.monotonic() - began < limit_s, "it did not come true"
        await asyncio.sleep(0.01)
    return time.monotonic() - began


async def plan(bus: Bus, leg: int = 0) -> None:
    for name, waypoint in COURSE.waypoints().items():
        await bus.redis.hset(keys.WAYPOINTS, name, encode(waypoint))  # pyright: ignore[reportGeneralTypeIssues]
    await bus.redis.hset(keys.ROUTES, "r", encode(COURSE.routes()["r"]))  # pyright: ignore[reportGeneralTypeIssues]
    await bus.redis.hset(keys.ASSIGNMENTS, ROBOT, encode(assignment(leg=leg)))  # pyright: ignore[reportGeneralTypeIssues]


async def assigned(bus: Bus) -> Assignment:
    raw = await bus.redis.hget(keys.ASSIGNMENTS, ROBOT)  # pyright: ignore[reportGeneralTypeIssues]
    assert isinstance(raw, bytes)
    return decode(Assignment, raw)


async def keep_seen(bus: Bus, x: Callable[[], float] = lambda: 1.0) -> None:
    """A robot that stands at (x, 1), seen and heard, on an empty floor."""
    while True:
        now_ns = time.time_ns()
        await bus.publish(POSES, ROBOT, tracked(ROBOT, x(), 1.0, stamp_ns=now_ns))
        await bus.publish(STATUSES, ROBOT, status(ROBOT, now_ns))
        await bus.publish(OBSTACLES, LAB_INSTANCE, raster(stamp_ns=now_ns))
        await asyncio.sleep(0.05)


@asynccontextmanager
async def running(work: Callable[[], Awaitable[None]]) -> AsyncGenerator["asyncio.Task[None]"]:
    task = asyncio.ensure_future(work())
    try:
        yield task
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


@pytest.fixture
async def bus(redis_url: str) -> AsyncIterator[Bus]:
    bus = Bus.connect(redis_url)
    yield bus
    await bus.close()


def service(bus: Bus) -> GuidanceService:
    return GuidanceService(LAB, bus.redis, SystemClock(), GuidanceParameters())


async def command(bus: Bus) -> Command | None:
    return await bus.latest(COMMANDS, ROBOT)


async def test_it_commands_every_vehicle_and_advances_the_assignment(bus: Bus) -> None:
    await plan(bus)
    received: list[Command] = []

    async def listen() -> None:
        async for item in bus.subscribe(COMMANDS, instance=ROBOT):
            received.append(item.message)  # noqa: PERF401  # it never ends

    async with running(lambda: keep_seen(bus)), running(listen), running(service(bus).run):

        async def on_second_leg() -> bool:
            return (await assigned(bus)).leg == 1 and len(received) > 12

        await until(on_second_leg)
    orders = [said.order for said in received]
    assert orders == sorted(set(orders))
    gaps = [(b.stamp_ns - a.stamp_ns) / 1e9 for a, b in itertools.pairwise(received)]
    assert sorted(gaps)[len(gaps) // 2] == pytest.approx(0.1, abs=0.03)
    assert set(await bus.latest_all(COMMANDS)) == {vehicle.id for vehicle in LAB.vehicles}
    state = await bus.latest(GUIDANCE, ROBOT)
    assert state is not None
    assert state.reason.code is ReasonCode.ROUTE
    kinds = [item.message.kind for item in await bus.history(EVENTS)]
    assert "guidance_active" in kinds


async def test_a_large_fleet_is_told_in_one_go(bus: Bus) -> None:
    store, robots = GuidanceStore(bus.redis, SystemClock()), [f"robot-{number}" for number in range(2500)]
    epoch = await store.acquire(0)
    assert epoch is not None
    commands = {
        robot: Command(
            robot=robot,
            epoch=epoch,
            sequence=number,
            stamp_ns=1,
            deadline_ns=2,
            movement=Movement.NO_ACTION,
            reason=Reason(code=ReasonCode.IDLE),
        )
        for number, robot in enumerate(robots)
    }
    async with aclosing(bus.subscribe_raw(COMMANDS)) as said:
        assert not (await anext(said)).messages
        assert await store.say(Outcome(commands=commands, states={}, changes=(), events=()), epoch)
        together = (await anext(said)).messages
    assert {robot: decode(Command, data) for robot, data in together.items()} == commands
    assert await bus.latest_all(COMMANDS) == commands
    assert await bus.latest_all(GUIDANCE) == {}


async def test_an_assignment_that_somebody_changed_meanwhile_is_left_alone(bus: Bus) -> None:
    await plan(bus)
    now_ns = time.time_ns()
    await bus.publish(POSES, ROBOT, tracked(ROBOT, 1.0, 1.0, stamp_ns=now_ns))
    await bus.publish(STATUSES, ROBOT, status(ROBOT, now_ns))
    await bus.publish(OBSTACLES, LAB_INSTANCE, raster(stamp_ns=now_ns))
    store = GuidanceStore(bus.redis, SystemClock())
    epoch = await store.acquire(0)
    assert epoch is not None
    outcome = Guidance(LAB).cycle(await store.snapshot(), epoch)
    assert [change.after.leg for change in outcome.changes] == [1]
    paused = assignment(state=AssignmentState.PAUSED)
    await bus.redis.hset(keys.ASSIGNMENTS, ROBOT, encode(paused))  # pyright: ignore[reportGeneralTypeIssues]
    assert await store.say(outcome, epoch)
    assert await assigned(bus) == paused


async def test_without_the_lease_nothing_is_written(bus: Bus) -> None:
    await plan(bus)
    store = GuidanceStore(bus.redis, SystemClock())
    epoch = await store.acquire(0)
    assert epoch is not None
    assert await store.acquire(0) is None
    outcome = Guidance(LAB).cycle(await store.snapshot(), epoch)
    await store.release(epoch)
    newer = await store.acquire(0)
    assert newer is not None
    assert newer > epoch
    await bus.redis.delete(keys.live(COMMANDS.name))
    before = await bus.redis.dbsize()
    assert not await store.say(outcome, epoch)
    assert await bus.redis.dbsize() == before
    await store.release(epoch)
    assert await store.acquire(0) is None


async def test_a_new_epoch_is_above_what_robots_obeyed(bus: Bus) -> None:
    """As after a power cut that cost Redis its newest counter, with a clock that went ahead before."""
    ahead = time.time_ns() // SECOND - EPOCHS_BEGIN_S + 100_000
    obeyed = status(ROBOT, time.time_ns()).model_copy(update={"command_order": (ahead, 7)})
    await bus.publish(STATUSES, ROBOT, obeyed)
    guidance = service(bus)
    async with running(guidance.run):

        async def active() -> bool:
            return guidance.epoch is not None

        await until(active)
        assert guidance.epoch == ahead + 1
        await bus.publish(STATUSES, ROBOT, obeyed.model_copy(update={"command_order": (ahead + 5000, 1)}))

        async def above() -> bool:
            return guidance.epoch is not None and guidance.epoch > ahead + 5000

        await until(above)
        nonsense = obeyed.model_copy(update={"command_order": (2**60, 1)})
        epoch = guidance.epoch
        await bus.publish(STATUSES, ROBOT, nonsense)
        last = await command(bus)
        assert last is not None

        async def goes_on() -> bool:
            said = await command(bus)
            return said is not None and said.sequence > last.sequence + 3

        await until(goes_on)
        assert guidance.epoch == epoch


async def test_epochs_grow_with_the_clock_though_redis_forgot_them(bus: Bus) -> None:
    clock = SimulatedClock()
    store = GuidanceStore(bus.redis, clock)

    async def next_epoch(above: int = 0) -> int:
        await bus.redis.delete(keys.GUIDANCE_LEASE)
        epoch = await store.acquire(above)
        assert epoch is not None
        assert await bus.redis.get(keys.GUIDANCE_EPOCH) == str(epoch).encode()
        assert await bus.redis.get(keys.GUIDANCE_LEASE) == str(epoch).encode()
        return epoch

    first = await next_epoch()
    assert first == clock.now_ns() // SECOND - EPOCHS_BEGIN_S
    assert await next_epoch() == first + 1
    assert await next_epoch(above=first + 10) == first + 11
    await clock.advance(60.0)
    await bus.redis.flushall()
    assert await next_epoch() == first + 60


async def test_a_clock_that_starts_in_1970_believes_the_robots(bus: Bus) -> None:
    store = GuidanceStore(bus.redis, SimulatedClock(start_ns=SECOND))
    assert await store.acquire(0) == 1
    await bus.publish(STATUSES, ROBOT, status(ROBOT).model_copy(update={"command_order": (217_000_000, 7)}))
    assert await store.highest_epoch(await store.snapshot()) == 217_000_000


async def test_an_emergency_stop_that_cannot_be_read_counts_as_engaged(bus: Bus) -> None:
    await bus.redis.hset(keys.live(EMERGENCY_STOP.name), LAB_INSTANCE, b"garbage")  # pyright: ignore[reportGeneralTypeIssues]
    async with running(service(bus).run):

        async def waits() -> bool:
            said = await command(bus)
            return said is not None and said.reason.code is ReasonCode.EMERGENCY_STOP

        await until(waits)


async def test_what_does_not_decode_is_left_out(bus: Bus) -> None:
    await plan(bus)
    await bus.redis.hset(keys.live(POSES.name), ROBOT, b"{}")  # pyright: ignore[reportGeneralTypeIssues]
    await bus.redis.hset(keys.WAYPOINTS, "bad", b"\xff")  # pyright: ignore[reportGeneralTypeIssues]
    await bus.publish(STATUSES, ROBOT, status(ROBOT, time.time_ns()))
    async with running(service(bus).run):

        async def waits() -> bool:
            said = await command(bus)
            return said is not None and said.reason.code is ReasonCode.POSE_STALE

        await until(waits)


async def test_it_goes_on_by_itself_after_redis_was_killed_and_forgets_nothing(
    bus: Bus, redis_server: RedisServer
) -> None:
    await plan(bus, leg=1)
    await bus.publish(EMERGENCY_STOP, LAB_INSTANCE, EmergencyStop(engaged=True, epoch=1))
    guidance = service(bus)
    async with running(guidance.run):

        async def stopped() -> bool:
            said = await command(bus)
            return said is not None and said.reason.code is ReasonCode.EMERGENCY_STOP

        await until(stopped)
        first = await command(bus)
        assert first is not None
        redis_server.kill()
        await asyncio.sleep(0.3)  # the outage, not a wait for something
        redis_server.start()
        killed_ns = time.time_ns()

        async def again() -> bool:
            said = await command(bus)
            return said is not None and said.stamp_ns > killed_ns

        assert await until(again) < 2.0
        said = await command(bus)
        assert said is not None
        assert said.order > first.order
        assert said.reason.code is ReasonCode.EMERGENCY_STOP
        assert (await assigned(bus)).leg == 1


@pytest.fixture
def start_process(redis_url: str, tmp_path: Path) -> Iterator[Callable[[], "subprocess.Popen[bytes]"]]:
    started: list[subprocess.Popen[bytes]] = []

    def start() -> "subprocess.Popen[bytes]":
        environment = {
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "LILLIPUT_LAB": str(ROOT / "labs/gulliver.yaml"),
            "LILLIPUT_STATE": str(tmp_path),
            "REDIS_URL": redis_url,
        }
        process = subprocess.Popen([sys.executable, "-m", "server.guidance"], env=environment)
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.wait(10)


async def test_a_stand_by_takes_over_within_two_seconds_of_a_kill(
    bus: Bus, start_process: Callable[[], "subprocess.Popen[bytes]"]
) -> None:
    async def epoch() -> int:
        said = await command(bus)
        return said.epoch if said is not None else 0

    async def first_commands() -> bool:
        return await epoch() > 0

    first = start_process()
    await until(first_commands, 15.0)
    first_epoch = await epoch()
    start_process()
    attempts_before = await bus.redis.info("clients")
    assert attempts_before["connected_clients"] >= 2

    async def both_connected() -> bool:
        return (await bus.redis.info("clients"))["connected_clients"] > attempts_before["connected_clients"]

    await until(both_connected, 15.0)
    assert await epoch() == first_epoch

    first.send_signal(signal.SIGKILL)

    async def taken_over() -> bool:
        return await epoch() > first_epoch

    assert await until(taken_over) < 2.0
    kinds = [(item.message.kind, item.message.text) for item in await bus.history(EVENTS)]
    assert ("guidance_active", f"guidance is active, epoch {await epoch()}") in kinds


async def test_one_that_was_held_up_says_nothing_any_more_and_stands_by(
    bus: Bus, start_process: Callable[[], "subprocess.Popen[bytes]"]
) -> None:
    """A process that is stopped for longer than its lease, as by a machine that swaps or sleeps, wakes to another in charge."""
    gate, heard = CommandGate(ROBOT), list[Command]()

    async def listen() -> None:
        async for item in bus.subscribe(COMMANDS, instance=ROBOT):
            heard.append(item.message)
            gate.offer(item.message, time.time_ns(), time.monotonic())

    async def some() -> bool:
        return len(heard) > 3

    async with running(listen):
        first = start_process()
        await until(some, 15.0)
        old = heard[-1]
        second = start_process()
        clients = (await bus.redis.info("clients"))["connected_clients"]

        async def stands_by() -> bool:
            return (await bus.redis.info("clients"))["connected_clients"] > clients

        await until(stands_by, 15.0)
        first.send_signal(signal.SIGSTOP)

        async def taken_over() -> bool:
            return heard[-1].epoch > old.epoch

        assert await until(taken_over) < 2.0
        new_epoch, so_far = heard[-1].epoch, len(heard)
        first.send_signal(signal.SIGCONT)

        async def a_second_of_commands() -> bool:
            return len(heard) > so_far + 10

        await until(a_second_of_commands)
        assert {command.epoch for command in heard[so_far:]} == {new_epoch}
        assert gate.counts[Verdict.OLD_EPOCH] == gate.counts[Verdict.OLD] == 0
        # What the older brain might still have on the way is refused.
        late = old.model_copy(update={"sequence": 10**6, "deadline_ns": time.time_ns() + SECOND})
        assert gate.offer(late, time.time_ns(), time.monotonic()) is Verdict.OLD_EPOCH
        assert gate.current is not None
        assert gate.current.epoch == new_epoch
        second.send_signal(signal.SIGKILL)

        async def back() -> bool:
            return heard[-1].epoch > new_epoch

        assert await until(back) < 2.0


async def test_one_that_gets_the_lease_back_remembers_nothing_of_before(bus: Bus) -> None:
    """Meanwhile the robot was driven elsewhere: not through the waypoint that lies between there and here."""
    course, x = Course([(2.0, 1.0), (4.0, 1.0)]), 1.0
    for name, waypoint in course.waypoints().items():
        await bus.redis.hset(keys.WAYPOINTS, name, encode(waypoint))  # pyright: ignore[reportGeneralTypeIssues]
    await bus.redis.hset(keys.ROUTES, "r", encode(course.routes()["r"]))  # pyright: ignore[reportGeneralTypeIssues]
    await bus.redis.hset(keys.ASSIGNMENTS, ROBOT, encode(assignment()))  # pyright: ignore[reportGeneralTypeIssues]
    guidance, heard = service(bus), list[Command]()

    async def listen() -> None:
        async for item in bus.subscribe(COMMANDS, instance=ROBOT):
            heard.append(item.message)

    async def drives() -> bool:
        return bool(heard) and heard[-1].movement is Movement.MOVE_TO

    async with running(listen), running(lambda: keep_seen(bus, lambda: x)), running(guidance.run):
        await until(drives)
        await bus.redis.set(keys.GUIDANCE_LEASE, "another's")

        async def stands_by() -> bool:
            return guidance.epoch is None

        await until(stands_by)
        so_far, x = len(heard), 3.0

        async def elsewhere() -> bool:
            seen = await bus.latest(POSES, ROBOT)
            return seen is not None and seen.x == x

        await until(elsewhere)
        await bus.redis.delete(keys.GUIDANCE_LEASE)

        async def on_again() -> bool:
            return len(heard) > so_far + 3 and heard[-1].movement is Movement.MOVE_TO

        await until(on_again)
        assert (await assigned(bus)).leg == 0
    assert [said.order for said in heard] == sorted({said.order for said in heard})
    assert heard[so_far].sequence > heard[so_far - 1].sequence


async def test_the_next_of_the_queue_begins_and_the_speed_zones_drawn_count(bus: Bus) -> None:
    await plan(bus)
    entry = QueuedRoute(id="next", route="r", queued_ns=1, queued_by="anna")
    over = assignment(state=AssignmentState.DONE).model_copy(update={"queue": (entry,)})
    zone = SpeedZone(id="slow", outline=((0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)), speed_mps=0.1)
    await bus.redis.hset(keys.ASSIGNMENTS, ROBOT, encode(over))  # pyright: ignore[reportGeneralTypeIssues]
    await bus.redis.hset(keys.SPEED_ZONES, "slow", encode(zone))  # pyright: ignore[reportGeneralTypeIssues]
    async with running(lambda: keep_seen(bus)), running(service(bus).run):

        async def begun() -> bool:
            return (await assigned(bus)).id == "next"

        await until(begun)

        async def drives() -> bool:
            said = await command(bus)
            return said is not None and said.movement is Movement.MOVE_TO

        await until(drives)
        said = await command(bus)
        assert said is not None
        assert said.speed_mps <= 0.1
    after = await assigned(bus)
    assert (after.started_by, after.queue) == ("anna", ())


async def test_sigterm_ends_it_at_once_and_frees_the_lease(
    bus: Bus, start_process: Callable[[], "subprocess.Popen[bytes]"]
) -> None:
    process = start_process()

    async def commands() -> bool:
        said = await command(bus)
        return said is not None and said.movement is Movement.NO_ACTION

    await until(commands, 15.0)
    began = time.monotonic()
    process.send_signal(signal.SIGTERM)
    assert await asyncio.to_thread(process.wait, 5) == 0
    assert time.monotonic() - began < 2.0
    assert await bus.redis.get(keys.GUIDANCE_LEASE) is None


def test_bad_use_ends_with_a_sentence(tmp_path: Path) -> None:
    def end(*arguments: str, **environment: str) -> tuple[int, str]:
        done = subprocess.run(
            [sys.executable, "-m", "server.guidance", *arguments],
            env={**os.environ, "PYTHONPATH": str(ROOT), "LILLIPUT_LAB": "", "REDIS_URL": "", **environment},
            capture_output=True,
            timeout=30,
            check=False,
        )
        return done.returncode, done.stderr.decode()

    code, text = end()
    assert code != 0
    assert "LILLIPUT_LAB" in text
    code, text = end("--look-ahead", "0.2", LILLIPUT_LAB="x", REDIS_URL="unix:///nowhere")
    assert code == 2
    assert "does not steer" in text
    code, text = end(LILLIPUT_LAB=str(tmp_path / "none.yaml"), REDIS_URL="unix:///nowhere")
    assert code != 0
    assert "cannot read the lab file" in text
    assert "Traceback" not in text
