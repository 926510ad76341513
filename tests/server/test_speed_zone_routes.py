"""Zones with a speed limit through the API: what is refused, and that the lab's own stay as they are."""

import math
from collections.abc import AsyncGenerator
from typing import Any

import pytest

from protocol.lab import SpeedZoneSpec
from server.repositories.speed_zones import speed_zones_of
from tests.server.service import Service, gulliver, in_process

OUTLINE = [[3.0, 1.0], [4.0, 1.0], [4.0, 2.0], [3.0, 2.0]]
ZONE = {"id": "doorway", "outline": OUTLINE, "speed_mps": 0.2}
FIXED = SpeedZoneSpec(id="ramp", outline=((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), speed_mps=0.1)


def test_every_zone_that_a_lab_file_may_have_can_be_shown() -> None:
    turns = [math.tau * corner / 64 for corner in range(64)]
    widest = SpeedZoneSpec(
        id="bend", outline=tuple((1e9 * math.cos(turn), 1e9 * math.sin(turn)) for turn in turns), speed_mps=10.0
    )
    (shown,) = speed_zones_of(gulliver().model_copy(update={"speed_zones": (widest,)})).values()
    assert (shown.id, shown.outline, shown.speed_mps) == ("bend", widest.outline, 10.0)


@pytest.fixture
async def service(redis_url: str) -> AsyncGenerator[Service]:
    async with in_process(redis_url, lab=gulliver().model_copy(update={"speed_zones": (FIXED,)})) as service:
        yield service


async def test_zones_are_drawn_changed_and_deleted(service: Service) -> None:
    operator = service.http("operator")
    assert (await operator.post("/api/speed-zones", json=ZONE)).status_code == 201
    assert (await operator.post("/api/speed-zones", json=ZONE)).status_code == 409
    slower = await operator.put("/api/speed-zones/doorway", json={**ZONE, "speed_mps": 0.1})
    assert slower.json() == {**ZONE, "speed_mps": 0.1}
    assert {zone["id"] for zone in (await operator.get("/api/speed-zones")).json()} == {"doorway", "ramp"}
    assert (await operator.put("/api/speed-zones/other", json=ZONE)).status_code == 422
    assert (await service.http("viewer").delete("/api/speed-zones/doorway")).status_code == 403
    assert (await operator.delete("/api/speed-zones/doorway")).status_code == 204
    assert (await operator.delete("/api/speed-zones/doorway")).status_code == 404
    kinds = [event["kind"] for event in (await operator.get("/api/events")).json()]
    assert kinds[-3:] == ["speed_zone_changed", "speed_zone_changed", "speed_zone_deleted"]


async def test_the_labs_own_zones_stay(service: Service) -> None:
    operator = service.http("operator")
    for answer in (
        await operator.post("/api/speed-zones", json={**ZONE, "id": "ramp"}),
        await operator.put("/api/speed-zones/ramp", json={**ZONE, "id": "ramp"}),
        await operator.delete("/api/speed-zones/ramp"),
    ):
        assert answer.status_code == 409
        assert answer.json()["detail"] == "speed zone 'ramp' is part of the lab description; change it there"


@pytest.mark.parametrize(
    ("change", "location", "says"),
    [
        ({"outline": [[0, 0], [1, 1], [1, 0], [0, 1]]}, ["body", "outline"], "not a simple polygon"),
        ({"outline": [[0, 0], [1, 1]]}, ["body", "outline"], "at least 3"),
        ({"speed_mps": 0}, ["body", "speed_mps"], "greater than 0"),
        ({"speed": 1}, ["body", "speed"], "Extra inputs"),
    ],
)
async def test_zones_that_are_refused(service: Service, change: dict[str, Any], location: list[str], says: str) -> None:
    answer = await service.http("operator").post("/api/speed-zones", json={**ZONE, **change})
    assert answer.status_code == 422
    assert answer.json()["detail"][0]["loc"] == location
    assert says in answer.json()["detail"][0]["msg"]
