"""A thousand mutated messages in Redis, on every channel and every key that processes read: nobody ends, nobody answers 5xx, and
what does not decode changes nothing.

The server, the intake, guidance, the GPSS adapter, the tracker and the mapper run on one Redis, as they do in a lab. Other
processes read through the same bus and codecs.
"""

import asyncio
import contextlib
import random
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import redis.asyncio

from localization.outputs import UdpSender, outputs_of
from localization.timings import TRACKER_STAGES, open_timing_log
from localization.tracker import TrackerService
from mapping.mapper import Mapper
from protocol import keys
from protocol.bus import Bus
from protocol.channels import CHANNELS, COMMANDS, EMERGENCY_STOP, LAB_INSTANCE, Channel, Delivery
from protocol.clock import SystemClock
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.gpss import WRITTEN, key
from protocol.lab import Lab
from protocol.messages import (
    Assignment,
    AssignmentState,
    Command,
    EmergencyStop,
    Event,
    EventLevel,
    GroundTruth,
    GuidanceState,
    IntakeState,
    Leg,
    ManualDrive,
    ProcessState,
    Reason,
    ReasonCode,
    Registration,
    RobotSettings,
    Route,
    SimulatedObject,
    SpeedZone,
    Waypoint,
)
from protocol.settings import Settings
from server.gpss.service import GpssService
from server.guidance.parameters import GuidanceParameters
from server.guidance.service import GuidanceService
from server.intake.service import IntakeService
from server.repositories.redis_users import RedisUserRecord
from tests.mutations import mutated
from tests.server.samples import camera_state, command, extrinsics, pose, raster, status
from tests.server.service import ROBOT, Service, gulliver, in_process, until

COUNT = 1000
CLOCK = SystemClock()
GPSS_ROBOT = "wifibot-15"
PATHS = (
    *("/lab", "/health", "/robots", f"/robots/{ROBOT}", "/waypoints", "/routes", "/estop", "/cameras", "/sim/objects"),
    *("/speed-zones", "/events", "/calibration", f"/robots/{ROBOT}/responses", "/users", "/tokens"),
)
COUNTED = (
    *(
        "received",
        "accepted",
        "undecodable",
        "wrong_kind",
        "unknown_robot",
        "wrong_sender",
        "old",
        "future",
        "duplicate",
    ),
    "out_of_order",
)
NAMES = (ROBOT.encode(), GPSS_ROBOT.encode(), b"nobody", b"", b"\xff\xfe", b"a:b:c", b"x" * 500)
"""Instances and ids, right and wrong ones."""


def fleet() -> Lab:
    """The room of the reports, one of whose robots speaks GPSS."""
    lab = gulliver()
    vehicles = tuple(
        vehicle.model_copy(update={"driver": "gpss-redis"}) if vehicle.id == GPSS_ROBOT else vehicle
        for vehicle in lab.vehicles
    )
    return lab.model_copy(update={"vehicles": vehicles})


def samples() -> dict[str, bytes]:
    """A good message of every channel that has a simple one, and a good document of every durable hash."""
    now = CLOCK.now_ns()
    manual = ManualDrive(robot=ROBOT, linear_mps=0.1, angular_radps=0.0, holder="x", expires_ns=now)
    waypoint, route = Waypoint(id="a", area="camp", x=1.0, y=1.0), Route(id="r", legs=(Leg(waypoint="a"),))
    assignment = Assignment(id="1", robot=ROBOT, route="r", state=AssignmentState.DONE, started_ns=now, changed_ns=now)
    reason = Reason(code=ReasonCode.IDLE)
    found: dict[str, Any] = {
        "poses": pose(ROBOT, now),
        "statuses": status(ROBOT, now),
        "commands": command(ROBOT, now),
        "guidance": GuidanceState(robot=ROBOT, stamp_ns=now, reason=reason),
        "registrations": Registration(robot=ROBOT, host="127.0.0.1", udp_port=9, stamp_ns=now),
        "manual": manual,
        "camera_states": camera_state("cam0", now),
        "rasters": raster(now),
        "obstacles": raster(now),
        "ground_truth": GroundTruth(now, {}, 0),
        "processes": ProcessState(name="lab", state="running", pid=1, restarts=0, since_ns=now, stamp_ns=now),
        "intake": IntakeState(stamp_ns=now, last_problem=None, losses={ROBOT: 0.1}, **dict.fromkeys(COUNTED, 1)),
        "emergency_stop": EmergencyStop(engaged=True, epoch=now // 1_000_000, stamp_ns=now, by="x", reason="y"),
        "events": Event(stamp_ns=now, level=EventLevel.INFO, source="x", kind="y", text="z"),
        keys.WAYPOINTS: waypoint,
        keys.ROUTES: route,
        keys.ASSIGNMENTS: assignment,
        keys.ROBOT_SETTINGS: RobotSettings(box_length_m=1.0),
        keys.EXTRINSICS: extrinsics("cam0"),
        keys.SIMULATED_OBJECTS: SimulatedObject(id="p", kind="pallet", x=1.0, y=1.0),
        keys.SPEED_ZONES: SpeedZone(id="z", outline=((5.0, 1.0), (6.0, 1.0), (6.0, 2.0)), speed_mps=0.2),
        keys.REDIS_USERS: RedisUserRecord(robot=ROBOT, password_sha256="0" * 64, created_ns=now, created_by="x"),
    }
    return {name: encode(message) for name, message in found.items()}


@dataclass
class Running:
    """The processes, on one event loop; `alive` says whether all of them still are."""

    service: Service
    bus: Bus
    tasks: dict[str, asyncio.Task[Any]]

    @property
    def redis(self) -> redis.asyncio.Redis:
        return self.bus.redis

    def dead(self) -> list[str]:
        return [f"{name}: {task.exception()!r}" for name, task in self.tasks.items() if task.done()]


@asynccontextmanager
async def running(redis_url: str, tmp_path: Any) -> AsyncGenerator[Running]:
    lab, bus = fleet(), Bus.connect(redis_url, CLOCK)
    settings = Settings(tmp_path, tmp_path, redis_url, "", "127.0.0.1", None, "", timings_mb=0.0)
    with (
        UdpSender(CLOCK) as sender,
        open_timing_log(settings, CLOCK, lab.name, "tracker", TRACKER_STAGES, noted={}) as timings,
    ):
        async with in_process(redis_url, lab=lab) as service:
            outputs = outputs_of(lab, bus, sender, CLOCK, None)
            tracker = TrackerService(lab, bus, outputs, timings, CLOCK)
            gpss = GpssService(lab, bus, CLOCK)
            taking = IntakeService(lab, bus, CLOCK, None)
            parts = {
                "guidance": GuidanceService(lab, bus.redis, CLOCK, GuidanceParameters()).run(),
                "tracker": tracker.run(),
                "mapper": Mapper(lab, bus, CLOCK).run(),
                **{f"gpss {number}": part for number, part in enumerate(gpss.parts())},
                "intake, registrations": taking.follow_registrations(),
                "intake": taking.report(),
            }
            tasks = {name: asyncio.ensure_future(part) for name, part in parts.items()}
            try:
                yield Running(service, bus, tasks)
            finally:
                while waiting := [task for task in tasks.values() if not task.done()]:
                    for task in waiting:
                        task.cancel()
                    await asyncio.wait(waiting, timeout=0.1)
                await bus.close()


def undecodable(channel: Channel[Any], data: bytes) -> bool:
    try:
        decode(channel.message, data)
    except DecodeError:
        return True
    return False


async def commanded(system: Running) -> Command:
    """A command that guidance says from now on to the robot."""
    begun_ns, found = CLOCK.now_ns(), list[Command]()

    async def said() -> bool:
        with contextlib.suppress(DecodeError):  # overwritten by the test: guidance soon says another
            now = await system.bus.latest(COMMANDS, ROBOT)
            if now is not None and now.stamp_ns > begun_ns and now.deadline_ns - now.stamp_ns == 500_000_000:
                found.append(now)
        return bool(found)

    await until(said)
    return found[-1]


async def everything(system: Running) -> dict[str, Any]:
    """What the API shows that does not change by itself."""
    client, shown = system.service.http("admin"), dict[str, Any]()
    for path in ("/waypoints", "/routes", "/speed-zones", "/estop", "/sim/objects", "/users", "/lab"):
        shown[path] = (await client.get(f"/api{path}")).raise_for_status().json()
    robot = (await client.get(f"/api/robots/{ROBOT}")).raise_for_status().json()
    shown["robot"] = {name: robot[name] for name in ("assignment", "settings", "obstacle_box", "state", "reason")}
    order = await commanded(system)
    shown["command"] = order.movement, order.target, order.reason
    return shown


async def test_what_does_not_decode_changes_nothing(redis_url: str, tmp_path: Any) -> None:
    """Published on topics, added to streams, put beside good documents under other names."""
    rng, good = random.Random(11), samples()
    async with running(redis_url, tmp_path) as system:
        await _prepare(system, good)
        before = await everything(system)
        sent = 0
        while sent < COUNT:
            channel, name = rng.choice(CHANNELS), rng.choice(NAMES)
            data = mutated(good.get(channel.name, good["poses"]), rng)
            if not undecodable(channel, data):
                continue
            sent += 1
            if channel.delivery is Delivery.EVERY:
                fields = rng.choice(({b"i": name, b"m": data}, {b"m": data}, {b"i": name}, {b"?": b"?"}))
                await system.redis.xadd(keys.stream(channel.name), fields)  # pyright: ignore[reportArgumentType]
            else:
                topic = keys.topic(channel.name, "").encode() + name
                await system.redis.publish(topic, data)  # pyright: ignore[reportArgumentType]
            durable = rng.choice(
                (
                    *(keys.WAYPOINTS, keys.ROUTES, keys.ASSIGNMENTS, keys.SIMULATED_OBJECTS, keys.EXTRINSICS),
                    *(keys.SPEED_ZONES, keys.REDIS_USERS),
                )
            )
            other = rng.choice((b"fuzz", b"\xff\xfe", b"", b"x" * 500))
            await system.redis.hset(durable, other, mutated(good[durable], rng)[:-1])  # pyright: ignore[reportGeneralTypeIssues, reportArgumentType]
            if sent % 50 == 0:
                assert system.dead() == []
        assert await everything(system) == before
        assert system.dead() == []
        await _answers(system)


async def test_whatever_stands_in_redis_nobody_ends_and_all_is_well_when_it_is_right_again(
    redis_url: str, tmp_path: Any
) -> None:
    """Written over good messages, whether they decode or not: numbers without sense, documents that contradict one another."""
    rng, good = random.Random(12), samples()
    live = [channel for channel in CHANNELS if channel.delivery is Delivery.LATEST and channel.name in good]
    durable = [name for name in good if name.startswith(keys.PREFIX)]
    async with running(redis_url, tmp_path) as system:
        await _prepare(system, good)
        before = await everything(system)
        for number in range(COUNT):
            if rng.random() < 0.6:
                channel = rng.choice(live)
                data, name = mutated(good[channel.name], rng), rng.choice(NAMES)
                heard = ROBOT
                if channel is EMERGENCY_STOP:
                    name, heard = LAB_INSTANCE.encode(), LAB_INSTANCE
                await system.redis.hset(keys.live(channel.name), name, data)  # pyright: ignore[reportGeneralTypeIssues, reportArgumentType]
                await system.redis.publish(keys.topic(channel.name, heard), data)
            elif rng.random() < 0.5:
                hash_key = rng.choice(durable)
                await system.redis.hset(hash_key, _id(hash_key), mutated(good[hash_key], rng))  # pyright: ignore[reportGeneralTypeIssues, reportArgumentType]
                await system.redis.publish("lilliput:changed", hash_key)
            else:
                said = rng.choice(WRITTEN)
                text = mutated(b'{"x": 1.0, "y": 2.0, "angle": 0.5, "command": "MoveTo", "timestamp": 1}', rng)
                await system.redis.set(key(GPSS_ROBOT, said), text)
                await system.redis.publish(key(GPSS_ROBOT, said), text)
            if number % 100 == 99:
                await commanded(system)
                assert system.dead() == []
                await _answers(system)
        await system.redis.delete(*(keys.live(channel.name) for channel in live), *durable)
        await _prepare(system, good)
        released = await system.service.http("admin").request("DELETE", "/api/estop", json={"confirm": True})
        assert released.status_code == 200, released.text

        seen: dict[str, Any] = {}

        async def well() -> bool:
            seen.update(await everything(system))
            # Of the robot it was really heard something meanwhile, however little sense it made.
            seen["robot"] |= {name: before["robot"][name] for name in ("state", "reason")}
            movement, target, reason = seen["command"]
            seen["command"] = movement, target, reason.model_copy(update={"since_ns": before["command"][2].since_ns})
            seen["/estop"] = {**before["/estop"], "engaged": seen["/estop"]["engaged"]}
            return seen == before

        try:
            await until(well)
        except AssertionError:
            assert seen == before
        assert system.dead() == []


def _id(hash_key: str) -> str:
    return {
        keys.WAYPOINTS: "a",
        keys.ROUTES: "r",
        keys.SIMULATED_OBJECTS: "p",
        keys.EXTRINSICS: "cam0",
        keys.SPEED_ZONES: "z",
    }.get(hash_key, ROBOT)


async def _prepare(system: Running, good: dict[str, bytes]) -> None:
    for name, data in good.items():
        if name.startswith(keys.PREFIX):
            await system.redis.hset(name, _id(name), data)  # pyright: ignore[reportGeneralTypeIssues, reportArgumentType]
            await system.redis.publish("lilliput:changed", name)


async def _answers(system: Running) -> None:
    """No 5xx, but for the record that is damaged, which is named."""
    client = system.service.http("admin")
    for path in PATHS:
        answer = await client.get(f"/api{path}")
        damaged = answer.status_code == 503 and "damaged" in answer.json()["detail"]
        assert answer.status_code < 500 or damaged, f"{path}: {answer.status_code} {answer.text}"
