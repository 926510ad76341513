"""The robots' streams of commands: first the latch, newest wins, alive without Redis, gone with the client or the server."""

import asyncio
import json
from collections.abc import AsyncGenerator

import pytest
import redis.asyncio

from protocol.channels import COMMANDS
from protocol.clock import SystemClock
from protocol.codec import encode
from protocol.messages import EmergencyStop
from server.live.command_stream import command_stream
from server.live.feeds import CommandFeeds
from tests.redis_fixture import RedisServer
from tests.server.samples import command
from tests.server.service import OTHER_ROBOT, ROBOT, in_process, served, until
from tests.server.streams import EventStream

CLOCK = SystemClock()


async def _yes() -> bool:
    return True


async def _next(stream: AsyncGenerator[bytes, None]) -> bytes:
    return await anext(stream)


async def _rest(stream: AsyncGenerator[bytes, None]) -> list[bytes]:
    return [piece async for piece in stream]


async def test_commands_reach_their_robot_only(redis_url: str) -> None:
    async with served(redis_url) as (service, _), EventStream(service, "robot", ROBOT) as stream:
        assert (await stream.event())[0] == "emergency_stop"
        bus = service.context.bus
        for sequence in (1, 2):
            sent = command(ROBOT, CLOCK.now_ns(), sequence)
            await bus.publish(COMMANDS, "wifibot-15", command("wifibot-15", CLOCK.now_ns()))
            await bus.publish(COMMANDS, ROBOT, sent)
            name, data = await stream.event()
            assert (name, data) == ("command", sent.model_dump_json())


async def test_a_stream_is_refused_for_unknown_robots(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        answer = await service.http("operator").get("/api/robots/nobody/commands")
        assert answer.status_code == 404
        assert answer.json()["detail"] == "there is no robot 'nobody' in lab 'gulliver'"


async def test_a_slow_robot_misses_old_commands_but_never_the_newest() -> None:
    feeds = CommandFeeds()
    feeds.stop(EmergencyStop(engaged=False))
    stream = command_stream(feeds, ROBOT, CLOCK, _yes)
    assert (await anext(stream)).startswith(b"event: emergency_stop\n")
    for sequence in range(1, 100):
        feeds.command(ROBOT, encode(command(ROBOT, 1, sequence)))
    newest = json.loads((await anext(stream)).split(b"data: ")[1])
    assert newest["sequence"] == 99
    feeds.command(ROBOT, encode(command(ROBOT, 1, 100)))
    feeds.stop(EmergencyStop(engaged=True, epoch=1, stamp_ns=5))
    assert (await anext(stream)).startswith(b"event: emergency_stop\n")
    assert json.loads((await anext(stream)).split(b"data: ")[1])["sequence"] == 100
    await stream.aclose()
    assert len(feeds) == 0


async def test_a_command_goes_out_as_it_came_but_on_one_line() -> None:
    feeds = CommandFeeds()
    feeds.stop(EmergencyStop(engaged=False))
    stream = command_stream(feeds, ROBOT, CLOCK, _yes)
    await anext(stream)
    plain = encode(command(ROBOT, 1))
    spaced = plain.replace(b",", b", ")
    for encoded, sent in ((plain, plain), (plain.replace(b",", b",\n"), spaced), (plain.replace(b",", b",\r"), spaced)):
        feeds.command(ROBOT, encoded)
        assert await anext(stream) == b"event: command\ndata: " + sent + b"\n\n"
    await stream.aclose()


async def test_commands_go_by_the_short_way_while_nothing_waits_before_them() -> None:
    feeds, written, clear = CommandFeeds(), list[bytes](), True

    def write(piece: bytes) -> bool:
        if clear:
            written.append(piece)
        return clear

    def tell(sequence: int) -> bytes:
        sent = encode(command(ROBOT, 1, sequence))
        feeds.command(ROBOT, sent)
        return b"event: command\ndata: " + sent + b"\n\n"

    stream = command_stream(feeds, ROBOT, CLOCK, _yes, write)
    first = tell(1)
    feeds.stop(EmergencyStop(engaged=False))
    assert (await anext(stream)).startswith(b"event: emergency_stop\n")
    assert await anext(stream) == first
    assert not written, "what was yielded may not be sent yet"
    waiting = asyncio.create_task(_next(stream))
    await asyncio.sleep(0)
    assert [tell(2), tell(3)] == written
    feeds.stop(EmergencyStop(engaged=True, epoch=1, stamp_ns=5))
    fourth = tell(4)
    assert (await waiting).startswith(b"event: emergency_stop\n"), "no command overtakes a stop"
    assert await anext(stream) == fourth
    waiting, clear = asyncio.create_task(_next(stream)), False
    await asyncio.sleep(0)
    tell(5)
    sixth = tell(6)
    assert await waiting == sixth, "the newest, by the usual way"
    assert len(written) == 2
    await stream.aclose()


@pytest.mark.alone
async def test_a_stream_of_short_ways_is_checked_and_kept_alive() -> None:
    feeds, allowed, written = CommandFeeds(), True, list[bytes]()

    class Hasty(SystemClock):
        def monotonic_s(self) -> float:
            return super().monotonic_s() * 100

    async def may_listen() -> bool:
        return allowed

    def write(piece: bytes) -> bool:
        written.append(piece)
        return True

    feeds.stop(EmergencyStop(engaged=False))
    stream = command_stream(feeds, ROBOT, Hasty(), may_listen, write)
    await anext(stream)
    waiting = asyncio.create_task(_rest(stream))
    loop = asyncio.get_running_loop()
    for number in range(1, 16):
        loop.call_later(0.05 * number, feeds.command, ROBOT, encode(command(ROBOT, 1, number)))
    allowed, began_s = False, loop.time()
    yielded = await waiting
    assert loop.time() - began_s < 0.8, "nothing but commands came, and still it was asked"
    assert len(written) > len(yielded) <= 1, "one may come while the stream wakes"


@pytest.mark.alone
async def test_something_is_said_every_half_second() -> None:
    feeds = CommandFeeds()
    feeds.stop(EmergencyStop(engaged=False))
    stream = command_stream(feeds, ROBOT, CLOCK, _yes)
    await anext(stream)
    loop = asyncio.get_running_loop()
    for wait_s in (0.2, 0.0):
        loop.call_later(wait_s, feeds.command, ROBOT, encode(command(ROBOT, 1)))
        assert (await anext(stream)).startswith(b"event: command\n")
    began_s = loop.time()
    assert await anext(stream) == b": keep-alive\n\n"
    assert 0.45 < loop.time() - began_s < 1.0
    await stream.aclose()


async def test_no_command_goes_out_before_the_latch_is_known() -> None:
    feeds = CommandFeeds()
    feeds.command(ROBOT, encode(command(ROBOT, 1)))
    stream = command_stream(feeds, ROBOT, CLOCK, _yes)
    assert await anext(stream) == b": keep-alive\n\n"
    feeds.stop(EmergencyStop(engaged=True, reason="fire"))
    assert (await anext(stream)).startswith(b"event: emergency_stop\n")
    assert (await anext(stream)).startswith(b"event: command\n")
    feeds.close()
    assert [chunk async for chunk in stream] == []


def test_an_older_release_does_not_undo_a_stop() -> None:
    feeds = CommandFeeds()
    engaged = EmergencyStop(engaged=True, epoch=3, stamp_ns=30)
    assert feeds.stop(engaged)
    for epoch in (2, 3):
        assert not feeds.stop(EmergencyStop(engaged=False, epoch=epoch, stamp_ns=40))
    assert feeds.emergency_stop == engaged


def test_a_clock_that_was_set_back_does_not_hide_a_release() -> None:
    feeds = CommandFeeds()
    feeds.stop(EmergencyStop(engaged=True, epoch=3, stamp_ns=30))
    released = EmergencyStop(engaged=False, epoch=4, stamp_ns=10)
    assert feeds.stop(released)
    assert feeds.emergency_stop == released


def test_what_engages_is_believed_once_and_epochs_never_shrink() -> None:
    feeds = CommandFeeds()
    feeds.stop(EmergencyStop(engaged=False, epoch=4, stamp_ns=40))
    damaged = EmergencyStop(engaged=True, reason="damaged")
    assert feeds.stop(damaged)
    assert feeds.epoch == 5, "as one that came after the release"
    assert not feeds.stop(damaged)
    for old in (1, 4, 5):
        assert not feeds.stop(EmergencyStop(engaged=False, epoch=old))
    assert feeds.stop(EmergencyStop(engaged=False, epoch=6))


async def test_a_stream_stays_open_without_redis_and_goes_on_with_it(redis_server: RedisServer) -> None:
    async with served(redis_server.url) as (service, _), EventStream(service, "robot", ROBOT) as stream:
        await stream.event()
        redis_server.kill()
        for _ in range(3):
            await stream.comment(within_s=1.5)
        redis_server.start()
        sent = command(ROBOT, CLOCK.now_ns())
        bus = service.context.bus

        async def delivered() -> bool:
            await bus.publish(COMMANDS, ROBOT, sent)
            return (await stream.event())[0] == "command"

        await until(delivered, within_s=10)


async def test_a_client_that_left_is_forgotten(redis_url: str) -> None:
    async with served(redis_url) as (service, _):
        feeds = service.context.hub.feeds
        async with EventStream(service, "robot", ROBOT) as stream:
            await stream.event()
            assert len(feeds) == 1
        await until(lambda: len(feeds) == 0, within_s=2)


async def test_streams_end_with_the_server(redis_url: str) -> None:
    async with served(redis_url) as (service, serving), EventStream(service, "robot", ROBOT) as stream:
        await stream.event()
        started = CLOCK.monotonic_s()
        serving.should_exit = True
        assert await stream.ended(within_s=2)
        assert CLOCK.monotonic_s() - started < 1.5


async def test_a_revoked_token_ends_the_stream() -> None:
    feeds, allowed = CommandFeeds(), True

    class Hasty(SystemClock):
        def monotonic_s(self) -> float:
            return super().monotonic_s() * 100

    async def may_listen() -> bool:
        return allowed

    stream = command_stream(feeds, ROBOT, Hasty(), may_listen)
    assert await anext(stream) == b": keep-alive\n\n"
    allowed = False
    assert [chunk async for chunk in stream] == []


async def test_registration(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        robot = service.http("robot")
        body = {"kind": "wifibot", "udp_port": 4711, "session": "s1"}
        answer = await robot.post(f"/api/robots/{ROBOT}/registration", json=body)
        assert answer.json() == {"robots_udp": service.udp_port, "pose_rate_hz": 15.0, "again_s": 5.0}
        await robot.post(f"/api/robots/{ROBOT}/registration", json=body)
        await robot.post(f"/api/robots/{ROBOT}/registration", json={**body, "session": "s2"})
        registered = await _registration(redis_url)
        assert (registered["host"], registered["udp_port"], registered["session"]) == ("127.0.0.1", 4711, "s2")
        kinds = [event["kind"] for event in (await service.http("viewer").get("/api/events")).json()]
        assert kinds.count("robot_registered") == 2
        for bad in ({"udp_port": 0}, {"udp_port": 70000}, {}, {"udp_port": 1, "host": "evil"}):
            assert (await robot.post(f"/api/robots/{ROBOT}/registration", json=bad)).status_code == 422


async def _registration(url: str) -> dict[str, object]:
    async with redis.asyncio.Redis.from_url(url) as client:
        return json.loads(await client.hget("lilliput:live:registrations", ROBOT))  # type: ignore[misc,arg-type]


async def test_responses_are_kept_and_must_be_the_robots_own(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        robot = service.http("robot")
        response = {
            "robot": ROBOT,
            "command_order": [1, 7],
            "command_stamp_ns": 1,
            "stamp_ns": 2,
            "outcome": "reached",
            "movement": "MoveTo",
            "reached_ns": 2,
        }
        assert (await robot.post(f"/api/robots/{ROBOT}/responses", json=response)).status_code == 204
        wrong = await robot.post(f"/api/robots/{ROBOT}/responses", json={**response, "robot": "wifibot-15"})
        assert wrong.status_code == 422
        other = {**response, "robot": OTHER_ROBOT}
        for _ in range(2):
            assert (
                await service.http("other-robot").post(f"/api/robots/{OTHER_ROBOT}/responses", json=other)
            ).is_success
        for sequence in (8, 9):
            later = {**response, "command_order": [1, sequence]}
            assert (await robot.post(f"/api/robots/{ROBOT}/responses", json=later)).is_success
        viewer = service.http("viewer")
        for count, orders in ((1000, [[1, 7], [1, 8], [1, 9]]), (2, [[1, 8], [1, 9]])):
            read = (await viewer.get(f"/api/robots/{ROBOT}/responses?count={count}")).json()
            assert [(each["robot"], each["command_order"]) for each in read] == [(ROBOT, order) for order in orders]
        assert (await viewer.get("/api/robots/turtlebot-16/responses")).json() == []
        assert (await viewer.get("/api/robots/nobody/responses")).status_code == 404


async def test_the_stream_needs_no_patience_of_the_client(redis_url: str) -> None:
    """Connecting and leaving many times leaves nothing behind."""
    async with served(redis_url) as (service, _):
        for _ in range(3):
            streams = [EventStream(service, "robot", ROBOT) for _ in range(10)]
            await asyncio.gather(*(stream.__aenter__() for stream in streams))
            await asyncio.gather(*(stream.__aexit__(None, None, None) for stream in streams))
        await until(lambda: len(service.context.hub.feeds) == 0)
        assert (await service.http().get("/api/health")).status_code == 200
