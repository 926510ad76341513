"""The emergency stop: latched, first reason kept, released by a person only, durable, told at once without guidance."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
import redis

from agents.safety import EmergencyStopLatch
from protocol import keys
from protocol.channels import EMERGENCY_STOP, LAB_INSTANCE, STATUSES
from protocol.clock import SystemClock
from protocol.messages import EmergencyStop, Status
from server.live.feeds import CommandFeeds
from server.live.latch import EmergencyStopLatch as FleetLatch
from server.repositories.documents import Store
from server.repositories.emergency_stop import EmergencyStopRepository
from tests.redis_fixture import RedisServer
from tests.server.service import PASSWORD, ROBOT, in_process, served, until
from tests.server.streams import EventStream


async def test_it_keeps_its_first_reason_and_a_person_releases_it(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        operator, robot = service.http("operator"), service.http("robot")
        assert (await operator.get("/api/estop")).json()["engaged"] is False
        first = (await robot.post("/api/estop", json={"reason": "bumper"})).json()
        assert (first["engaged"], first["reason"], first["by"]) == (True, "bumper", "robot token")
        assert first["epoch"] >= first["stamp_ns"] // 1_000_000
        assert (await operator.post("/api/estop", json={"reason": "other"})).json() == first
        assert (await robot.get("/api/estop")).json() == first
        for body in ({}, {"confirm": False}, None):
            assert (await operator.request("DELETE", "/api/estop", json=body)).status_code == 422
        assert (await robot.request("DELETE", "/api/estop", json={"confirm": True})).status_code == 403
        assert (await operator.get("/api/estop")).json() == first
        released = (await operator.request("DELETE", "/api/estop", json={"confirm": True})).json()
        assert released["engaged"] is False
        assert released["epoch"] > first["epoch"]
        kinds = [event["kind"] for event in (await operator.get("/api/events")).json()]
        assert kinds.count("emergency_stop") == 1
        assert kinds[-1] == "emergency_stop_released"


async def test_nothing_starts_while_it_is_engaged(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        operator = service.http("operator")
        await operator.post("/api/waypoints", json={"id": "a", "area": "camp", "x": 1, "y": 1})
        await operator.post("/api/routes", json={"id": "r", "legs": [{"waypoint": "a"}]})
        await operator.post("/api/estop", json={})
        start = await operator.put(f"/api/robots/{ROBOT}/assignment", json={"route": "r"})
        drive = await operator.put(f"/api/robots/{ROBOT}/manual", json={"linear_mps": 0.1, "angular_radps": 0})
        for answer in (start, drive):
            assert answer.status_code == 409
            assert "emergency stop is engaged" in answer.json()["detail"]
        await operator.request("DELETE", "/api/estop", json={"confirm": True})
        assert (await operator.put(f"/api/robots/{ROBOT}/assignment", json={"route": "r"})).status_code == 200


async def test_it_survives_the_death_of_server_and_redis(redis_server: RedisServer) -> None:
    async with in_process(redis_server.url) as service:
        engaged = (await service.http("operator").post("/api/estop", json={"reason": "fire"})).json()
    redis_server.kill()
    redis_server.start()
    async with served(redis_server.url, accounts=True) as (service, _):
        assert (await service.http("operator").get("/api/estop")).json() == engaged
        async with EventStream(service, "robot", ROBOT) as stream:
            name, data = await stream.event()
            assert (name, json.loads(data)) == ("emergency_stop", engaged)


@pytest.mark.alone
async def test_robots_hear_it_at_once_without_guidance(redis_url: str) -> None:
    async with served(redis_url) as (service, _), EventStream(service, "robot", ROBOT) as stream:
        name, data = await stream.event()
        assert (name, json.loads(data)["engaged"]) == ("emergency_stop", False)
        loop = asyncio.get_running_loop()
        started = loop.time()
        await service.http("operator").post("/api/estop", json={"reason": "now"})
        name, data = await stream.event()
        assert (name, json.loads(data)["reason"]) == ("emergency_stop", "now")
        assert loop.time() - started < 0.3


async def test_a_damaged_latch_counts_as_engaged_and_can_be_released(redis_server: RedisServer) -> None:
    with redis.Redis.from_url(redis_server.url) as client:
        client.hset(keys.live("emergency_stop"), "lab", b"\xff not json")
    async with in_process(redis_server.url) as service:
        operator = service.http("operator")
        assert (await operator.get("/api/estop")).json()["engaged"] is True

        async def shown() -> bool:
            robots: list[dict[str, Any]] = (await service.http("viewer").get("/api/robots")).json()
            return len(robots) == 4

        await until(shown)
        await until(lambda: service.context.hub.feeds.emergency_stop is not None)
        stop = service.context.hub.feeds.emergency_stop
        assert stop is not None
        assert stop.engaged
        released = await operator.request("DELETE", "/api/estop", json={"confirm": True})
        assert released.json()["engaged"] is False
        assert (await operator.get("/api/estop")).json()["engaged"] is False


class _SetBack(SystemClock):
    behind_ns = 0

    def now_ns(self) -> int:
        return super().now_ns() - self.behind_ns


async def test_robots_take_the_release_of_a_latch_whose_record_was_damaged_or_lost(redis_url: str) -> None:
    """The clock has been set back too, so that only what is remembered makes the epochs grow."""
    clock = _SetBack()
    async with in_process(redis_url, clock) as service:
        operator, robot = service.http("operator"), EmergencyStopLatch()
        feeds, client = service.context.hub.feeds, service.context.bus.redis

        async def press(*, release: bool) -> None:
            if release:
                answer = await operator.request("DELETE", "/api/estop", json={"confirm": True})
            else:
                answer = await operator.post("/api/estop", json={"reason": "drill"})
            assert answer.status_code == 200
            stop = EmergencyStop.model_validate(answer.json())
            feeds.stop(stop)
            assert robot.update(stop)
            assert robot.engaged is not release

        for harm in (b"\xff not json", None):
            await press(release=False)
            clock.behind_ns += 3600 * 10**9
            if harm is None:
                await client.hdel(keys.live("emergency_stop"), "lab")  # type: ignore[misc]
            else:
                await client.hset(keys.live("emergency_stop"), "lab", harm)  # type: ignore[misc,arg-type]
            await press(release=True)


async def test_another_server_with_nothing_but_the_clock_takes_greater_epochs(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        engaged = (await service.http("operator").post("/api/estop", json={})).json()
        await service.context.bus.redis.hset(keys.live("emergency_stop"), "lab", b"gone")  # type: ignore[misc,arg-type]
    async with in_process(redis_url) as service:
        released = await service.http("operator").request("DELETE", "/api/estop", json={"confirm": True})
        assert released.json()["epoch"] > engaged["epoch"]


@pytest.mark.parametrize("harm", ["killed", "frozen"])
async def test_pressed_without_redis_it_reaches_robots_at_once_and_redis_later(
    redis_server: RedisServer, harm: str
) -> None:
    async with served(redis_server.url) as (service, _), EventStream(service, "robot", ROBOT) as stream:
        session, viewer, robot = service.http(), service.http("viewer"), EmergencyStopLatch()
        await session.post("/api/session", json={"user": "operator", "password": PASSWORD})
        session.headers["X-Lilliput"] = "1"
        for client in (session, viewer):
            assert (await client.get("/api/estop")).json()["engaged"] is False
        assert robot.update(EmergencyStop.model_validate_json((await stream.event())[1]))
        redis_server.kill() if harm == "killed" else redis_server.pause()
        loop = asyncio.get_running_loop()
        began = loop.time()
        pressing = asyncio.ensure_future(session.post("/api/estop", json={"reason": "smoke"}))
        heard = EmergencyStop.model_validate_json((await stream.event(within_s=5))[1])
        assert loop.time() - began < 1.5
        assert (heard.engaged, heard.reason, heard.by) == (True, "smoke", "operator")
        assert robot.update(heard)
        answer = await pressing
        assert answer.status_code == 503
        for word in ("1 open streams", "told to stop", "written as soon as Redis is back", "do not restart it"):
            assert word in answer.json()["detail"]
        assert (await viewer.post("/api/estop", json={})).status_code == 403
        stranger = service.http()
        assert (await stranger.post("/api/estop", json={})).status_code == 401
        assert (await stranger.post("/api/estop", json={}, headers={"Authorization": "Bearer x"})).status_code == 503
        redis_server.start() if harm == "killed" else redis_server.resume()

        async def written() -> bool:
            raw = await service.context.bus.redis.hget(keys.live("emergency_stop"), "lab")  # type: ignore[misc]
            return raw is not None and json.loads(raw)["reason"] == "smoke"

        await until(lambda: _without_redis_errors(written))
        events = (await session.get("/api/events")).json()
        assert [event["kind"] for event in events].count("emergency_stop") == 1
        released = await session.request("DELETE", "/api/estop", json={"confirm": True})
        assert released.status_code == 200, released.text
        assert robot.update(EmergencyStop.model_validate(released.json()))
        assert not robot.engaged


async def test_a_stop_that_redis_lost_is_given_back_to_it(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        operator, client = service.http("operator"), service.context.bus.redis
        engaged = (await operator.post("/api/estop", json={"reason": "fire"})).json()
        await until(lambda: service.context.hub.feeds.epoch == engaged["epoch"])
        await client.hdel(keys.live("emergency_stop"), "lab")  # type: ignore[misc]

        async def back() -> bool:
            raw = await client.hget(keys.live("emergency_stop"), "lab")  # type: ignore[misc]
            return raw is not None and json.loads(raw) == engaged

        await until(back)


class _SlowAnswers(EmergencyStopRepository):
    """Answers of Redis are held back while `open` is not set; `waiting` says that one is."""

    def __init__(self, store: Store) -> None:
        super().__init__(store, SystemClock())
        self.open, self.waiting = asyncio.Event(), asyncio.Event()
        self.open.set()

    async def get(self) -> EmergencyStop:
        stop = await super().get()
        await self._pass()
        return stop

    async def engage(self, stop: EmergencyStop) -> EmergencyStop:
        await self._pass()
        return await super().engage(stop)

    async def _pass(self) -> None:
        self.waiting.set()
        await self.open.wait()

    def hold_back(self) -> None:
        self.open.clear()
        self.waiting.clear()


async def test_an_answer_from_before_the_release_engages_nothing_again(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        repository, feeds = _SlowAnswers(Store(service.context.bus.redis)), CommandFeeds()
        latch = FleetLatch(repository, feeds, SystemClock())
        engaged = await latch.engage("drill", "operator")
        repository.hold_back()
        looking = asyncio.ensure_future(latch.look())
        await repository.waiting.wait()
        released = await latch.release("operator")
        assert feeds.announced(released)
        repository.open.set()
        assert not await looking
        assert not feeds.announced(engaged), "it comes late"
        assert feeds.emergency_stop == released
        assert not await latch.look()


async def test_a_release_is_of_the_stop_that_is_still_being_written(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        repository, feeds = _SlowAnswers(Store(service.context.bus.redis)), CommandFeeds()
        latch = FleetLatch(repository, feeds, SystemClock())
        repository.hold_back()
        pressing = asyncio.ensure_future(latch.engage("drill", "operator"))
        await repository.waiting.wait()
        releasing = asyncio.ensure_future(latch.release("operator"))
        await asyncio.sleep(0)
        repository.open.set()
        engaged, released = await pressing, await releasing
        assert released.epoch > engaged.epoch
        assert await latch.look()
        assert await latch.get() == feeds.emergency_stop == released


async def test_a_stop_that_only_robots_know_of_can_be_released(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        feeds, robot = CommandFeeds(), EmergencyStopLatch()
        latch = FleetLatch(
            EmergencyStopRepository(Store(service.context.bus.redis), SystemClock()), feeds, SystemClock()
        )
        await latch.engage("drill", "operator")
        released = await latch.release("operator")
        only_here = EmergencyStop(engaged=True, epoch=released.epoch, stamp_ns=released.stamp_ns)
        assert feeds.stop(only_here) and robot.update(only_here)
        again = await latch.release("operator")
        assert feeds.announced(again) and robot.update(again)
        assert not robot.engaged


async def _without_redis_errors(condition: Callable[[], Awaitable[bool]]) -> bool:
    try:
        return await condition()
    except redis.RedisError:
        return False


@pytest.mark.parametrize("off_ms", [20_000, -20_000])
async def test_a_stop_that_robots_heard_by_broadcast_becomes_everybodys_and_can_be_released(
    redis_url: str, off_ms: int
) -> None:
    """A sender whose clock is ahead gave it a greater epoch than this server's clock would, one whose clock is behind a
    smaller one than the last release has."""
    async with in_process(redis_url) as service:
        operator, robot, clock = service.http("operator"), EmergencyStopLatch(), SystemClock()
        context = service.context
        await until(lambda: context.hub.feeds.emergency_stop is not None)
        await operator.post("/api/estop", json={"reason": "drill"})
        before = EmergencyStop.model_validate(
            (await operator.request("DELETE", "/api/estop", json={"confirm": True})).json()
        )
        await until(lambda: context.hub.feeds.emergency_stop == before)
        robot.update(before)
        robot.update(EmergencyStop(engaged=True, epoch=clock.now_ns() // 1_000_000 + off_ms))
        epoch = robot.epoch

        async def report() -> None:
            status = Status(
                robot=ROBOT,
                sequence=clock.now_ns() // 1000,
                stamp_ns=clock.now_ns(),
                linear_mps=0.0,
                angular_radps=0.0,
                stop_epoch=robot.epoch if robot.engaged else None,
            )
            await context.bus.publish(STATUSES, ROBOT, status)

        async def engaged() -> bool:
            await report()
            return bool((await operator.get("/api/estop")).json()["engaged"])

        await until(engaged)
        known = (await operator.get("/api/estop")).json()
        assert (known["by"], known["epoch"]) == ("broadcast", epoch)
        assert ROBOT in known["reason"]
        released = EmergencyStop.model_validate(
            (await operator.request("DELETE", "/api/estop", json={"confirm": True})).json()
        )
        assert released.epoch > epoch
        await report()  # sent before the robot heard of the release
        await asyncio.sleep(0)
        assert robot.update(released), "the robot takes it"
        await report()
        assert (await operator.get("/api/estop")).json()["engaged"] is False
        last = await context.bus.latest(EMERGENCY_STOP, LAB_INSTANCE)
        assert last is not None and not last.engaged


async def test_nonsense_of_a_robot_is_no_epoch(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        context = service.context
        await until(lambda: context.hub.feeds.emergency_stop is not None)
        context.hub.latch.held(ROBOT, 8 * 10**18)
        assert context.hub.feeds.epoch < 8 * 10**18
        assert (await service.http("operator").get("/api/estop")).json()["engaged"] is False
