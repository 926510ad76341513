"""Who may do what: sessions, tokens, roles over every state-changing route, throttling, forged pages."""

from collections.abc import AsyncGenerator
from typing import Any

import httpx
import pytest
import redis

from protocol.clock import SimulatedClock
from server.app import assemble
from server.auth.throttle import LoginThrottle
from tests.redis_fixture import RedisServer
from tests.server.service import OTHER_ROBOT, PASSWORD, ROBOT, Service, in_process

WAYPOINT = {"id": "a", "area": "camp", "x": 1.0, "y": 1.0}
ROUTE = {"id": "round", "legs": [{"waypoint": "p"}]}
ZONE = {"id": "doorway", "outline": [[3.0, 1.0], [4.0, 1.0], [4.0, 2.0]], "speed_mps": 0.2}
PALLET = {"id": "pallet-1", "kind": "pallet", "x": 2.0, "y": 2.0}
RESPONSE = {
    "robot": ROBOT,
    "command_order": [1, 1],
    "command_stamp_ns": 1,
    "stamp_ns": 2,
    "outcome": "accepted",
    "movement": "MoveTo",
}
PEOPLE = ("viewer", "operator", "admin")
OPERATORS = ("operator", "admin")
Case = tuple[str, dict[str, Any] | None, tuple[str, ...]]

# Operation -> path, body, and who may. Everybody else of viewer, operator, admin, robot, other-robot may not.
CASES: dict[str, Case] = {
    "log_out": ("/session", None, (*PEOPLE, "robot", "other-robot")),
    "put_robot_settings": (f"/robots/{ROBOT}/settings", {"box_length_m": 2.0}, OPERATORS),
    "start_route": (f"/robots/{OTHER_ROBOT}/assignment", {"route": "circle"}, OPERATORS),
    "queue_route": (f"/robots/{ROBOT}/queue", {"route": "circle"}, OPERATORS),
    "dequeue_route": (f"/robots/{ROBOT}/queue/0123456789abcdef", None, OPERATORS),
    "empty_queue": (f"/robots/{ROBOT}/queue", None, OPERATORS),
    "skip_leg": (f"/robots/{ROBOT}/assignment/skip", None, OPERATORS),
    "proceed": (f"/robots/{ROBOT}/assignment/proceed", None, OPERATORS),
    "pause_route": (f"/robots/{ROBOT}/assignment/pause", None, OPERATORS),
    "resume_route": ("/robots/turtlebot-16/assignment/resume", None, OPERATORS),
    "cancel_route": ("/robots/turtlebot-16/assignment/cancel", None, OPERATORS),
    "stop_route": (f"/robots/{ROBOT}/assignment", None, OPERATORS),
    "drive_by_hand": (f"/robots/{ROBOT}/manual", {"linear_mps": 0.1, "angular_radps": 0.0}, OPERATORS),
    "let_go": (f"/robots/{ROBOT}/manual", None, OPERATORS),
    "register_robot": (f"/robots/{ROBOT}/registration", {"udp_port": 4000}, ("robot",)),
    "post_response": (f"/robots/{ROBOT}/responses", RESPONSE, ("robot",)),
    "create_waypoint": ("/waypoints", WAYPOINT, OPERATORS),
    "put_waypoint": ("/waypoints/p", {**WAYPOINT, "id": "p"}, OPERATORS),
    "delete_waypoint": ("/waypoints/lonely", None, OPERATORS),
    "create_route": ("/routes", ROUTE, OPERATORS),
    "put_route": ("/routes/other", {**ROUTE, "id": "other"}, OPERATORS),
    "delete_route": ("/routes/unused", None, OPERATORS),
    "create_speed_zone": ("/speed-zones", ZONE, OPERATORS),
    "put_speed_zone": ("/speed-zones/doorway", ZONE, OPERATORS),
    "delete_speed_zone": ("/speed-zones/doorway", None, OPERATORS),
    "engage_emergency_stop": ("/estop", {"reason": "test"}, (*OPERATORS, "robot", "other-robot")),
    "release_emergency_stop": ("/estop", {"confirm": True}, OPERATORS),
    "create_simulated_object": ("/sim/objects", PALLET, OPERATORS),
    "put_simulated_object": ("/sim/objects/crate", {**PALLET, "id": "crate"}, OPERATORS),
    "delete_simulated_object": ("/sim/objects/crate", None, OPERATORS),
    "put_camera_fault": ("/sim/cameras/cam1/fault", {"kind": "stall"}, OPERATORS),
    "delete_camera_fault": ("/sim/cameras/cam1/fault", None, OPERATORS),
    "start_calibration": ("/calibration", {"cameras": ["cam0"]}, OPERATORS),
    "accept_calibration": ("/calibration/accept", {"id": 5}, OPERATORS),
    "discard_calibration": ("/calibration/discard", {"id": 5}, OPERATORS),
    "restore_calibration": ("/calibration/restore", None, OPERATORS),
    "create_user": ("/users", {"name": "eva", "role": "viewer"}, ("admin",)),
    "change_user": ("/users/viewer", {"password": "another one"}, ("admin",)),
    "delete_user": ("/users/viewer", None, ("admin",)),
    "issue_token": ("/tokens", {"name": "script", "role": "operator"}, ("admin",)),
    "revoke_token": ("/tokens/000000000000", None, ("admin",)),
}
UNPROTECTED = {"log_in"}
REFUSED_FOR_OTHER_REASONS = {
    "revoke_token": 404,
    "dequeue_route": 404,
    "proceed": 409,
    "accept_calibration": 409,
    "discard_calibration": 409,
    "restore_calibration": 409,
}
"""What the case names does not exist, or is not so."""


def state_changing() -> dict[str, tuple[str, str]]:
    """Operation id -> method and path template of every route that is not a GET."""
    paths: dict[str, dict[str, Any]] = assemble().openapi()["paths"]
    return {
        operation["operationId"]: (method.upper(), path)
        for path, methods in paths.items()
        for method, operation in methods.items()
        if method != "get"
    }


@pytest.fixture
async def service(redis_url: str) -> AsyncGenerator[Service]:
    async with in_process(redis_url) as service:
        operator = service.http("operator")
        for name, x in (("p", 1.0), ("q", 2.0), ("lonely", 3.0)):
            await _ok(operator.post("/api/waypoints", json={**WAYPOINT, "id": name, "x": x}))
        for name in ("circle", "other", "unused", "driven"):
            await _ok(operator.post("/api/routes", json={"id": name, "legs": [{"waypoint": "p"}, {"waypoint": "q"}]}))
        for robot in (ROBOT, "turtlebot-16"):
            await _ok(operator.put(f"/api/robots/{robot}/assignment", json={"route": "driven"}))
        await _ok(operator.post("/api/robots/turtlebot-16/assignment/pause"))
        await _ok(operator.post("/api/sim/objects", json={**PALLET, "id": "crate"}))
        await _ok(operator.put("/api/sim/cameras/cam1/fault", json={"kind": "stall"}))
        yield service


async def _ok(request: Any) -> httpx.Response:
    answer = await request
    assert answer.is_success, answer.text
    return answer


def dump(server: RedisServer) -> dict[bytes, Any]:
    """Everything that Redis holds, except when a token was last used."""
    with redis.Redis.from_url(server.url) as client:
        keys: list[bytes] = list(client.scan_iter())  # type: ignore[arg-type]
        kinds = {key: client.type(key) for key in keys}
        read = {b"hash": client.hgetall, b"string": client.get, b"stream": client.xrange}
        return {key: read[kind](key) for key, kind in kinds.items() if not key.endswith(b":used")}  # type: ignore[index]


def test_every_state_changing_route_is_covered() -> None:
    assert set(state_changing()) == CASES.keys() | UNPROTECTED


async def test_nobody_changes_anything_without_the_right(service: Service, redis_server: RedisServer) -> None:
    methods = state_changing()
    before = dump(redis_server)
    for operation, (path, body, allowed) in CASES.items():
        method = methods[operation][0]
        attempts: list[tuple[str, dict[str, str], int]] = [
            ("nobody", {}, 401),
            ("a wrong token", {"Authorization": "Bearer lilliput_wrong"}, 401),
            ("an empty token", {"Authorization": "Bearer "}, 401),
            ("a password as token", {"Authorization": "Basic YWRtaW46YWRtaW4="}, 401),
            ("a wrong cookie", {"Cookie": "lilliput_session=wrong", "X-Lilliput": "1"}, 401),
        ]
        attempts += [
            (who, {"Authorization": f"Bearer {token}"}, 403)
            for who, token in service.tokens.items()
            if who not in allowed
        ]
        for who, headers, expected in attempts:
            answer = await service.http().request(method, f"/api{path}", json=body, headers=headers)
            assert answer.status_code == expected, f"{operation} by {who}: {answer.status_code} {answer.text}"
            assert isinstance(answer.json()["detail"], str)
    assert dump(redis_server) == before


async def test_who_has_the_right_may(service: Service) -> None:
    methods = state_changing()
    for operation, (path, body, allowed) in CASES.items():
        answer = await service.http(allowed[0]).request(methods[operation][0], f"/api{path}", json=body)
        refused = REFUSED_FOR_OTHER_REASONS.get(operation)
        expected = (200, 201, 204) if refused is None else (refused,)
        assert answer.status_code in expected, f"{operation}: {answer.text}"


async def test_reading_needs_a_viewer(service: Service) -> None:
    paths: dict[str, dict[str, Any]] = assemble().openapi()["paths"]
    reads = [path for path, methods in paths.items() if "get" in methods and path not in ("/api/health",)]
    assert len(reads) > 10
    for path in reads:
        concrete = path.replace("{robot_id}", ROBOT).replace("{camera_id}", "cam0")
        answer = await service.http().get(concrete)
        assert answer.status_code == 401, path
        assert answer.headers["WWW-Authenticate"] == "Bearer"
        own = path in ("/api/session", "/api/estop", "/api/robots/{robot_id}/commands")
        if not own:
            assert (await service.http("robot").get(concrete)).status_code == 403, path
    assert (await service.http().get("/api/health")).status_code == 200
    assert (await service.http("other-robot").get(f"/api/robots/{ROBOT}/commands")).status_code == 403
    assert (await service.http("viewer").get("/api/users")).status_code == 403
    assert (await service.http("operator").get("/api/tokens")).status_code == 403


async def _log_in(service: Service, user: str, password: str = PASSWORD) -> httpx.AsyncClient:
    client = service.http()
    answer = await client.post("/api/session", json={"user": user, "password": password})
    assert answer.status_code == 200, answer.text
    return client


async def test_session_cookie(service: Service, redis_server: RedisServer) -> None:
    client = service.http()
    answer = await client.post("/api/session", json={"user": "operator", "password": PASSWORD})
    assert answer.json() == {"user": "operator", "role": "operator", "robot": None}
    cookie = answer.headers["set-cookie"].lower()
    assert all(part in cookie for part in ("httponly", "samesite=strict", "path=/", "max-age=43200"))
    secret = client.cookies["lilliput_session"]
    assert secret.encode() not in str(dump(redis_server)).encode()
    assert (await client.get("/api/session")).json()["user"] == "operator"
    with redis.Redis.from_url(redis_server.url) as stored:
        (key,) = stored.scan_iter("lilliput:session:*")
        assert 43_000 < stored.ttl(key) <= 43_200  # type: ignore[operator]
        stored.expire(key, 100)
        assert (await client.get("/api/lab")).status_code == 200
        assert stored.ttl(key) > 43_000  # type: ignore[operator]
    answer = await client.delete("/api/session", headers={"X-Lilliput": "1"})
    assert answer.status_code == 204
    assert (await service.http().get("/api/lab", headers={"Cookie": f"lilliput_session={secret}"})).status_code == 401


async def test_a_foreign_page_changes_nothing(service: Service) -> None:
    client = await _log_in(service, "operator")
    answer = await client.post("/api/waypoints", json=WAYPOINT)
    assert answer.status_code == 403
    assert "X-Lilliput" in answer.json()["detail"]
    answer = await client.post("/api/waypoints", json=WAYPOINT, headers={"X-Lilliput": "1"})
    assert answer.status_code == 201


async def test_sessions_end_with_the_password_and_the_user(service: Service) -> None:
    admin = service.http("admin")
    viewer = await _log_in(service, "viewer")
    await _ok(admin.put("/api/users/viewer", json={"role": "operator"}))
    assert (await viewer.get("/api/lab")).status_code == 401
    viewer = await _log_in(service, "viewer")
    await _ok(admin.put("/api/users/viewer", json={"password": "a new password"}))
    assert (await viewer.get("/api/lab")).status_code == 401
    viewer = await _log_in(service, "viewer", "a new password")
    await _ok(admin.delete("/api/users/viewer"))
    assert (await viewer.get("/api/lab")).status_code == 401


async def test_the_last_administrator_stays(service: Service) -> None:
    admin = service.http("admin")
    assert (await admin.delete("/api/users/admin")).status_code == 409
    assert (await admin.put("/api/users/admin", json={"role": "viewer"})).status_code == 409
    await _ok(admin.post("/api/users", json={"name": "eva", "role": "admin"}))
    await _ok(admin.delete("/api/users/admin"))
    assert [user["name"] for user in (await admin.get("/api/users")).json()] == ["eva", "operator", "viewer"]


async def test_users_get_a_password_once(service: Service) -> None:
    admin = service.http("admin")
    made = (await _ok(admin.post("/api/users", json={"name": "eva", "role": "viewer"}))).json()
    await _log_in(service, "eva", made["password"])
    assert "password" not in (await admin.get("/api/users")).text
    assert (await admin.post("/api/users", json={"name": "eva", "role": "viewer"})).status_code == 409
    refused = await admin.post("/api/users", json={"name": "r2", "role": "robot"})
    assert refused.status_code == 422


async def test_tokens(service: Service, redis_server: RedisServer) -> None:
    admin = service.http("admin")
    made = (await _ok(admin.post("/api/tokens", json={"name": "script", "role": "operator"}))).json()
    assert made["token"].encode() not in str(dump(redis_server)).encode()
    script = service.http()
    script.headers["Authorization"] = f"Bearer {made['token']}"
    await _ok(script.post("/api/waypoints", json=WAYPOINT))
    shown = {token["name"]: token for token in (await admin.get("/api/tokens")).json()}
    assert shown["script"]["last_used_ns"] > shown["script"]["created_ns"]
    assert "token" not in shown["script"]
    assert (await admin.post("/api/tokens", json={"name": "script", "role": "viewer"})).status_code == 409
    await _ok(admin.delete(f"/api/tokens/{made['id']}"))
    assert (await script.get("/api/lab")).status_code == 401
    assert "script" not in (await admin.get("/api/tokens")).text


@pytest.mark.parametrize(
    "body",
    [
        {"name": "x", "role": "robot"},
        {"name": "x", "role": "viewer", "robot": ROBOT},
        {"name": "x", "role": "robot", "robot": "nobody"},
        {"name": "", "role": "viewer"},
        {"name": "x", "role": "king"},
    ],
)
async def test_tokens_that_make_no_sense(service: Service, body: dict[str, Any]) -> None:
    assert (await service.http("admin").post("/api/tokens", json=body)).status_code == 422


async def test_wrong_passwords_are_slowed_down(service: Service) -> None:
    client = service.http()
    for user in ("operator", "operator", "operator", "operator", "operator"):
        answer = await client.post("/api/session", json={"user": user, "password": "wrong password"})
        assert answer.status_code == 401
    answer = await client.post("/api/session", json={"user": "operator", "password": PASSWORD})
    assert answer.status_code == 429
    assert 0 < int(answer.headers["Retry-After"]) <= 61
    await _log_in(service, "viewer")


async def test_unknown_users_look_like_wrong_passwords(service: Service) -> None:
    client = service.http()
    unknown = await client.post("/api/session", json={"user": "nobody", "password": PASSWORD})
    wrong = await client.post("/api/session", json={"user": "viewer", "password": "wrong password"})
    assert (unknown.status_code, unknown.json()) == (wrong.status_code, wrong.json()) == (401, unknown.json())


async def test_throttle_lets_go_after_a_minute() -> None:
    clock = SimulatedClock()
    throttle = LoginThrottle(clock)
    for _ in range(4):
        throttle.failed("eva", "10.0.0.1")
    assert throttle.wait_s("eva", "10.0.0.1") == 0
    throttle.failed("eva", "10.0.0.1")
    assert throttle.wait_s("eva", "10.0.0.1") == 60
    assert throttle.wait_s("eva", "10.0.0.2") == 0
    assert throttle.wait_s("adam", "10.0.0.1") == 0
    await clock.advance(60)
    assert throttle.wait_s("eva", "10.0.0.1") == 0
    throttle.succeeded("eva", "10.0.0.1")
    assert throttle.wait_s("eva", "10.0.0.1") == 0


async def test_throttle_bounds_an_address_that_tries_many_users() -> None:
    clock = SimulatedClock()
    throttle = LoginThrottle(clock)
    for number in range(30):
        assert throttle.wait_s(f"user{number}", "10.0.0.1") == 0
        throttle.failed(f"user{number}", "10.0.0.1")
    assert throttle.wait_s("eva", "10.0.0.1") > 0
    assert throttle.wait_s("eva", "10.0.0.2") == 0


async def test_throttle_forgets_when_it_holds_too_much() -> None:
    clock = SimulatedClock()
    throttle = LoginThrottle(clock)
    for number in range(12_000):
        throttle.failed(f"user{number}", f"10.{number // 65536}.{number // 256 % 256}.{number % 256}")
    for _ in range(5):
        throttle.failed("eva", "10.9.9.9")
    assert throttle.wait_s("eva", "10.9.9.9") > 0


async def test_strangers_learn_of_the_health_only_how_bad_it_is(service: Service) -> None:
    for who in (None, "robot"):
        told = (await service.http(who).get("/api/health")).json()
        assert told.keys() == {"state", "stamp_ns", "redis_reachable", "errors", "warnings"}
        assert (told["state"], told["redis_reachable"]) == ("error", True)
    shown = (await service.http("viewer").get("/api/health")).json()
    assert {"processes", "udp", "problems"} <= shown.keys()
    assert told["errors"] == sum(problem["severity"] == "error" for problem in shown["problems"])
    forged = await service.http().get("/api/health", headers={"Authorization": "Bearer x"})
    assert (forged.status_code, "processes" in forged.json()) == (200, False)
