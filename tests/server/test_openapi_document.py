"""The OpenAPI document: complete, stable, and true: schemathesis holds the service to it."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import anyio.from_thread
import httpx
import jsonschema_rs
import pytest
import redis
import schemathesis
from hypothesis import HealthCheck, Phase, settings
from schemathesis import GenerationMode
from schemathesis.checks import CHECKS, load_all_checks
from schemathesis.specs.openapi.checks import positive_data_acceptance, response_schema_conformance

from protocol import keys
from protocol.channels import EMERGENCY_STOP, MANUAL, REGISTRATIONS
from server.openapi import document
from tests.redis_fixture import RedisServer
from tests.server.service import ROBOT, served

DOCUMENT = document()
OPERATIONS = [
    (method, path, operation) for path, methods in DOCUMENT["paths"].items() for method, operation in methods.items()
]


OPERATIONS_BY_PATH = [
    (re.compile(re.sub(r"\{\w+\}", "[^/]+", path)), method, operation) for method, path, operation in OPERATIONS
]


def test_every_operation_is_described() -> None:
    ids = [operation["operationId"] for _, _, operation in OPERATIONS]
    assert len(ids) == len(set(ids))
    for method, path, operation in OPERATIONS:
        where = f"{method} {path}"
        assert operation.get("summary"), where
        assert operation.get("description"), where
        assert operation.get("tags"), where
        if path == "/api/health":
            assert "security" not in operation
            continue
        assert {"401", "503"} <= operation["responses"].keys(), where
        if operation["operationId"] != "log_in":
            assert operation["security"], where
            assert "403" in operation["responses"], where
        for code in ("401", "403", "404", "409", "429", "503"):
            if code in operation["responses"]:
                schema = operation["responses"][code]["content"]["application/json"]["schema"]
                assert schema == {"$ref": "#/components/schemas/Problem"}, f"{where} {code}"


def test_every_body_and_answer_is_typed() -> None:
    for method, path, operation in OPERATIONS:
        for code, answer in operation["responses"].items():
            for media, content in answer.get("content", {}).items():
                assert content.get("schema"), f"{method} {path} {code} {media}"


def test_every_body_has_an_example_that_it_accepts() -> None:
    bodies = [(f"{method} {path}", op["requestBody"]) for method, path, op in OPERATIONS if "requestBody" in op]
    assert len(bodies) > 10
    for where, body in bodies:
        schema = body["content"]["application/json"]["schema"]
        examples = DOCUMENT["components"]["schemas"][schema["$ref"].rsplit("/", 1)[1]].get("examples")
        assert examples, where
        for example in examples:
            jsonschema_rs.validate({**schema, "components": DOCUMENT["components"]}, example)


def test_references_resolve() -> None:
    schemas = DOCUMENT["components"]["schemas"]

    def walk(node: Any) -> None:
        if isinstance(node, dict):
            reference = node.get("$ref")
            if isinstance(reference, str):
                assert reference.removeprefix("#/components/schemas/") in schemas, reference
            for value in node.values():
                walk(value)
        elif isinstance(node, list):
            for value in node:
                walk(value)

    walk(DOCUMENT)


load_all_checks()
SCHEMA = schemathesis.openapi.from_dict(DOCUMENT)
SCHEMA.config.generation.update(modes=[GenerationMode.POSITIVE, GenerationMode.NEGATIVE])
DURABLE = (
    keys.WAYPOINTS,
    keys.ROUTES,
    keys.ASSIGNMENTS,
    keys.ROBOT_SETTINGS,
    keys.SPEED_ZONES,
    keys.CALIBRATIONS,
    keys.CALIBRATION_PROPOSALS,
    keys.SIMULATED_OBJECTS,
    keys.SIMULATED_FAULTS,
    keys.USERS,
    keys.TOKENS,
    keys.live(EMERGENCY_STOP.name),
    keys.live(MANUAL.name),
    keys.live(REGISTRATIONS.name),
)


@dataclass(frozen=True)
class Base:
    """A service that runs in a thread of its own for all examples."""

    url: str
    tokens: dict[str, str]
    redis: redis.Redis

    def state(self) -> list[dict[bytes, bytes]]:
        """All that requests may change."""
        pipeline = self.redis.pipeline(transaction=False)
        for key in DURABLE:
            pipeline.hgetall(key)
        return pipeline.execute()


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Base]:
    server = RedisServer(tmp_path_factory.mktemp("redis"))
    server.start()
    try:
        with (
            redis.Redis.from_url(server.url) as client,
            anyio.from_thread.start_blocking_portal() as portal,
            portal.wrap_async_context_manager(served(server.url)) as (service, _),
        ):
            yield Base(service.base_url, service.tokens, client)
    finally:
        server.kill()


def _valid_data_is_accepted(context: Any, response: Any, case: Any) -> bool | None:
    """schemathesis' own check, but for what the document says in words alone: a rule of ours (no such waypoint, outside of its
    area, ...), refused with its sentence."""
    if response.status_code == 422 and {item["type"] for item in response.json()["detail"]} == {"value_error"}:
        return None
    return positive_data_acceptance(context, response, case)


def _checks() -> list[Any]:
    """All that there are."""
    return [*(check for check in CHECKS.get_all() if check is not positive_data_acceptance), _valid_data_is_accepted]


@SCHEMA.exclude(operation_id="stream_commands").parametrize()  # pyright: ignore[reportUntypedFunctionDecorator]  # as schemathesis types it
@settings(
    max_examples=8,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.function_scoped_fixture],
    deadline=None,
    derandomize=True,
    database=None,
)
def test_the_service_keeps_to_its_document(case: schemathesis.Case[Any], base: Base) -> None:
    """Valid and invalid requests, every check of schemathesis; what is refused has changed nothing."""
    robots_own = "robot's side" in (case.operation.tags or [])
    meta = case.meta
    if "robot_id" in case.path_parameters and meta is not None and meta.generation.mode.is_positive:
        case.path_parameters["robot_id"] = ROBOT
    token = base.tokens["robot" if robots_own else "admin"]
    # Made-up credentials beside the right ones would be neither a right request nor a wrong one.
    case.cookies.clear()
    case.headers.pop("Authorization", None)
    checks = _checks()
    if case.operation.path.startswith(("/api/sim/objects", "/api/speed-zones")):
        # schemathesis 4.32 rewrites prefixItems of request bodies in place, and then cannot read the answer's schema.
        checks.remove(response_schema_conformance)
    before = base.state()
    response = case.call(base_url=base.url, headers={"Authorization": f"Bearer {token}"})
    after = base.state()
    case.validate_response(response, checks=checks, headers={"Authorization": f"Bearer {token}"})
    if response.status_code >= 400:
        assert after == before, "a refused request changed something"


@pytest.mark.parametrize(
    "path", ["/api/session", "/api/robots/wifibot-14/manual", "/api/calibration/accept", "/api/estop"]
)
def test_a_method_that_an_address_does_not_take_is_told_all_that_it_does(base: Base, path: str) -> None:
    expected = {method.upper() for where, method, _ in OPERATIONS_BY_PATH if where.fullmatch(path)}
    for method in {"GET", "POST", "PUT", "DELETE", "PATCH", "OPTIONS"} - expected:
        answer = httpx.request(method, base.url + path)
        assert answer.status_code == 405, method
        assert set(answer.headers["Allow"].split(", ")) == expected
