"""Calibration through the API: what is asked for, decided and undone, and who may."""

from collections.abc import AsyncGenerator
from typing import Any

import httpx
import pytest
import redis.asyncio

from launcher.paths import DEFAULT_LAB
from protocol import keys
from protocol.channels import CALIBRATION_RUNS, LAB_INSTANCE
from protocol.clock import SimulatedClock
from protocol.codec import encode
from protocol.lab import camera_basis, floor_basis, load_lab
from protocol.messages import (
    CalibratedCamera,
    CalibratedFloorTag,
    Calibration,
    CalibrationProposal,
    CalibrationRun,
    RunState,
)
from protocol.messages.calibration import CURRENT, PREVIOUS
from tests.server.service import Service, in_process

CAMERAS = ["cam0", "cam1", "cam2", "cam3"]


@pytest.fixture
def clock() -> SimulatedClock:
    return SimulatedClock()


@pytest.fixture
async def service(redis_url: str, clock: SimulatedClock) -> AsyncGenerator[Service]:
    async with in_process(redis_url, clock) as service:
        yield service


@pytest.fixture
async def operator(service: Service) -> httpx.AsyncClient:
    return service.http("operator")


@pytest.fixture
async def client(redis_url: str) -> AsyncGenerator[redis.asyncio.Redis]:
    async with redis.asyncio.Redis.from_url(redis_url) as made:
        yield made


LAB = load_lab(DEFAULT_LAB)


def calibration(number: int, x: float = 0.0, *, floor: str | None = None, lens: str | None = None) -> Calibration:
    """Of the lab that the service has, unless `floor` or `lens` are another one's digests."""
    camera = CalibratedCamera(
        rotvec=(3.1, 0.0, 0.0),
        translation=(x, 0.0, 2.9),
        reprojection_px=0.2,
        floor_tags=(0, 1),
        basis=lens or camera_basis(LAB.camera("cam0")),
    )
    tags = {0: CalibratedFloorTag(x=0.0, y=0.0, yaw=0.0, shift_m=0.001)}
    basis = floor or floor_basis(LAB.floor_tags)
    return Calibration(
        id=number, stamp_ns=1, by="calibrator", floor_basis=basis, cameras={"cam0": camera}, floor_tags=tags
    )


async def put(client: redis.asyncio.Redis, key: str, field: str, data: bytes) -> None:
    await client.hset(key, field, data)  # pyright: ignore[reportArgumentType]  # bytes are fine


async def propose(client: redis.asyncio.Redis, operator: httpx.AsyncClient, floor: str | None = None) -> int:
    """As the calibrator answers to a start."""
    run = CalibrationRun.model_validate_json((await operator.post("/api/calibration", json={})).content)
    proposal = CalibrationProposal(
        calibration=calibration(run.id, 0.5, floor=floor), cameras={}, floor_tags={}, not_answered=()
    )
    await put(client, keys.CALIBRATION_PROPOSALS, LAB_INSTANCE, encode(proposal))
    proposed = run.model_copy(update={"state": RunState.PROPOSED})
    await put(client, keys.live(CALIBRATION_RUNS.name), LAB_INSTANCE, encode(proposed))
    return run.id


async def state(operator: httpx.AsyncClient) -> dict[str, Any]:
    return (await operator.get("/api/calibration")).raise_for_status().json()


async def history(operator: httpx.AsyncClient) -> list[tuple[str, str]]:
    events = (await operator.get("/api/events")).json()
    return [(event["kind"], event["text"]) for event in events if event["kind"].startswith("calibration")]


async def test_nothing_is_known_before_the_first_calibration(operator: httpx.AsyncClient) -> None:
    known = await state(operator)
    assert {name: known[name] for name in ("run", "current", "previous", "proposal")} == dict.fromkeys(
        ("run", "current", "previous", "proposal")
    )


async def test_a_run_is_started_for_all_cameras_or_some_and_not_twice_at_once(
    operator: httpx.AsyncClient, clock: SimulatedClock
) -> None:
    first = await operator.post("/api/calibration", json={})
    assert first.status_code == 201
    assert first.json()["cameras"] == CAMERAS
    assert first.json()["by"] == "operator token"
    assert (await state(operator))["run"] == first.json()
    refused = await operator.post("/api/calibration", json={"cameras": ["cam1"]})
    assert refused.status_code == 409
    assert "operator token is going on" in refused.json()["detail"]
    await clock.advance(61)  # its calibrator died
    second = await operator.post("/api/calibration", json={"cameras": ["cam2", "cam1"]})
    assert second.status_code == 201
    assert second.json()["cameras"] == ["cam1", "cam2"]
    assert second.json()["id"] > first.json()["id"]


@pytest.mark.parametrize(
    ("cameras", "says"), [(["cam9"], "there is no camera 'cam9'; there are cam0, cam1"), ([], "at least one")]
)
async def test_cameras_that_do_not_exist_are_refused(
    operator: httpx.AsyncClient, cameras: list[str], says: str
) -> None:
    answer = await operator.post("/api/calibration", json={"cameras": cameras})
    assert answer.status_code == 422
    assert says in answer.json()["detail"][0]["msg"]
    assert (await state(operator))["run"] is None


async def test_an_accepted_proposal_is_in_force_and_can_be_undone_and_redone(
    operator: httpx.AsyncClient, client: redis.asyncio.Redis, clock: SimulatedClock
) -> None:
    await put(client, keys.CALIBRATIONS, CURRENT, encode(calibration(1)))
    proposed = await propose(client, operator)
    await clock.advance(1)
    accepted = await operator.post("/api/calibration/accept", json={"id": proposed})
    assert accepted.status_code == 200
    now = await state(operator)
    assert now["current"] == accepted.json()
    assert (now["current"]["id"], now["current"]["by"]) == (proposed, "operator token")
    assert now["current"]["stamp_ns"] == clock.now_ns(), "newer than what cameras found by themselves"
    assert now["previous"] == calibration(1).model_dump(mode="json")
    assert now["proposal"] is None
    assert now["run"]["state"] == "accepted"

    await clock.advance(1)
    restored = await operator.post("/api/calibration/restore")
    assert restored.status_code == 200
    assert restored.json()["cameras"] == now["previous"]["cameras"]
    assert restored.json()["stamp_ns"] == clock.now_ns()
    assert (await state(operator))["previous"] == now["current"]
    again = await operator.post("/api/calibration/restore")
    assert again.json()["cameras"] == now["current"]["cameras"]
    assert await history(operator) == [
        ("calibration_started", "operator token started a calibration of cam0, cam1, cam2, cam3"),
        ("calibration_accepted", "operator token accepted the calibration of cam0"),
        ("calibration_restored", "operator token restored the previous calibration"),
        ("calibration_restored", "operator token restored the previous calibration"),
    ]


async def test_a_discarded_proposal_changes_nothing(operator: httpx.AsyncClient, client: redis.asyncio.Redis) -> None:
    await put(client, keys.CALIBRATIONS, CURRENT, encode(calibration(1)))
    proposed = await propose(client, operator)
    assert (await operator.post("/api/calibration/discard", json={"id": proposed})).status_code == 204
    now = await state(operator)
    assert now["proposal"] is None
    assert now["previous"] is None
    assert now["current"] == calibration(1).model_dump(mode="json")
    assert now["run"]["state"] == "discarded"


@pytest.mark.parametrize("decision", ["accept", "discard"])
async def test_only_what_was_looked_at_can_be_decided(
    operator: httpx.AsyncClient, client: redis.asyncio.Redis, decision: str
) -> None:
    nothing = await operator.post(f"/api/calibration/{decision}", json={"id": 5})
    assert nothing.status_code == 409
    assert nothing.json()["detail"] == "no calibration is proposed; start one"
    proposed = await propose(client, operator)
    other = await operator.post(f"/api/calibration/{decision}", json={"id": proposed - 1})
    assert other.status_code == 409
    assert "another calibration is proposed by now" in other.json()["detail"]
    assert (await state(operator))["proposal"] is not None


async def test_there_is_nothing_to_restore_at_first(operator: httpx.AsyncClient) -> None:
    answer = await operator.post("/api/calibration/restore")
    assert answer.status_code == 409
    assert answer.json()["detail"] == "there is no previous calibration to restore"


@pytest.mark.parametrize(
    ("changed", "says"),
    [({"floor": "f"}, "rests on other floor tags"), ({"lens": "b"}, "rests on another description of cam0")],
)
async def test_what_rests_on_another_lab_description_pushes_out_nothing(
    operator: httpx.AsyncClient, client: redis.asyncio.Redis, changed: dict[str, str], says: str
) -> None:
    await put(client, keys.CALIBRATIONS, CURRENT, encode(calibration(2)))
    await put(
        client,
        keys.CALIBRATIONS,
        PREVIOUS,
        encode(calibration(1, floor=changed.get("floor"), lens=changed.get("lens"))),
    )
    restored = await operator.post("/api/calibration/restore")
    assert restored.status_code == 409
    assert says in restored.json()["detail"]
    assert (await state(operator))["current"]["id"] == 2


async def test_a_proposal_from_before_the_lab_file_changed_is_not_accepted(
    operator: httpx.AsyncClient, client: redis.asyncio.Redis
) -> None:
    await put(client, keys.CALIBRATIONS, CURRENT, encode(calibration(1)))
    proposed = await propose(client, operator, floor="f")
    answer = await operator.post("/api/calibration/accept", json={"id": proposed})
    assert answer.status_code == 409
    assert "the proposed calibration rests on other floor tags" in answer.json()["detail"]
    now = await state(operator)
    assert now["current"]["id"] == 1
    assert now["proposal"] is not None


async def test_a_new_start_replaces_a_proposal_that_waits(
    operator: httpx.AsyncClient, client: redis.asyncio.Redis
) -> None:
    await propose(client, operator)
    assert (await operator.post("/api/calibration", json={})).status_code == 201
    assert (await state(operator))["proposal"] is None


async def test_a_damaged_record_does_not_stand_in_the_way(
    operator: httpx.AsyncClient, client: redis.asyncio.Redis
) -> None:
    await put(client, keys.CALIBRATIONS, CURRENT, b"{")
    await put(client, keys.live(CALIBRATION_RUNS.name), LAB_INSTANCE, b"{")
    proposed = await propose(client, operator)
    assert (await operator.post("/api/calibration/accept", json={"id": proposed})).status_code == 200
    assert (await state(operator))["current"]["id"] == proposed


async def test_viewers_look_and_robots_do_not(service: Service) -> None:
    viewer, robot = service.http("viewer"), service.http("robot")
    assert (await viewer.get("/api/calibration")).status_code == 200
    assert (await viewer.post("/api/calibration", json={})).status_code == 403
    for decision in ("accept", "discard"):
        assert (await viewer.post(f"/api/calibration/{decision}", json={"id": 1})).status_code == 403
    assert (await viewer.post("/api/calibration/restore")).status_code == 403
    assert (await robot.get("/api/calibration")).status_code == 403
    assert (await service.http(None).get("/api/calibration")).status_code == 401
