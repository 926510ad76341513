"""Robots' STATUS datagrams: accepted, or counted and without effect."""

import asyncio
import itertools
import json
import random
import socket
from collections.abc import Iterator
from typing import Any

import pytest
import redis

from protocol.bus import Bus
from protocol.channels import STATUSES
from protocol.clock import SystemClock
from protocol.datagram import Datagram, Sequencer, pack
from protocol.messages import IntakeState, Status
from server.intake.listener import StatusListener
from tests.mutations import mutated
from tests.redis_fixture import RedisServer
from tests.server.samples import pose, status
from tests.server.service import ROBOT, Service, gulliver, served, until

CLOCK = SystemClock()
KEY = b"0123456789abcdef"
_SOCKETS: list[socket.socket] = []


@pytest.fixture(autouse=True)
def _closed_sockets() -> Iterator[None]:  # pyright: ignore[reportUnusedFunction]  # pytest uses it
    yield
    while _SOCKETS:
        _SOCKETS.pop().close()


class Robot:
    """Sends datagrams as a robot does."""

    def __init__(self, service: Service, name: str = ROBOT, key: bytes | None = None) -> None:
        self._service, self._name, self._key = service, name, key
        self._sequencer = Sequencer(CLOCK.now_ns())
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        _SOCKETS.append(self._socket)

    def send(self, message: Any = None, *, sequence: int | None = None, age_s: float = 0.0) -> bytes:
        now_ns = CLOCK.now_ns()
        number = self._sequencer.next() if sequence is None else sequence
        stamp_ns = now_ns - round(age_s * 1e9)
        data = pack(Datagram(self._name, number, stamp_ns, message or status(self._name, now_ns)), self._key)
        self.send_bytes(data)
        return data

    def send_bytes(self, data: bytes) -> None:
        self._socket.sendto(data, ("127.0.0.1", self._service.udp_port))


def _taken(service: Service) -> IntakeState:
    assert service.intake is not None
    return service.intake.state()


async def _counted(service: Service, name: str, number: int = 1) -> None:
    async def holds() -> bool:
        return getattr(_taken(service), name) == number

    await until(holds)


async def _kept(service: Service) -> dict[str, Status]:
    return await service.context.bus.latest_all(STATUSES)


async def test_the_newest_status_is_kept_and_shown(redis_url: str) -> None:
    async with served(redis_url) as (service, _):
        robot = Robot(service)
        for speed in (0.1, 0.2, 0.3):
            robot.send(status(ROBOT, CLOCK.now_ns(), x=1.0, y=2.0, yaw=0.0, battery=speed))

        async def newest() -> bool:
            kept = (await _kept(service)).get(ROBOT)
            return kept is not None and kept.battery == 0.3

        await until(newest)
        shown = (await service.http("viewer").get(f"/api/robots/{ROBOT}")).json()
        assert (shown["connection"], shown["status"]["battery"]) == ("ONLINE", 0.3)

        async def reported() -> bool:
            udp = (await service.http("viewer").get("/api/health")).json()["udp"]
            return (udp["listening"], udp["received"], udp["accepted"]) == (True, 3, 3)

        await until(reported)


async def test_bad_datagrams_are_counted_and_have_no_effect(redis_url: str) -> None:
    async with served(redis_url) as (service, _):
        robot, stranger, liar = Robot(service), Robot(service, "nobody"), Robot(service)
        robot.send_bytes(b"")
        robot.send_bytes(b"LP")
        robot.send_bytes(b"x" * 1400)
        good = pack(Datagram(ROBOT, 1, CLOCK.now_ns(), status(ROBOT, CLOCK.now_ns())))
        robot.send_bytes(good[:-3])
        robot.send_bytes(good.replace(b'"linear_mps":0.1', b'"linear_mps":NaN'))
        await _counted(service, "undecodable", 5)
        robot.send(pose(ROBOT, CLOCK.now_ns()))
        await _counted(service, "wrong_kind")
        stranger.send()
        await _counted(service, "unknown_robot")
        liar.send(status("wifibot-15", CLOCK.now_ns()))
        await _counted(service, "wrong_sender")
        robot.send(age_s=1.5)
        await _counted(service, "old")
        robot.send(age_s=-1.5)
        await _counted(service, "future")
        assert await _kept(service) == {}
        data = robot.send(sequence=1 << 50)
        await _counted(service, "accepted")
        robot.send_bytes(data)
        await _counted(service, "duplicate")
        robot.send(sequence=(1 << 50) - 1)
        await _counted(service, "out_of_order")
        assert _taken(service).received == 13


async def test_strangers_are_told_once_a_minute(redis_server: RedisServer) -> None:
    async with served(redis_server.url) as (service, _):
        stranger = Robot(service, "nobody")
        for _ in range(50):
            stranger.send()
        await _counted(service, "unknown_robot", 50)

        def told() -> list[dict[str, Any]]:
            with redis.Redis.from_url(redis_server.url) as client:
                entries: Any = client.xrange("lilliput:stream:events")
            events = [json.loads(fields[b"m"]) for _, fields in entries]
            return [event for event in events if event["kind"] == "datagram_unknown_robot"]

        await until(lambda: bool(told()))
        await asyncio.sleep(0.2)
        (event,) = told()
        assert "unknown robot 'nobody'" in event["text"]
        problem = _taken(service).last_problem
        assert problem is not None
        assert "nobody" in problem


async def test_forged_datagrams_are_refused_where_a_key_is_set(redis_url: str) -> None:
    async with served(redis_url, udp_key=KEY) as (service, _):
        unsigned, forger, robot = Robot(service), Robot(service, key=b"another key"), Robot(service, key=KEY)
        unsigned.send()
        await _counted(service, "undecodable", 1)
        forger.send()
        await _counted(service, "undecodable", 2)
        data = robot.send()
        await _counted(service, "accepted", 1)
        robot.send_bytes(data[:-40] + b"\0" + data[-39:])
        await _counted(service, "undecodable", 3)


async def test_a_robot_whose_clock_was_set_back_starts_over_when_it_registers(redis_url: str) -> None:
    async with served(redis_url) as (service, _):
        robot = Robot(service)
        robot.send(sequence=1 << 50)
        await _counted(service, "accepted", 1)
        robot.send(sequence=5)
        await _counted(service, "out_of_order", 1)
        body = {"udp_port": 4000, "session": "new"}
        await service.http("robot").post(f"/api/robots/{ROBOT}/registration", json=body)
        numbers = itertools.count(6)

        async def accepted() -> bool:  # as soon as the intake has heard of the registration
            robot.send(sequence=next(numbers))
            return _taken(service).accepted == 2

        await until(accepted)


async def test_it_goes_on_after_redis_was_away(redis_server: RedisServer) -> None:
    async with served(redis_server.url) as (service, _):
        robot = Robot(service)
        redis_server.kill()
        robot.send()
        await _counted(service, "accepted", 1)
        redis_server.start()

        async def kept() -> bool:
            robot.send()
            return ROBOT in await _kept(service)

        await until(kept)


async def test_a_burst_of_datagrams_is_taken_whole(redis_url: str) -> None:
    async with served(redis_url) as (service, _):
        robots = {name: Robot(service, name) for name in ("wifibot-14", "wifibot-15")}
        # All of it waits in the socket: this loop, which the server shares, does nothing else meanwhile.
        for number in range(1, 101):
            for name, robot in robots.items():
                robot.send(status(name, CLOCK.now_ns(), number))
        await _counted(service, "accepted", 200)

        async def newest() -> bool:
            return {name: kept.sequence for name, kept in (await _kept(service)).items()} == dict.fromkeys(robots, 100)

        await until(newest)
        assert _taken(service).received == 200


async def test_ten_thousand_mutated_datagrams_are_counted_and_without_effect(redis_url: str) -> None:
    rng, bus = random.Random(3), Bus.connect(redis_url)
    listener = StatusListener(bus, gulliver(), CLOCK, KEY)
    publishing = asyncio.ensure_future(listener.run())
    good = pack(Datagram(ROBOT, 1, CLOCK.now_ns(), status(ROBOT, CLOCK.now_ns())), KEY)
    for _ in range(10_000):
        listener.datagram_received(mutated(good, rng), ("127.0.0.1", 9))
    listener.datagram_received(pack(Datagram(ROBOT, 2, CLOCK.now_ns(), status(ROBOT, CLOCK.now_ns(), 2)), KEY), ("", 9))

    async def kept() -> bool:
        return [found.sequence for found in (await bus.latest_all(STATUSES)).values()] == [2]

    await until(kept)
    counted = listener.state()
    assert (counted.received, counted.undecodable, counted.accepted) == (10_001, 10_000, 1)
    publishing.cancel()
    await asyncio.wait({publishing})
    await bus.close()
