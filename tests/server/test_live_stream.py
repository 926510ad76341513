"""The live WebSocket: snapshot first, then changes; slow and dead clients hold nobody up; who may look."""

import asyncio
import json
import socket
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from protocol import keys
from protocol.channels import COMMANDS, OBSTACLES, POSES, STATUSES
from protocol.clock import SystemClock
from protocol.codec import encode
from server.views.live import LiveChanges, LiveSnapshot
from tests.redis_fixture import RedisServer
from tests.server.samples import command, extrinsics, pose, raster, status
from tests.server.service import PASSWORD, ROBOT, Service, served, until

CLOCK = SystemClock()
WAYPOINT = {"id": "a", "area": "camp", "x": 1.0, "y": 1.0}
SPEED_ZONE = {"id": "doorway", "outline": [[3.0, 1.0], [4.0, 1.0], [4.0, 2.0]], "speed_mps": 0.2}


@asynccontextmanager
async def looking(service: Service, who: str | None = "viewer", **options: Any) -> AsyncGenerator[ClientConnection]:
    headers = {"Authorization": f"Bearer {service.tokens[who]}"} if who else {}
    headers |= options.pop("headers", {})
    url = service.base_url.replace("http", "ws") + "/api/live"
    async with connect(url, additional_headers=headers, proxy=None, max_size=None, **options) as client:
        yield client


def at(x: float) -> Callable[[dict[str, Any]], bool]:
    """Whether the robot is shown at that place."""

    def shown(state: dict[str, Any]) -> bool:
        seen = state["robots"][ROBOT]["pose"]
        return seen is not None and seen["x"] == x

    return shown


class Picture:
    """What a console makes of the messages: the state, by the rules of the stream."""

    def __init__(self, client: ClientConnection) -> None:
        self.client = client
        self.state: dict[str, Any] = {}
        self.messages = 0

    async def step(self) -> None:
        message = json.loads(await self.client.recv())
        self.messages += 1
        if message["type"] == "snapshot":
            LiveSnapshot.model_validate(message)
            self.state = message
            return
        LiveChanges.model_validate(message)
        assert self.state, "changes before a snapshot"
        for section, value in message.items():
            if section in ("robots", "cameras", "waypoints", "routes", "objects", "zones", "speed_zones"):
                merged = {**self.state[section], **value}
                self.state[section] = {name: entry for name, entry in merged.items() if entry is not None}
            elif section == "events":
                self.state["events"] += value
            else:
                self.state[section] = value

    async def until(self, condition: Callable[[dict[str, Any]], object], within_s: float = 15.0) -> None:
        async with asyncio.timeout(within_s):
            while not self.state or not condition(self.state):
                await self.step()


async def test_snapshot_then_changes(redis_url: str) -> None:
    async with served(redis_url) as (service, _), looking(service) as client:
        operator, picture = service.http("operator"), Picture(client)
        await picture.step()
        assert picture.state["type"] == "snapshot"
        assert set(picture.state["robots"]) == {"wifibot-14", "wifibot-15", "turtlebot-16", "turtlebot-17"}
        assert set(picture.state["zones"]) == {"crossing", "merge", "roundabout"}
        await operator.post("/api/waypoints", json=WAYPOINT)
        await picture.until(lambda state: "a" in state["waypoints"])
        await operator.put("/api/waypoints/a", json={**WAYPOINT, "x": 2.0})
        await picture.until(lambda state: state["waypoints"]["a"]["x"] == 2.0)
        await operator.post("/api/routes", json={"id": "r", "legs": [{"waypoint": "a"}]})
        await operator.put(f"/api/robots/{ROBOT}/assignment", json={"route": "r"})
        await picture.until(lambda state: state["robots"][ROBOT]["assignment"] is not None)
        await operator.post("/api/estop", json={"reason": "fire"})
        await picture.until(lambda state: state["estop"]["engaged"])
        await operator.put(f"/api/robots/{ROBOT}/settings", json={"box_length_m": 3.0})
        await picture.until(lambda state: state["robots"][ROBOT]["obstacle_box"]["length_m"] == 3.0)
        await operator.post("/api/sim/objects", json={"id": "p", "kind": "pallet", "x": 1, "y": 1})
        await picture.until(lambda state: "p" in state["objects"])
        await operator.post("/api/speed-zones", json=SPEED_ZONE)
        await picture.until(lambda state: state["speed_zones"])
        assert picture.state["speed_zones"] == {"doorway": SPEED_ZONE}
        await operator.delete("/api/speed-zones/doorway")
        await picture.until(lambda state: not state["speed_zones"])
        await operator.delete(f"/api/robots/{ROBOT}/assignment")
        await operator.delete("/api/routes/r")
        await operator.delete("/api/waypoints/a")
        await picture.until(lambda state: not state["waypoints"] and not state["routes"])
        await picture.until(lambda state: state["events"][-1]["kind"] == "waypoint_deleted")
        assert [e["kind"] for e in picture.state["events"]].count("emergency_stop") == 1


async def test_what_robots_and_cameras_say_arrives(redis_url: str) -> None:
    async with served(redis_url) as (service, _), looking(service) as client:
        bus, picture = service.context.bus, Picture(client)
        await bus.publish(POSES, ROBOT, pose(ROBOT, CLOCK.now_ns(), 3.5))
        await bus.publish(STATUSES, ROBOT, status(ROBOT, CLOCK.now_ns(), battery=0.5))
        await bus.publish(COMMANDS, ROBOT, command(ROBOT, CLOCK.now_ns()))
        await bus.publish(OBSTACLES, "lab", raster(CLOCK.now_ns()))
        await bus.redis.hset(keys.EXTRINSICS, "cam0", encode(extrinsics("cam0")))  # type: ignore[misc]
        await picture.until(lambda state: state["robots"][ROBOT]["pose"] is not None)
        shown = picture.state["robots"][ROBOT]
        assert (shown["pose"]["x"], shown["pose"]["fresh"]) == (3.5, True)
        assert shown["pose"]["age_s"] < 1
        await picture.until(lambda state: state["robots"][ROBOT]["connection"] == "ONLINE")
        await picture.until(lambda state: state["obstacles"] is not None)
        assert picture.state["obstacles"]["occupied"] == "gAA="
        # Time alone changes these: nobody says anything any more.
        await picture.until(lambda state: not state["robots"][ROBOT]["pose"]["fresh"])
        await picture.until(lambda state: state["robots"][ROBOT]["connection"] == "CONNECTION_BROKEN")
        assert picture.state["robots"][ROBOT]["state"] == "offline"
        await picture.until(lambda state: state["cameras"]["cam0"]["outline"] is not None)


async def test_at_most_twenty_messages_a_second(redis_url: str) -> None:
    async with served(redis_url) as (service, _), looking(service) as client:
        bus, picture = service.context.bus, Picture(client)
        await picture.step()
        started = CLOCK.monotonic_s()
        number = 0
        while CLOCK.monotonic_s() - started < 1.0:
            number += 1
            await bus.publish(POSES, ROBOT, pose(ROBOT, CLOCK.now_ns(), number / 1000))
            await asyncio.sleep(0.002)
        await picture.until(at(number / 1000))
        elapsed = CLOCK.monotonic_s() - started
        assert number > 40
        assert picture.messages <= 20 * elapsed + 3


async def test_a_slow_client_holds_nobody_up_and_gets_the_newest(redis_url: str) -> None:
    async with served(redis_url) as (service, _):
        bus = service.context.bus
        slow_socket = socket.create_connection(("127.0.0.1", int(service.base_url.rpartition(":")[2])))
        slow_socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65536)
        # A small queue and no reading: the messages pile up in the server's buffers, which are small too.
        async with looking(service) as fast, looking(service, sock=slow_socket, max_queue=1) as slow:
            quick, late = Picture(fast), Picture(slow)
            await quick.step()
            for number in range(1, 26):
                # Every step carries 200 kB, so that buffers fill.
                await bus.publish(OBSTACLES, "lab", raster(CLOCK.now_ns(), number.to_bytes(2, "big") * 75_000))
                await bus.publish(POSES, ROBOT, pose(ROBOT, CLOCK.now_ns(), float(number)))
                await quick.until(at(number))
            await late.until(at(25))
            assert quick.messages >= 25
            assert late.messages < quick.messages / 2
            assert late.state["obstacles"] == quick.state["obstacles"]


async def test_a_dead_client_is_cut_off(redis_url: str) -> None:
    """One that takes nothing keeps its socket for as long as it is given, not for ever."""
    async with served(redis_url, dead_after_ms=200) as (service, _):
        bus = service.context.bus
        dead = socket.create_connection(("127.0.0.1", int(service.base_url.rpartition(":")[2])))
        dead.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65536)
        async with looking(service, sock=dead, max_queue=1, close_timeout=0.1):
            assert service.context.hub.clients == 1
            number = 0

            async def gone() -> bool:
                nonlocal number
                number += 1
                await bus.publish(OBSTACLES, "lab", raster(CLOCK.now_ns(), number.to_bytes(2, "big") * 100_000))
                await asyncio.sleep(0.05)
                return service.context.hub.clients == 0

            await until(gone, within_s=30)


@pytest.mark.parametrize(
    ("who", "headers", "code"),
    [
        (None, {}, 401),
        (None, {"Authorization": "Bearer wrong"}, 401),
        ("robot", {}, 403),
        ("viewer", {"Origin": "http://evil.example"}, 403),
        ("viewer", {"Origin": "null"}, 403),
    ],
)
async def test_who_may_not_look(redis_url: str, who: str | None, headers: dict[str, str], code: int) -> None:
    async with served(redis_url) as (service, _):
        with pytest.raises(InvalidStatus) as refused:
            async with looking(service, who, headers=headers):
                pass
        assert refused.value.response.status_code == code
        assert b"detail" in (refused.value.response.body or b"")


async def test_a_session_looks_from_its_own_page(redis_url: str) -> None:
    async with served(redis_url) as (service, _):
        client = service.http()
        await client.post("/api/session", json={"user": "viewer", "password": PASSWORD})
        cookie = f"lilliput_session={client.cookies['lilliput_session']}"
        async with looking(service, None, headers={"Cookie": cookie, "Origin": service.base_url}) as live:
            await Picture(live).step()


async def test_it_goes_on_after_redis_was_away(redis_server: RedisServer) -> None:
    async with served(redis_server.url) as (service, _), looking(service) as client:
        picture = Picture(client)
        await picture.step()
        redis_server.kill()
        await picture.until(lambda state: not state["health"]["redis"]["reachable"])
        assert picture.state["health"]["state"] == "error"
        redis_server.start()
        await picture.until(lambda state: state["health"]["redis"]["reachable"])
        answer = await service.http("operator").post("/api/waypoints", json=WAYPOINT)
        assert answer.status_code == 201
        await picture.until(lambda state: "a" in state["waypoints"])


async def test_it_ends_with_the_server(redis_url: str) -> None:
    async with served(redis_url) as (service, serving), looking(service) as client:
        await client.recv()
        serving.should_exit = True
        async with asyncio.timeout(2):
            with pytest.raises(ConnectionClosed):
                while True:
                    await client.recv()
        assert client.close_code == 1012
