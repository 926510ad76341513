"""Accounts as programs beside the service make them, and manual drive's lease."""

import subprocess
import sys
from collections.abc import AsyncGenerator

import pytest
import redis.asyncio

from protocol.channels import MANUAL
from protocol.clock import SimulatedClock
from protocol.codec import decode
from protocol.messages import ManualDrive
from server import auth
from server.auth import Role
from server.auth.passwords import Passwords
from server.errors import ConflictError, NotFoundError
from server.repositories.documents import Store
from server.repositories.manual import ManualDriveRepository
from server.repositories.tokens import TokenRepository
from tests.server.service import ROBOT, ROOT, gulliver, in_process


@pytest.fixture
async def client(redis_url: str) -> AsyncGenerator[redis.asyncio.Redis]:
    async with redis.asyncio.Redis.from_url(redis_url) as client:
        yield client


async def test_the_first_administrator_logs_in(client: redis.asyncio.Redis, redis_url: str) -> None:
    password = await auth.bootstrap(client)
    assert password is not None
    assert len(password) >= 20
    assert await auth.bootstrap(client) is None
    assert [(user.name, user.role) for user in await auth.list_users(client)] == [("admin", Role.ADMIN)]
    stored = str(await client.hgetall("lilliput:users"))  # type: ignore[misc]
    assert "$argon2id$" in stored
    assert password not in stored
    async with in_process(redis_url) as service:
        answer = await service.http().post("/api/session", json={"user": "admin", "password": password})
        assert answer.json()["role"] == "admin"


async def test_users(client: redis.asyncio.Redis) -> None:
    await auth.create_user(client, "eva", "operator", "long enough")
    with pytest.raises(ConflictError, match="exists already"):
        await auth.create_user(client, "eva", "viewer", "long enough")
    for name, role, password in (
        ("", "viewer", "long enough"),
        ("x y", "viewer", "long enough"),
        ("r2", "robot", "long enough"),
        ("x", "king", "long enough"),
        ("x", "viewer", "short"),
    ):
        with pytest.raises(ValueError, match=r".+"):
            await auth.create_user(client, name, role, password)
    await auth.set_password(client, "eva", "another one")
    with pytest.raises(NotFoundError):
        await auth.set_password(client, "adam", "another one")
    await auth.delete_user(client, "eva")
    assert await auth.list_users(client) == []


async def test_tokens(client: redis.asyncio.Redis) -> None:
    tokens = TokenRepository(Store(client), SimulatedClock())
    first = await auth.issue_token(client, "agent x", "robot", ROBOT)
    with pytest.raises(ConflictError):
        await auth.issue_token(client, "agent x", "robot", ROBOT)
    second = await auth.issue_token(client, "agent x", "robot", ROBOT, replace=True)
    assert await tokens.find(first) is None
    found = await tokens.find(second)
    assert found is not None
    assert (found.role, found.robot) == (Role.ROBOT, ROBOT)
    assert [token.name for token in await auth.list_tokens(client)] == ["agent x"]
    await auth.revoke_token(client, "agent x")
    assert await tokens.find(second) is None
    with pytest.raises(NotFoundError):
        await auth.revoke_token(client, "agent x")
    for role, robot in (("robot", None), ("viewer", ROBOT)):
        with pytest.raises(ValueError, match="robot"):
            await auth.issue_token(client, "y", role, robot)


async def test_a_use_does_not_revive_a_revoked_token(client: redis.asyncio.Redis) -> None:
    clock = SimulatedClock()
    tokens = TokenRepository(Store(client), clock)
    token, record = await tokens.issue("x", Role.VIEWER, None, "test")
    assert await tokens.find(token) is not None
    ((_, used_ns),) = await tokens.all()
    assert used_ns == clock.now_ns()
    await clock.advance(30)
    await tokens.find(token)
    assert (await tokens.all())[0][1] == used_ns
    await clock.advance(31)
    await tokens.find(token)
    assert (await tokens.all())[0][1] == clock.now_ns()
    await tokens.revoke(record.id, "test")
    assert await tokens.find(token) is None
    assert await tokens.all() == []


async def test_damaged_hashes_fit_no_password() -> None:
    assert not await Passwords().verify("not a hash", "x")


def test_it_is_cheap_to_import() -> None:
    code = "import sys, server.auth; sys.exit(any(name in sys.modules for name in ('fastapi', 'uvicorn', 'httpx', 'numpy')))"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)


async def test_one_hand_at_a_time_on_the_stick(client: redis.asyncio.Redis) -> None:
    clock = SimulatedClock()
    manual, vehicle = ManualDriveRepository(Store(client), clock), gulliver().vehicle(ROBOT)
    drive = await manual.drive(vehicle, 0.2, -0.3, "eva", "eva")
    assert (drive.linear_mps, drive.angular_radps) == (0.2, -0.3)
    assert drive.expires_ns == clock.now_ns() + 500_000_000
    with pytest.raises(ConflictError, match=r"drives .* by hand"):
        await manual.drive(vehicle, 0.0, 0.0, "adam", "adam")
    with pytest.raises(ConflictError, match=r"drives .* by hand"):
        await manual.release(ROBOT, "adam", "adam")
    await clock.advance(0.4)
    await manual.drive(vehicle, 0.2, 0.0, "eva", "eva")
    await clock.advance(0.4)
    with pytest.raises(ConflictError):
        await manual.drive(vehicle, 0.0, 0.0, "adam", "adam")
    await clock.advance(0.2)
    await manual.drive(vehicle, 0.1, 0.0, "adam", "adam")
    await manual.release(ROBOT, "adam", "adam")
    await manual.release(ROBOT, "eva", "eva")
    await manual.drive(vehicle, 0.1, 0.0, "eva", "eva")
    stored = decode(ManualDrive, await client.hget(f"lilliput:live:{MANUAL.name}", ROBOT))  # type: ignore[misc,arg-type]
    assert stored.holder == "eva"
    events = str(await client.xrange("lilliput:stream:events"))
    assert events.count("manual_taken") == 3
    assert events.count("manual_released") == 1


@pytest.mark.parametrize(("asked", "applied"), [((9.0, 9.0), (0.8, 1.0)), ((-9.0, -9.0), (-0.8, -1.0))])
async def test_the_stick_is_clipped_to_what_the_robot_can(
    client: redis.asyncio.Redis, asked: tuple[float, float], applied: tuple[float, float]
) -> None:
    drive = await ManualDriveRepository(Store(client), SimulatedClock()).drive(
        gulliver().vehicle(ROBOT), *asked, "h", "h"
    )
    assert (drive.linear_mps, drive.angular_radps) == applied


async def test_sticks_through_the_api(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        path = f"/api/robots/{ROBOT}/manual"
        operator, admin = service.http("operator"), service.http("admin")
        assert (await operator.put(path, json={"linear_mps": 5, "angular_radps": 0})).json()["linear_mps"] == 0.8
        assert (await admin.put(path, json={"linear_mps": 0, "angular_radps": 0})).status_code == 409
        assert (await admin.delete(path)).status_code == 409
        assert (await operator.delete(path)).status_code == 204
        assert (await admin.put(path, json={"linear_mps": 0, "angular_radps": 0})).status_code == 200
        headers = {"Content-Type": "application/json"}
        bad = await admin.put(path, content='{"linear_mps": NaN, "angular_radps": 0}', headers=headers)
        assert bad.status_code == 422
        assert (
            await admin.put("/api/robots/nobody/manual", json={"linear_mps": 0, "angular_radps": 0})
        ).status_code == 404


async def test_two_tabs_of_one_login_do_not_share_the_stick(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        operator, address = service.http("operator"), f"/api/robots/{ROBOT}/manual"
        twist = {"linear_mps": 0.1, "angular_radps": 0}
        one, other = {"X-Lilliput-Tab": "tab-1"}, {"X-Lilliput-Tab": "tab-2"}
        assert (await operator.put(address, json=twist, headers=one)).status_code == 200
        assert (await operator.put(address, json=twist, headers=one)).status_code == 200
        assert (await operator.put(address, json=twist, headers=other)).status_code == 409
        assert (await operator.put(address, json=twist)).status_code == 409
        assert (await operator.delete(address, headers=other)).status_code == 409
        assert (await operator.delete(address, headers=one)).status_code == 204
        assert (await operator.put(address, json=twist, headers=other)).status_code == 200
        assert (await operator.put(address, json=twist, headers={"X-Lilliput-Tab": "a/b"})).status_code == 422


async def test_streams_that_ask_again_and_again_learn_of_a_revocation_within_two_seconds(
    client: redis.asyncio.Redis,
) -> None:
    """And one look into Redis is enough for all of them until then."""

    clock = SimulatedClock()
    tokens = TokenRepository(Store(client), clock)
    token, record = await tokens.issue("agent x", Role.ROBOT, "wifibot-14", "test")
    assert await tokens.stands(token)
    assert not await tokens.stands("nonsense")
    await tokens.revoke(record.id, "test")
    assert await tokens.stands(token)
    await clock.advance(2.0)
    assert not await tokens.stands(token)
