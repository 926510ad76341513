"""Queues of routes, legs left out, stops let go and routes cancelled, through the API."""

from collections.abc import AsyncGenerator
from typing import Any

import httpx
import pytest

from protocol import keys
from protocol.codec import encode
from protocol.messages import Assignment, AssignmentState
from tests.server.service import OTHER_ROBOT, ROBOT, Service, in_process

ASSIGNMENT, QUEUE = f"/api/robots/{ROBOT}/assignment", f"/api/robots/{ROBOT}/queue"


@pytest.fixture
async def service(redis_url: str) -> AsyncGenerator[Service]:
    async with in_process(redis_url) as service:
        yield service


@pytest.fixture
async def operator(service: Service) -> httpx.AsyncClient:
    operator = service.http("operator")
    for name, x in (("a", 1.0), ("b", 2.0), ("c", 3.0)):
        await operator.post("/api/waypoints", json={"id": name, "area": "camp", "x": x, "y": 1.0})
    for route, *waypoints in (("r", "a", "b"), ("s", "b", "c"), ("t", "c")):
        await operator.post("/api/routes", json={"id": route, "legs": [{"waypoint": w} for w in waypoints]})
    await operator.post(
        "/api/routes", json={"id": "round", "legs": [{"waypoint": "a"}, {"waypoint": "b"}], "loop": True}
    )
    return operator


async def change(service: Service, **changes: Any) -> None:
    """What guidance would have written."""
    current = (await service.context.assignments.all())[ROBOT]
    after = current.model_copy(update={**changes, "changed_ns": current.changed_ns + 1})
    await service.context.bus.redis.hset(keys.ASSIGNMENTS, ROBOT, encode(after))  # pyright: ignore[reportGeneralTypeIssues]


async def assigned(service: Service) -> Assignment:
    return (await service.context.assignments.all())[ROBOT]


async def kinds(client: httpx.AsyncClient) -> list[str]:
    return [event["kind"] for event in (await client.get("/api/events", params={"count": 1000})).json()]


async def queued(client: httpx.AsyncClient) -> list[str]:
    view = (await client.get(f"/api/robots/{ROBOT}")).json()
    return [entry["route"] for entry in view["assignment"]["queue"]]


async def test_the_first_route_begins_at_once_and_the_others_wait_in_order(operator: httpx.AsyncClient) -> None:
    first = await operator.post(QUEUE, json={"route": "r"})
    assert (first.status_code, first.json()["state"], first.json()["queue"]) == (201, "running", [])
    await operator.post(QUEUE, json={"route": "s", "speed_scale": 0.5})
    last = (await operator.post(QUEUE, json={"route": "t"})).json()
    assert last["route"] == "r"
    assert [(entry["route"], entry["speed_scale"], entry["queued_by"]) for entry in last["queue"]] == [
        ("s", 0.5, "operator token"),
        ("t", 1.0, "operator token"),
    ]
    assert await queued(operator) == ["s", "t"]
    assert (await kinds(operator))[-3:] == ["route_started", "route_queued", "route_queued"]


async def test_entries_are_taken_out_one_by_one_or_all(operator: httpx.AsyncClient) -> None:
    assert (await operator.delete(QUEUE)).status_code == 404
    await operator.post(QUEUE, json={"route": "r"})
    for route in ("s", "t", "s"):
        await operator.post(QUEUE, json={"route": route})
    entry = (await operator.get(f"/api/robots/{ROBOT}")).json()["assignment"]["queue"][1]["id"]
    assert (await operator.delete(f"{QUEUE}/{entry}")).status_code == 200
    assert await queued(operator) == ["s", "s"]
    gone = await operator.delete(f"{QUEUE}/{entry}")
    assert (gone.status_code, entry in gone.json()["detail"]) == (404, True)
    assert (await operator.delete(QUEUE)).json()["queue"] == []
    assert (await operator.delete(QUEUE)).json()["state"] == "running"
    assert (await kinds(operator))[-2:] == ["route_dequeued", "route_dequeued"]


async def test_what_cannot_be_driven_is_not_queued(operator: httpx.AsyncClient) -> None:
    await operator.post(QUEUE, json={"route": "r"})
    assert (await operator.post(QUEUE, json={"route": "nowhere"})).status_code == 404
    assert (await operator.post("/api/robots/nobody/queue", json={"route": "r"})).status_code == 404
    for _ in range(32):
        assert (await operator.post(QUEUE, json={"route": "s"})).status_code == 201
    full = await operator.post(QUEUE, json={"route": "s"})
    assert (full.status_code, full.json()["detail"]) == (409, f"32 routes wait for {ROBOT} already, more cannot")


async def test_nothing_begins_by_the_queue_while_the_emergency_stop_is_engaged(operator: httpx.AsyncClient) -> None:
    await operator.post("/api/estop", json={"reason": "smoke"})
    assert (await operator.post(QUEUE, json={"route": "r"})).status_code == 409


async def test_a_queued_route_stays(operator: httpx.AsyncClient) -> None:
    await operator.post(QUEUE, json={"route": "r"})
    await operator.post(QUEUE, json={"route": "s"})
    kept = await operator.delete("/api/routes/s")
    assert (kept.status_code, kept.json()["detail"]) == (
        409,
        f"route 's' is queued for {ROBOT}; take it out before it is deleted",
    )
    assert (await operator.put("/api/routes/s", json={"id": "s", "legs": [{"waypoint": "a"}]})).status_code == 200


async def test_stopping_empties_the_queue_and_cancelling_keeps_it(operator: httpx.AsyncClient) -> None:
    for end, left in ((operator.delete(ASSIGNMENT), []), (operator.post(f"{ASSIGNMENT}/cancel"), ["s"])):
        await operator.post(QUEUE, json={"route": "r"})
        await operator.post(QUEUE, json={"route": "s"})
        ended = (await end).json()
        assert (ended["state"], [entry["route"] for entry in ended["queue"]]) == ("stopped", left)
    assert (await operator.post(f"{ASSIGNMENT}/cancel")).status_code == 409
    # What waits is not overtaken by what comes later.
    assert [entry["route"] for entry in (await operator.post(QUEUE, json={"route": "t"})).json()["queue"]] == ["s", "t"]


async def test_a_failed_route_holds_the_queue_until_it_is_cancelled(
    service: Service, operator: httpx.AsyncClient
) -> None:
    await operator.post(QUEUE, json={"route": "r"})
    await operator.post(QUEUE, json={"route": "s"})
    await change(service, state=AssignmentState.FAILED, reason="no way")
    cancelled = (await operator.post(f"{ASSIGNMENT}/cancel")).json()
    assert (cancelled["state"], len(cancelled["queue"])) == ("stopped", 1)


async def test_legs_are_skipped_to_the_end(operator: httpx.AsyncClient) -> None:
    assert (await operator.post(f"{ASSIGNMENT}/skip")).status_code == 404
    await operator.put(ASSIGNMENT, json={"route": "r"})
    assert (await operator.post(f"{ASSIGNMENT}/skip")).json()["leg"] == 1
    await operator.post(f"{ASSIGNMENT}/pause")
    last = (await operator.post(f"{ASSIGNMENT}/skip")).json()
    assert (last["state"], last["reason"]) == ("done", "its last leg was skipped by operator token")
    assert (await operator.post(f"{ASSIGNMENT}/skip")).status_code == 409
    assert (await kinds(operator))[-1] == "leg_skipped"


async def test_skipping_the_last_leg_of_a_loop_begins_its_next_lap_unless_something_waits(
    operator: httpx.AsyncClient,
) -> None:
    await operator.put(ASSIGNMENT, json={"route": "round"})
    for leg, laps in ((1, 0), (0, 1), (1, 1)):
        skipped = (await operator.post(f"{ASSIGNMENT}/skip")).json()
        assert (skipped["leg"], skipped["laps"], skipped["state"]) == (leg, laps, "running")
    await operator.post(QUEUE, json={"route": "s"})
    assert (await operator.post(f"{ASSIGNMENT}/skip")).json()["state"] == "done"


async def test_a_robot_is_let_go_from_a_stop_only(service: Service, operator: httpx.AsyncClient) -> None:
    assert (await operator.post(f"{ASSIGNMENT}/proceed")).status_code == 404
    await operator.put(ASSIGNMENT, json={"route": "r"})
    refused = await operator.post(f"{ASSIGNMENT}/proceed")
    assert (refused.status_code, refused.json()["detail"]) == (409, f"{ROBOT} is not at a stop of its route")
    await change(service, at_stop_ns=1)
    assert (await operator.post(f"{ASSIGNMENT}/proceed")).json()["proceed"] is True
    skipped = (await operator.post(f"{ASSIGNMENT}/skip")).json()
    assert (skipped["leg"], skipped["at_stop_ns"], skipped["proceed"]) == (1, None, False)


async def test_only_operators_may(service: Service, operator: httpx.AsyncClient) -> None:
    await operator.put(ASSIGNMENT, json={"route": "r"})
    for who in ("viewer", "robot"):
        client = service.http(who)
        for path in (f"{ASSIGNMENT}/skip", f"{ASSIGNMENT}/cancel", f"{ASSIGNMENT}/proceed"):
            assert (await client.post(path)).status_code == 403
        assert (await client.post(QUEUE, json={"route": "s"})).status_code == 403
        assert (await client.delete(QUEUE)).status_code == 403
    assert (await assigned(service)).queue == ()
    assert (await operator.get(f"/api/robots/{OTHER_ROBOT}")).json()["assignment"] is None


@pytest.mark.parametrize(
    ("change_of_leg", "says"),
    [
        ({"dwell_s": -1}, "greater than or equal to 0"),
        ({"action": "juggle"}, "'pick_up', 'drop_off' or 'charge'"),
        ({"movement": "Drive"}, "MoveTo"),
        ({"charge_to": 1.5}, "less than or equal to 1"),
        ({"yaw": "north"}, "valid number"),
    ],
)
async def test_legs_that_make_no_sense(operator: httpx.AsyncClient, change_of_leg: dict[str, Any], says: str) -> None:
    answer = await operator.post("/api/routes", json={"id": "odd", "legs": [{"waypoint": "a", **change_of_leg}]})
    assert answer.status_code == 422
    assert says in answer.text
    assert answer.json()["detail"][0]["loc"][:3] == ["body", "legs", 0]
