"""Waypoints, routes and assignments through the API: what is refused, and that nothing comes to name what is gone."""

import asyncio
import json
from collections.abc import AsyncGenerator
from typing import Any

import httpx
import pytest
import redis

from protocol import keys
from protocol.clock import SimulatedClock
from protocol.messages import Assignment, AssignmentState
from server.errors import ConflictError
from server.repositories.assignments import AssignmentRepository
from server.repositories.documents import Store, Transaction
from server.repositories.plan import ASSIGNMENTS
from tests.redis_fixture import RedisServer
from tests.server.service import OTHER_ROBOT, ROBOT, Service, in_process

WAYPOINT = {"id": "a", "area": "camp", "x": 1.0, "y": 1.0}


@pytest.fixture
async def service(redis_url: str) -> AsyncGenerator[Service]:
    async with in_process(redis_url) as service:
        yield service


@pytest.fixture
async def operator(service: Service) -> httpx.AsyncClient:
    return service.http("operator")


async def _events(client: httpx.AsyncClient) -> list[dict[str, Any]]:
    return (await client.get("/api/events", params={"count": 1000})).json()


async def _plan(operator: httpx.AsyncClient) -> None:
    for name, x in (("a", 1.0), ("b", 2.0), ("c", 3.0)):
        answer = await operator.post("/api/waypoints", json={**WAYPOINT, "id": name, "x": x})
        assert answer.status_code == 201
    answer = await operator.post("/api/routes", json={"id": "r", "legs": [{"waypoint": "a"}, {"waypoint": "b"}]})
    assert answer.status_code == 201


@pytest.mark.parametrize(
    ("change", "location", "says"),
    [
        ({"x": 99.0}, ["body"], "outside every area"),
        ({"area": "nowhere"}, ["body", "area"], "there is no area 'nowhere' (areas: camp)"),
        ({"id": "Not An Id"}, ["body", "id"], "pattern"),
        ({"radius_m": 0}, ["body", "radius_m"], "greater than 0"),
        ({"colour": "red"}, ["body", "colour"], "Extra inputs"),
        ({"x": None}, ["body", "x"], "valid number"),
    ],
)
async def test_waypoints_that_are_refused(
    operator: httpx.AsyncClient, change: dict[str, Any], location: list[str], says: str
) -> None:
    answer = await operator.post("/api/waypoints", json={**WAYPOINT, **change})
    assert answer.status_code == 422
    (problem,) = answer.json()["detail"]
    assert problem["loc"] == location
    assert says in problem["msg"]
    assert (await operator.get("/api/waypoints")).json() == []


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999"])
async def test_a_waypoint_at_no_number_is_refused(operator: httpx.AsyncClient, number: str) -> None:
    body = json.dumps(WAYPOINT).replace("1.0", number, 1)
    answer = await operator.post("/api/waypoints", content=body, headers={"Content-Type": "application/json"})
    assert answer.status_code == 422
    assert answer.json()["detail"][0]["loc"] == ["body", "x"]
    assert "finite" in answer.json()["detail"][0]["msg"]


async def test_waypoints_are_created_changed_and_deleted(operator: httpx.AsyncClient) -> None:
    assert (await operator.post("/api/waypoints", json=WAYPOINT)).status_code == 201
    assert (await operator.post("/api/waypoints", json=WAYPOINT)).status_code == 409
    moved = await operator.put("/api/waypoints/a", json={**WAYPOINT, "x": 2.5, "yaw": 1.0})
    assert moved.json() == {"id": "a", "area": "camp", "x": 2.5, "y": 1.0, "radius_m": 0.15, "yaw": 1.0}
    assert (await operator.get("/api/waypoints")).json() == [moved.json()]
    assert (await operator.put("/api/waypoints/b", json=WAYPOINT)).status_code == 422
    assert (await operator.delete("/api/waypoints/a")).status_code == 204
    assert (await operator.delete("/api/waypoints/a")).status_code == 404
    told = [(event["kind"], event["source"]) for event in await _events(operator)]
    by = "operator token"
    assert told[-3:] == [("waypoint_created", by), ("waypoint_changed", by), ("waypoint_deleted", by)]


async def test_routes_name_waypoints_that_exist(operator: httpx.AsyncClient) -> None:
    await _plan(operator)
    bad = {"id": "s", "legs": [{"waypoint": "a"}, {"waypoint": "gone"}]}
    for answer in (await operator.post("/api/routes", json=bad), await operator.put("/api/routes/s", json=bad)):
        assert answer.status_code == 422
        assert answer.json()["detail"][0]["loc"] == ["body", "legs", 1, "waypoint"]
        assert answer.json()["detail"][0]["msg"] == "there is no waypoint 'gone'"
    assert (await operator.post("/api/routes", json={"id": "s", "legs": []})).status_code == 422
    assert [route["id"] for route in (await operator.get("/api/routes")).json()] == ["r"]
    used = await operator.delete("/api/waypoints/a")
    assert used.status_code == 409
    assert used.json()["detail"] == "waypoint 'a' is used by route r"
    assert (await operator.delete("/api/waypoints/c")).status_code == 204


async def test_a_route_being_driven_stays_as_it_is(operator: httpx.AsyncClient) -> None:
    await _plan(operator)
    route = {"id": "r", "legs": [{"waypoint": "c"}]}
    await operator.put(f"/api/robots/{ROBOT}/assignment", json={"route": "r"})
    for _ in range(2):
        for answer in (await operator.put("/api/routes/r", json=route), await operator.delete("/api/routes/r")):
            assert answer.status_code == 409
            assert ROBOT in answer.json()["detail"]
        await operator.post(f"/api/robots/{ROBOT}/assignment/pause")
    assert (await operator.put("/api/waypoints/b", json={**WAYPOINT, "id": "b", "x": 4.0})).status_code == 200
    await operator.delete(f"/api/robots/{ROBOT}/assignment")
    assert (await operator.put("/api/routes/r", json=route)).status_code == 200
    assert (await operator.delete("/api/routes/r")).status_code == 204


async def test_an_assignment_from_start_to_stop(operator: httpx.AsyncClient) -> None:
    await _plan(operator)
    path = f"/api/robots/{ROBOT}/assignment"
    assert (await operator.post(f"{path}/pause")).status_code == 404
    assert (await operator.put(path, json={"route": "nowhere"})).status_code == 404
    assert (await operator.put("/api/robots/nobody/assignment", json={"route": "r"})).status_code == 404
    started = await operator.put(path, json={"route": "r", "speed_scale": 0.5})
    assert started.status_code == 200
    assert started.json()["state"] == "running"
    assert (started.json()["started_by"], started.json()["speed_scale"]) == ("operator token", 0.5)
    assert (await operator.put(path, json={"route": "r"})).status_code == 409
    assert (await operator.post(f"{path}/resume")).status_code == 409
    assert (await operator.post(f"{path}/pause")).json()["state"] == "paused"
    assert (await operator.post(f"{path}/pause")).status_code == 409
    assert (await operator.put(path, json={"route": "r"})).status_code == 409
    assert (await operator.post(f"{path}/resume")).json()["state"] == "running"
    stopped = (await operator.delete(path)).json()
    assert (stopped["state"], stopped["reason"]) == ("stopped", "stopped by operator token")
    assert (await operator.delete(path)).status_code == 409
    again = await operator.put(path, json={"route": "r"})
    assert again.json()["id"] != started.json()["id"]
    kinds = [event["kind"] for event in await _events(operator)]
    assert kinds[-5:] == ["route_started", "route_paused", "route_resumed", "route_stopped", "route_started"]


@pytest.mark.parametrize("scale", [0, -1, 2.5, "NaN"])
async def test_speed_scales_that_make_no_sense(operator: httpx.AsyncClient, scale: float | str) -> None:
    await _plan(operator)
    body = f'{{"route": "r", "speed_scale": {scale}}}'
    headers = {"Content-Type": "application/json"}
    answer = await operator.put(f"/api/robots/{ROBOT}/assignment", content=body, headers=headers)
    assert answer.status_code == 422


async def test_a_route_does_not_start_without_its_waypoints(
    operator: httpx.AsyncClient, redis_server: RedisServer
) -> None:
    await _plan(operator)
    with redis.Redis.from_url(redis_server.url) as client:
        client.hdel(keys.WAYPOINTS, "b")
    answer = await operator.put(f"/api/robots/{ROBOT}/assignment", json={"route": "r"})
    assert answer.status_code == 409
    assert answer.json()["detail"] == "route 'r' needs waypoint b, which does not exist"


async def test_only_one_of_many_starts_wins(operator: httpx.AsyncClient) -> None:
    await _plan(operator)
    answers = await asyncio.gather(
        *(operator.put(f"/api/robots/{ROBOT}/assignment", json={"route": "r"}) for _ in range(8))
    )
    assert sorted(answer.status_code for answer in answers) == [200] + [409] * 7


async def test_a_waypoint_cannot_vanish_under_a_new_route(operator: httpx.AsyncClient) -> None:
    await operator.post("/api/waypoints", json=WAYPOINT)
    for number in range(10):
        await operator.put("/api/waypoints/a", json=WAYPOINT)
        route = {"id": f"r{number}", "legs": [{"waypoint": "a"}]}
        made, deleted = await asyncio.gather(
            operator.post("/api/routes", json=route), operator.delete("/api/waypoints/a")
        )
        assert (made.status_code, deleted.status_code) in {(201, 409), (422, 204)}
        await operator.delete(f"/api/routes/r{number}")


async def test_the_service_begins_again_when_guidance_writes_meanwhile(redis_url: str) -> None:
    """A stop that read the assignment just before guidance moved it on keeps guidance's leg."""
    clock = SimulatedClock()
    async with redis_client(redis_url) as client:
        store = Store(client)
        now_ns = clock.now_ns()
        running = Assignment(
            id="1", robot=ROBOT, route="r", state=AssignmentState.RUNNING, started_ns=now_ns, changed_ns=now_ns
        )
        await client.hset(keys.ASSIGNMENTS, ROBOT, running.model_dump_json())  # type: ignore[misc]
        interfered: list[int] = []
        original = Transaction.get

        async def get(self: Transaction, documents: Any, name: str) -> Any:
            found = await original(self, documents, name)
            if documents is ASSIGNMENTS and not interfered:
                interfered.append(1)
                ahead = running.model_copy(update={"leg": 7, "changed_ns": now_ns + 5})
                await client.hset(keys.ASSIGNMENTS, ROBOT, ahead.model_dump_json())  # type: ignore[misc]
            return found

        Transaction.get = get  # type: ignore[method-assign]
        try:
            stopped = await AssignmentRepository(store, clock).stop(ROBOT, "eva")
        finally:
            Transaction.get = original  # type: ignore[method-assign]
        assert (stopped.leg, stopped.state) == (7, AssignmentState.STOPPED)
        assert stopped.changed_ns > now_ns + 5
        with pytest.raises(ConflictError, match="is stopped, it cannot be paused"):
            await AssignmentRepository(store, clock).pause(ROBOT, "eva")


def redis_client(url: str) -> Any:
    import redis.asyncio

    return redis.asyncio.Redis.from_url(url)


async def test_settings_of_a_robot(operator: httpx.AsyncClient) -> None:
    path = f"/api/robots/{OTHER_ROBOT}/settings"
    answer = await operator.put(path, json={"box_length_m": 1.5, "stop_at_waypoint": True})
    assert answer.status_code == 200
    robot = (await operator.get(f"/api/robots/{OTHER_ROBOT}")).json()
    box = {"start_m": 0.2, "length_m": 1.5, "width_m": 0.45, "stop_at_waypoint": True, "robots": True, "unknown": True}
    assert robot["obstacle_box"] == box
    assert robot["detours"] == {"enabled": True, "after_s": 3.0, "clearance_m": 0.3}
    await operator.put(path, json={"detours": False, "box_robots": False, "detour_after_s": 5.0})
    robot = (await operator.get(f"/api/robots/{OTHER_ROBOT}")).json()
    assert (robot["detours"]["enabled"], robot["detours"]["after_s"]) == (False, 5.0)
    assert robot["obstacle_box"]["robots"] is False
    for bad in ({"box_length_m": -1}, {"box_width_m": 0}, {"length": 1}):
        assert (await operator.put(path, json=bad)).status_code == 422
    assert (await operator.put("/api/robots/nobody/settings", json={})).status_code == 404


async def test_simulated_objects(operator: httpx.AsyncClient) -> None:
    pallet = {"id": "pallet", "kind": "pallet", "x": 1.0, "y": 2.0}
    assert (await operator.post("/api/sim/objects", json=pallet)).status_code == 201
    assert (await operator.post("/api/sim/objects", json=pallet)).status_code == 409
    assert (await operator.put("/api/sim/objects/pallet", json={**pallet, "x": 3.0})).json()["x"] == 3.0
    assert (await operator.put("/api/sim/objects/other", json=pallet)).status_code == 422
    assert (await operator.delete("/api/sim/objects/pallet")).status_code == 204
    assert (await operator.delete("/api/sim/objects/pallet")).status_code == 404
    assert (await operator.get("/api/sim/objects")).json() == []


async def test_simulated_cameras_suffer_faults_until_they_are_taken_back(service: Service) -> None:
    operator = service.http("operator")

    async def fault() -> Any:
        return {camera["id"]: camera["fault"] for camera in (await operator.get("/api/cameras")).json()}["cam1"]

    assert await fault() is None
    bump = {"kind": "bump", "shift_x_m": 0.02}
    assert (await operator.put("/api/sim/cameras/cam1/fault", json=bump)).status_code == 200
    assert (await fault())["shift_x_m"] == 0.02
    assert (await operator.put("/api/sim/cameras/cam1/fault", json={"kind": "bump", "shift_x_m": 9})).status_code == 422
    answer = await operator.put("/api/sim/cameras/cam9/fault", json=bump)
    assert (answer.status_code, answer.json()["detail"]) == (404, "there is no simulated camera 'cam9'")
    assert (await operator.delete("/api/sim/cameras/cam1/fault")).status_code == 204
    assert (await operator.delete("/api/sim/cameras/cam1/fault")).status_code == 404
    assert await fault() is None
    kinds = [event["kind"] for event in (await operator.get("/api/events")).json()]
    assert kinds[-2:] == ["fault_begun", "fault_ended"]
