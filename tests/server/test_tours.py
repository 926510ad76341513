"""The tours of a lab's first start: ordinary routes that the simulated vehicles drive, made once."""

import pytest
import redis.asyncio

from protocol.clock import SystemClock
from protocol.errors import LabFileError
from protocol.lab import load_lab, parse_lab
from server.repositories.assignments import AssignmentRepository
from server.repositories.documents import Store
from server.repositories.plan import RouteRepository, WaypointRepository
from server.tours import start_tours
from tests.server.service import ROBOT, ROOT, in_process

GULLIVER = ROOT / "labs" / "gulliver.yaml"


async def test_every_simulated_vehicle_drives_its_loop_and_a_second_start_changes_nothing(redis_url: str) -> None:
    lab = load_lab(GULLIVER)
    async with redis.asyncio.Redis.from_url(redis_url) as client:
        assert await start_tours(client, lab) == ["wifibot-14", "wifibot-15", "turtlebot-16", "turtlebot-17"]
        store, clock = Store(client), SystemClock()
        routes, assignments = RouteRepository(store, clock), AssignmentRepository(store, clock)
        before = await routes.all(), await WaypointRepository(store, lab, clock).all(), await assignments.all()
        assert {a.robot: a.route for a in before[2].values()} == {v.id: f"tour-{v.id}" for v in lab.vehicles}
        assert all(route.loop and len(route.legs) == 4 for route in before[0].values())
        assert await start_tours(client, lab) == []
        after = await routes.all(), await WaypointRepository(store, lab, clock).all(), await assignments.all()
        assert after == before


async def test_a_tour_is_in_nobodys_way(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        await start_tours(service.context.bus.redis, service.context.lab)
        operator, address = service.http("operator"), f"/api/robots/{ROBOT}/assignment"
        await operator.post(f"{address}/pause")
        await operator.post("/api/waypoints", json={"id": "a", "area": "camp", "x": 1, "y": 1})
        await operator.post("/api/routes", json={"id": "r", "legs": [{"waypoint": "a"}]})
        started = await operator.put(address, json={"route": "r"})
        assert started.status_code == 200, started.text
        assert (started.json()["route"], started.json()["started_by"]) == ("r", "operator token")
        said = (await operator.get("/api/events")).json()[-1]["text"]
        assert said == f"operator token started route r on {ROBOT}, in place of tour-{ROBOT}"
        again = await operator.put(address, json={"route": f"tour-{ROBOT}"})
        assert (again.status_code, again.json()["detail"]) == (409, f"{ROBOT} has route 'r' (running); stop it first")


async def test_no_tour_begins_while_the_emergency_stop_is_engaged_and_none_is_left_half_made(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        client, lab, operator = service.context.bus.redis, service.context.lab, service.http("operator")
        await operator.post("/api/estop", json={})
        assert await start_tours(client, lab) == []
        assert (await operator.get("/api/waypoints")).json() == []
        await operator.request("DELETE", "/api/estop", json={"confirm": True})
        assert len(await start_tours(client, lab)) == 4


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("wifibot-14: [[3.3, 0.9]", "wifibot-99: [[3.3, 0.9]", "wifibot-99.*no simulated vehicle"),
        ("wifibot-14: [[3.3, 0.9]", "wifibot-14: [[33.0, 0.9]", r"\(33, 0.9\) lies outside every area"),
    ],
)
def test_a_tour_that_cannot_be_driven_is_refused_with_its_line(old: str, new: str, message: str) -> None:
    text = GULLIVER.read_text()
    assert old in text
    line = text[: text.index(old)].count("\n") + 1
    with pytest.raises(LabFileError, match=message) as caught:
        parse_lab(text.replace(old, new))
    assert {problem.line for problem in caught.value.problems} == {line}
