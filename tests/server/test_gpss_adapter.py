"""GPSS robots over Redis: they are told what guidance and the emergency stop say, and what they say is checked like datagrams."""

import asyncio
import json
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from typing import Any, cast

import pytest
import redis.asyncio

from protocol import keys
from protocol.bus import Bus
from protocol.channels import COMMANDS, EMERGENCY_STOP, EVENTS, LAB_INSTANCE, POSES, RESPONSES, STATUSES
from protocol.clock import SystemClock
from protocol.codec import encode
from protocol.gpss import GpssCommand, Name, key
from protocol.messages import Command, EmergencyStop, Mode, Movement, Outcome, Response, Status, Target
from server.gpss.orders import LIFETIME_MS, RobotOrders
from server.gpss.service import GpssService
from server.repositories.documents import Store
from server.repositories.emergency_stop import read_emergency_stop
from tests.redis_fixture import RedisServer
from tests.server.samples import START_NS, command, pose
from tests.server.service import ROBOT, gulliver, until

CLOCK = SystemClock()
FREE, ENGAGED = EmergencyStop(engaged=False, epoch=1), EmergencyStop(engaged=True, epoch=2, reason="smoke")


def at(seconds: float) -> tuple[int, float]:
    return START_NS + round(seconds * 1e9), seconds


class Told:
    """The orders of one robot, on a clock of the test's own."""

    def __init__(self) -> None:
        self.orders = RobotOrders(ROBOT, START_NS)

    def by(self, seconds: float, latch: EmergencyStop | None = FREE) -> GpssCommand | None:
        return self.orders.next(latch, *at(seconds))

    def offer(self, seconds: float, sequence: int, **changes: Any) -> bool:
        order = command(ROBOT, at(seconds)[0], sequence).model_copy(update=changes)
        return self.orders.offer(order, at(seconds)[0])


def test_a_command_becomes_the_report_s_document() -> None:
    told = Told()
    assert told.offer(0.0, 1, target=Target(x=1.5, y=2.5, yaw=0.5))
    document = told.by(0.01)
    assert document is not None
    assert json.loads(document.model_dump_json()) == {
        "command": "MoveTo",
        "x": 1.5,
        "y": 2.5,
        "final_angle": 0.5,
        "speed": 0.3,
        "timestamp": START_NS // 1_000_000 + 10,
        "sequence": START_NS // 1000,
        "deadline": START_NS // 1_000_000 + 500,
    }
    assert told.by(0.02) is None, "said once"


@pytest.mark.parametrize(
    ("movement", "said"),
    [
        (Movement.WAITING, "Waiting"),
        (Movement.NO_ACTION, "NoAction"),
        (Movement.ROTATE, "Rotate"),
        (Movement.DRIVE, "Waiting"),
    ],
)
def test_other_movements_go_by_their_names_and_driving_by_hand_is_waiting(movement: Movement, said: str) -> None:
    told = Told()
    told.offer(0.0, 1, movement=movement, target=Target(x=1.0, y=2.0, yaw=0.5), linear_mps=0.5)
    document = told.by(0.0)
    assert document is not None
    assert (document.command, document.speed) == (said, 0.0)
    assert document.final_angle == (0.5 if said == "Rotate" else None)


def test_older_foreign_and_late_commands_are_not_passed_on() -> None:
    told = Told()
    assert told.offer(0.0, 5)
    assert told.by(0.0) is not None
    assert not told.offer(0.1, 5)
    assert not told.offer(0.1, 4)
    assert not told.offer(0.1, 9, epoch=0)
    assert not told.offer(0.1, 9, robot="wifibot-15")
    assert not told.offer(0.1, 9, deadline_ns=at(0.05)[0])
    assert told.by(0.1) is None
    assert told.offer(0.1, 0, epoch=2)


def test_every_document_has_a_time_and_a_number_of_its_own() -> None:
    told, before = Told(), None
    for sequence in range(20):
        told.offer(0.0, sequence)
        document = told.by(0.0)
        assert document is not None
        if before is not None:
            assert document.timestamp > before.timestamp
            assert document.sequence > before.sequence
        before = document


def test_nothing_is_said_before_the_latch_is_known() -> None:
    told = Told()
    told.offer(0.0, 1)
    assert told.by(0.0, None) is None
    assert told.by(0.1, FREE) is not None


def test_an_emergency_stop_is_waiting_at_once_and_again_until_it_is_released() -> None:
    told = Told()
    told.offer(0.0, 1)
    assert told.by(0.0) is not None
    told.orders.hurry()
    first = told.by(0.01, ENGAGED)
    assert first is not None
    assert first.command is Movement.WAITING
    told.offer(0.1, 2)
    said = [document.command for t in range(2, 100) if (document := told.by(t * 0.01, ENGAGED)) is not None]
    assert len(said) >= 4, "each lives for half a second only"
    assert set(said) == {Movement.WAITING}
    told.offer(1.0, 3)
    document = told.by(1.0, FREE)
    assert document is not None
    assert document.command is Movement.MOVE_TO


def test_an_emergency_stop_is_told_also_where_guidance_never_spoke() -> None:
    told = Told()
    assert told.by(0.0) is None
    told.orders.hurry()
    document = told.by(0.0, ENGAGED)
    assert document is not None
    assert document.command is Movement.WAITING


def test_when_guidance_falls_silent_the_robot_is_told_to_wait() -> None:
    told = Told()
    told.offer(0.0, 1)
    first = told.by(0.0)
    assert first is not None
    assert first.deadline - first.timestamp == LIFETIME_MS
    said = [(t, document) for t in range(1, 300) if (document := told.by(t * 0.01)) is not None]
    assert said[0][0] in (50, 51), "as soon as the last command is over"
    assert {document.command for _, document in said} == {Movement.WAITING}
    assert len(said) > 10


class Robot:
    """Writes documents as a robot does, and reads its own."""

    def __init__(self, bus: Bus) -> None:
        self.bus, self.client = bus, bus.redis

    async def command(self) -> dict[str, Any] | None:
        return await self.read("command")

    async def read(self, name: Name) -> dict[str, Any] | None:
        raw = cast("bytes | None", await self.client.get(key(ROBOT, name)))
        return None if raw is None else json.loads(raw)

    async def say(self, name: Name, document: dict[str, Any] | bytes) -> None:
        data = document if isinstance(document, bytes) else json.dumps(document).encode()
        await self.client.set(key(ROBOT, name), data)

    async def status(self, **changes: Any) -> None:
        await self.say("status", status_document(**changes))


def now_ms() -> int:
    return CLOCK.now_ns() // 1_000_000


def status_document(**changes: Any) -> dict[str, Any]:
    return {
        "x": 1.0,
        "y": 2.0,
        "angle": 0.5,
        "linear_velocity": 0.2,
        "angular_velocity": 0.0,
        "ip": "10.0.0.7",
        "area": "camp",
        "timestamp": now_ms(),
    } | changes


@asynccontextmanager
async def adapted(redis_url: str, clock: SystemClock = CLOCK) -> AsyncGenerator[tuple[GpssService, Robot]]:
    """The adapter with one GPSS robot, in a system whose emergency stop was never engaged."""
    lab = gulliver()
    vehicles = tuple(
        vehicle.model_copy(update={"driver": "gpss-redis"}) if vehicle.id == ROBOT else vehicle
        for vehicle in lab.vehicles
    )
    bus = Bus.connect(redis_url, clock)
    service = GpssService(lab.model_copy(update={"vehicles": vehicles}), bus, clock)
    tasks = [asyncio.ensure_future(part) for part in service.parts()]
    try:
        yield service, Robot(bus)
    finally:
        for task in tasks:
            task.cancel()
        results = await asyncio.gather(*tasks, return_exceptions=True)
        await bus.close()
        assert all(isinstance(result, asyncio.CancelledError) for result in results), results


class _Late(SystemClock):
    """What is written by this clock reaches Redis a fifth of a second late, as when Redis stalled."""

    def now_ns(self) -> int:
        return super().now_ns() - 200_000_000


async def test_what_redis_gets_to_late_still_ends_when_it_says(redis_url: str) -> None:
    late = _Late()
    async with adapted(redis_url, late) as (_, robot):
        ends: dict[Name, list[tuple[int, int]]] = {"command": [], "pose": []}

        async def both() -> bool:
            now_ns = late.now_ns()
            await robot.bus.publish(COMMANDS, ROBOT, command(ROBOT, now_ns, now_ns // 1000))
            await robot.bus.publish(POSES, ROBOT, pose(ROBOT, now_ns))
            for name, found in ends.items():
                pipeline: Any = robot.client.pipeline(transaction=True)
                pipeline.get(key(ROBOT, name)).pttl(key(ROBOT, name)).time()
                data, left_ms, (seconds, microseconds) = await pipeline.execute()
                if data is not None:
                    document = json.loads(data)
                    says = document.get("deadline", document["timestamp"] + round(POSES.stale_after_s * 1e3))
                    found.append((seconds * 1000 + microseconds // 1000 + left_ms, says))
            return all(ends.values())

        await until(both)
    assert all(abs(vanishes - says) <= 1 for found in ends.values() for vanishes, says in found)


async def _believed(robot: Robot, x: float) -> None:
    """Returns when everything that was announced before has been taken in, and the robot may drive."""

    async def passed_on() -> bool:
        await robot.bus.publish(POSES, ROBOT, pose(ROBOT, CLOCK.now_ns(), x))
        where = await robot.read("pose")
        return where is not None and where["x"] == x

    await until(passed_on)
    since_ms = now_ms()

    async def drives() -> bool:
        await order(robot.bus, CLOCK.now_ns() // 1000)
        document = await robot.command()
        return document is not None and document["command"] == "MoveTo" and document["timestamp"] > since_ms

    await until(drives)


async def test_an_announcement_of_before_the_release_engages_nothing(redis_url: str) -> None:
    released = FREE.model_copy(update={"epoch": 3})
    async with adapted(redis_url) as (_, robot):
        await robot.client.hset(keys.live(EMERGENCY_STOP.name), LAB_INSTANCE, encode(released))  # pyright: ignore[reportGeneralTypeIssues]
        await _believed(robot, 1.0)  # it has read of the release
        await robot.client.publish(keys.topic(EMERGENCY_STOP.name, LAB_INSTANCE), encode(ENGAGED))
        await _believed(robot, 2.0)


async def test_an_answer_of_before_the_release_engages_nothing(redis_url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    held, waiting, going_on = False, asyncio.Event(), asyncio.Event()

    async def slowly(source: Store) -> EmergencyStop:
        latch = await read_emergency_stop(source)
        if held:
            waiting.set()
            await going_on.wait()
        return latch

    monkeypatch.setattr("server.gpss.service.read_emergency_stop", slowly)
    async with adapted(redis_url) as (_, robot):
        await robot.bus.publish(EMERGENCY_STOP, LAB_INSTANCE, ENGAGED)
        await commanded(robot, "Waiting")
        held = True
        await waiting.wait()
        await robot.bus.publish(EMERGENCY_STOP, LAB_INSTANCE, FREE.model_copy(update={"epoch": 3}))
        await _believed(robot, 1.0)
        held = False
        going_on.set()
        await _believed(robot, 2.0)


async def order(bus: Bus, sequence: int = 1, **changes: Any) -> Command:
    made = command(ROBOT, CLOCK.now_ns(), sequence).model_copy(update=changes)
    await bus.publish(COMMANDS, ROBOT, made)
    return made


async def commanded(robot: Robot, movement: str) -> dict[str, Any]:
    found: list[dict[str, Any]] = []

    async def told() -> bool:
        document = await robot.command()
        if document is not None and document["command"] == movement:
            found.append(document)
        return bool(found)

    await until(told)
    return found[-1]


async def test_commands_and_poses_reach_the_robot_and_run_out(redis_url: str) -> None:
    async with adapted(redis_url) as (_, robot):
        topics = [key(ROBOT, "command"), key(ROBOT, "pose")]
        async with robot.client.pubsub() as ear:
            await ear.subscribe(*topics)

            async def both() -> bool:
                await order(robot.bus, CLOCK.now_ns() // 1000)
                await robot.bus.publish(POSES, ROBOT, pose(ROBOT, CLOCK.now_ns()))
                return await robot.command() is not None and await robot.read("pose") is not None

            await until(both)
            heard: set[bytes] = set()

            async def both_heard() -> bool:
                item = await ear.get_message(ignore_subscribe_messages=True, timeout=0.5)
                if item is not None:
                    heard.add(cast("bytes", item["channel"]))
                return len(heard) == 2

            await until(both_heard)
        document = await robot.command()
        assert document is not None
        assert document["command"] in ("MoveTo", "Waiting")
        where = await robot.read("pose")
        if where is not None:
            assert (where["x"], where["y"], where["angle"]) == (1.0, 2.0, 0.5)
        assert 0 < await robot.client.pttl(key(ROBOT, "command")) <= LIFETIME_MS
    keys_left = [key(ROBOT, "command"), key(ROBOT, "pose")]
    async with redis.asyncio.Redis.from_url(redis_url) as client:

        async def gone() -> bool:
            return await client.exists(*keys_left) == 0

        await until(gone)  # the adapter has ended: nothing tells the robot to drive any more


async def test_the_emergency_stop_reaches_the_robot_without_guidance(redis_url: str) -> None:
    async with adapted(redis_url) as (_, robot):
        await robot.bus.publish(EMERGENCY_STOP, LAB_INSTANCE, EmergencyStop(engaged=True, epoch=7))
        await commanded(robot, "Waiting")
        await order(robot.bus, 1)
        await asyncio.sleep(0.05)
        assert (await commanded(robot, "Waiting"))["command"] == "Waiting"
        await robot.bus.publish(EMERGENCY_STOP, LAB_INSTANCE, EmergencyStop(engaged=False, epoch=6))
        await order(robot.bus, 2)
        assert (await commanded(robot, "Waiting"))["command"] == "Waiting", "an overtaken release releases nothing"
        await robot.bus.publish(EMERGENCY_STOP, LAB_INSTANCE, EmergencyStop(engaged=False, epoch=8))
        await order(robot.bus, 3)
        await commanded(robot, "MoveTo")


async def kept(robot: Robot) -> Status | None:
    return (await robot.bus.latest_all(STATUSES)).get(ROBOT)


async def test_a_status_is_a_status_like_any_other(redis_url: str) -> None:
    async with adapted(redis_url) as (service, robot):
        await robot.status(battery=0.5, mode="manual", faults=["drive hot"])
        await until(lambda: service.intake.counts["accepted"] == 1)

        async def shown() -> bool:
            return await kept(robot) is not None

        await until(shown)
        status = await kept(robot)
        assert status is not None
        assert (status.x, status.y, status.yaw, status.linear_mps) == (1.0, 2.0, 0.5, 0.2)
        assert (status.ip, status.area, status.battery) == ("10.0.0.7", "camp", 0.5)
        assert (status.mode, status.faults) == (Mode.MANUAL, ("drive hot",))


async def test_a_status_that_is_only_published_counts_too_and_one_that_is_both_counts_once(redis_url: str) -> None:
    async with adapted(redis_url) as (service, robot):
        data = json.dumps(status_document()).encode()

        async def heard() -> bool:
            return await robot.client.publish(key(ROBOT, "status"), data) == 1

        await until(heard)
        await until(lambda: service.intake.counts["accepted"] == 1)
        await robot.say("status", data)
        await asyncio.sleep(0.15)
        assert service.intake.counts == {"received": 1, "accepted": 1}


BAD_STATUSES: list[tuple[str, Any]] = [
    ("undecodable", b"\xff\x00 no text"),
    ("undecodable", b"[]"),
    ("undecodable", b"x" * 5000),
    ("undecodable", {"x": "1.0"}),
    ("undecodable", {"timestamp": 1e300}),
    ("undecodable", {"timestamp": 10**17}),
    ("undecodable", {"angel": 1.0}),
    ("undecodable", {"x": float("nan")}),
    ("undecodable", {"battery": 1.5}),
    ("old", {"age_ms": 1500}),
    ("future", {"age_ms": -1500}),
]


@pytest.mark.parametrize(("cause", "bad"), BAD_STATUSES)
async def test_a_bad_status_is_counted_told_and_without_effect(redis_url: str, cause: str, bad: Any) -> None:
    async with adapted(redis_url) as (service, robot):
        if isinstance(bad, dict):
            age_ms = bad.pop("age_ms", 0) if "age_ms" in bad else 0
            bad = status_document(**{"timestamp": now_ms() - age_ms, **bad})
        await robot.say("status", bad)
        await until(lambda: service.intake.counts[cause] == 1)

        async def told() -> bool:
            events = await robot.bus.history(EVENTS)
            return [received.message.kind for received in events] == [f"gpss_{cause}"]

        await until(told)
        assert await kept(robot) is None
        await robot.status()
        await until(lambda: service.intake.counts["accepted"] == 1)


async def test_repeated_and_overtaken_statuses_are_counted_and_dropped(redis_url: str) -> None:
    async with adapted(redis_url) as (service, robot):
        stamp = now_ms()
        await robot.status(timestamp=stamp)
        await until(lambda: service.intake.counts["accepted"] == 1)
        await robot.status(timestamp=stamp, x=9.0)
        await until(lambda: service.intake.counts["duplicate"] == 1)
        await robot.status(timestamp=stamp - 1, x=9.0)
        await until(lambda: service.intake.counts["out_of_order"] == 1)
        status = await kept(robot)
        assert status is not None
        assert status.x == 1.0


async def answers(robot: Robot) -> list[Response]:
    return [received.message for received in await robot.bus.history(RESPONSES)]


async def test_an_answer_names_the_command_and_is_empty_until_the_target_is_reached(redis_url: str) -> None:
    async with adapted(redis_url) as (service, robot):
        sent: list[Command] = []

        async def told() -> bool:
            sent.append(await order(robot.bus, len(sent) + 1, final=True))
            document = await robot.command()
            return document is not None and document["command"] == "MoveTo"

        await until(told)
        document = await robot.command()
        assert document is not None
        answer = {"command": "MoveTo", "command_timestamp": document["timestamp"], "reached_timestamp": ""}
        await robot.say("response", answer)
        await until(lambda: service.intake.counts["responses"] == 1)
        reached = {**answer, "reached_timestamp": now_ms(), "x": 2.0, "y": 2.0, "angle": 0.0}
        await robot.say("response", reached)
        await until(lambda: service.intake.counts["responses"] == 2)

        async def both() -> bool:
            return len(await answers(robot)) == 2

        await until(both)
        first, second = await answers(robot)
        assert first.command_order in [made.order for made in sent]
        assert (first.outcome, first.reached_ns) == (Outcome.ACCEPTED, None)
        assert (second.outcome, second.reached_ns) == (Outcome.REACHED, reached["reached_timestamp"] * 1_000_000)
        assert first.command_order == second.command_order
        await robot.say("response", answer)
        await robot.say("response", {**reached, "reached_timestamp": document["timestamp"] - 1})
        await until(lambda: service.intake.counts["wrong_time"] == 1)
        await robot.say("response", {**answer, "command_timestamp": 5})
        await until(lambda: service.intake.counts["unknown_command"] == 1)
        await robot.say("response", {**answer, "command": "Waiting"})
        await until(lambda: service.intake.counts["unknown_command"] == 2)
        await robot.say("response", b"{}")
        await until(lambda: service.intake.counts["undecodable"] == 1)
        assert len(await answers(robot)) == 2


async def test_it_goes_on_after_redis_was_away(redis_server: RedisServer) -> None:
    async with adapted(redis_server.url) as (_, robot):

        async def driving() -> bool:
            await order(robot.bus, CLOCK.now_ns() // 1000)
            document = await robot.command()
            return document is not None and document["command"] == "MoveTo"

        await until(driving)
        redis_server.kill()
        await asyncio.sleep(0.3)
        redis_server.start()

        async def told() -> bool:
            await robot.status()
            return await driving() and await kept(robot) is not None

        await until(told)


async def test_a_latch_that_cannot_be_read_counts_as_engaged(redis_url: str) -> None:
    async with adapted(redis_url) as (_, robot):
        await robot.client.hset("lilliput:live:emergency_stop", LAB_INSTANCE, b"{broken")  # pyright: ignore[reportGeneralTypeIssues]
        await commanded(robot, "Waiting")
