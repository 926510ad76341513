"""Records that do not decode: they can be replaced and deleted, and what needs them says which one it is."""

from typing import Any

import pytest

from protocol import keys
from protocol.messages import ManualDrive
from tests.server.service import ROBOT, Service, in_process

WAYPOINT = {"id": "a", "area": "camp", "x": 1, "y": 1}
ROUTE = {"id": "r", "legs": [{"waypoint": "a"}]}
OBJECT = {"id": "p", "kind": "pallet", "x": 1, "y": 1}


async def _damage(service: Service, key: str, name: str) -> None:
    await service.context.bus.redis.hset(key, name, b"\xff not json")  # type: ignore[misc,arg-type]


@pytest.mark.parametrize(
    ("key", "folder", "body"),
    [
        (keys.WAYPOINTS, "/api/waypoints", WAYPOINT),
        (keys.ROUTES, "/api/routes", ROUTE),
        (keys.SIMULATED_OBJECTS, "/api/sim/objects", OBJECT),
    ],
)
async def test_a_damaged_record_can_be_replaced_and_deleted(
    redis_url: str, key: str, folder: str, body: dict[str, Any]
) -> None:
    async with in_process(redis_url) as service:
        operator, address = service.http("operator"), f"{folder}/{body['id']}"
        await operator.post("/api/waypoints", json=WAYPOINT)
        for replace in (operator.put(address, json=body), operator.post(folder, json=body)):
            await _damage(service, key, body["id"])
            answer = await replace
            assert answer.status_code in (200, 201), answer.text
            assert [item["id"] for item in (await operator.get(folder)).json()] == [body["id"]]
        await _damage(service, key, body["id"])
        assert (await operator.get(folder)).json() == []
        assert (await operator.delete(address)).status_code == 204
        assert (await operator.delete(address)).status_code == 404


async def test_what_needs_a_damaged_record_names_it(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        operator, address = service.http("operator"), f"/api/robots/{ROBOT}/assignment"
        await _damage(service, keys.ROUTES, "r")
        answer = await operator.put(address, json={"route": "r"})
        assert answer.status_code == 503
        assert answer.json()["detail"].startswith(f"the record r in {keys.ROUTES} is damaged: not a Route")
        await operator.post("/api/waypoints", json=WAYPOINT)
        await operator.put("/api/routes/r", json=ROUTE)
        await _damage(service, keys.ASSIGNMENTS, ROBOT)
        assert (await operator.delete(address)).status_code == 404
        assert (await operator.put(address, json={"route": "r"})).status_code == 200


async def test_a_damaged_stick_or_registration_is_taken_anew(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        operator, twist = service.http("operator"), {"linear_mps": 0.1, "angular_radps": 0}
        for channel in ("manual", "registrations"):
            await _damage(service, keys.live(channel), ROBOT)
        assert (await operator.delete(f"/api/robots/{ROBOT}/manual")).status_code == 204
        assert (await operator.put(f"/api/robots/{ROBOT}/manual", json=twist)).status_code == 200
        introduced = await service.http("robot").post(f"/api/robots/{ROBOT}/registration", json={"udp_port": 4711})
        assert introduced.status_code == 200, introduced.text


def test_a_stick_taken_before_names_were_kept_still_reads() -> None:
    old = {"robot": ROBOT, "linear_mps": 0.1, "angular_radps": 0.0, "holder": "x", "expires_ns": 1}
    assert ManualDrive.model_validate(old).by == ""
