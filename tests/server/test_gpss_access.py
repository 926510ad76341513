"""The Redis user of a GPSS robot: what it may do, and nothing else; it outlives Redis."""

import contextlib
from collections.abc import AsyncGenerator, Generator
from typing import Any

import pytest
import redis
import redis.asyncio
from redis import exceptions

from protocol import keys
from protocol.bus import Bus
from protocol.clock import SystemClock
from protocol.codec import decode
from protocol.gpss import READ, WRITTEN, key
from server.errors import ConflictError, NotFoundError
from server.gpss.access import RedisAccess, issue_redis_user, revoke_redis_user, synchronize
from server.repositories.redis_users import RedisUserRecord
from tests.redis_fixture import RedisServer

ROBOT, OTHER = "agv-1", "agv-10"
OWN = [key(ROBOT, name) for name in (*READ, *WRITTEN)]
FOREIGN = [key(OTHER, name) for name in (*READ, *WRITTEN)] + ["lilliput:users", "lilliput:live:emergency_stop", "x"]


@pytest.fixture
async def client(redis_url: str) -> AsyncGenerator[redis.asyncio.Redis]:
    bus = Bus.connect(redis_url)
    yield bus.redis
    await bus.close()


@contextlib.contextmanager
def logged_in(url: str, user: str, password: str) -> Generator[redis.Redis]:
    with redis.Redis.from_url(url, username=user, password=password) as robot:
        yield robot


async def issue(client: redis.asyncio.Redis, robot: str = ROBOT, **options: Any) -> tuple[str, str]:
    return await issue_redis_user(client, robot, **options)


async def test_a_robot_reads_its_documents_and_writes_what_it_says(client: redis.asyncio.Redis, redis_url: str) -> None:
    for name in READ:
        await client.set(key(ROBOT, name), b"{}")
    with logged_in(redis_url, *await issue(client)) as robot:
        assert [robot.get(key(ROBOT, name)) for name in READ] == [b"{}", b"{}"]
        for name in WRITTEN:
            assert robot.set(key(ROBOT, name), b"{}")
            assert robot.publish(key(ROBOT, name), b"{}") == 0
        assert robot.ping()
        with robot.pubsub() as ear:
            ear.subscribe(key(ROBOT, "command"))
            answer = ear.get_message(timeout=2.0)
            assert answer is not None
            assert answer["type"] == "subscribe"


FORBIDDEN: list[tuple[str, ...]] = [
    *(("GET", document) for document in FOREIGN),
    *(("SET", document, "x") for document in (*FOREIGN, *(key(ROBOT, name) for name in READ))),
    *(("PUBLISH", topic, "x") for topic in (*FOREIGN, *(key(ROBOT, name) for name in READ))),
    *(("DEL", document) for document in OWN),
    ("KEYS", "*"),
    ("SCAN", "0"),
    ("FLUSHALL",),
    ("FLUSHDB",),
    ("CONFIG", "GET", "*"),
    ("EVAL", "return 1", "0"),
    ("ACL", "LIST"),
    ("ACL", "SETUSER", "gpss-agv-1", "allkeys"),
    ("CLIENT", "LIST"),
    ("CLIENT", "KILL", "TYPE", "normal"),
    ("DEBUG", "SLEEP", "0"),
    ("SHUTDOWN",),
    ("MONITOR",),
    ("INFO",),
    ("HGETALL", "lilliput:tokens"),
    ("HSET", key(ROBOT, "status"), "a", "b"),
    ("EXPIRE", key(ROBOT, "command"), "1"),
    ("APPEND", key(ROBOT, "command"), "x"),
    ("GETSET", key(ROBOT, "status"), "x"),
    ("RENAME", key(ROBOT, "status"), key(ROBOT, "command")),
    ("PUBSUB", "CHANNELS"),
]


async def test_everything_else_is_refused(client: redis.asyncio.Redis, redis_url: str) -> None:
    await issue(client, OTHER)
    await client.set(key(OTHER, "command"), b"another's")
    before = await client.dbsize()
    with logged_in(redis_url, *await issue(client)) as robot:
        for words in FORBIDDEN:
            with pytest.raises(exceptions.NoPermissionError):
                robot.execute_command(*words)
                pytest.fail(f"{' '.join(words)} was let through")
        for topic in ("lilliput:topic:commands:agv-1", key(OTHER, "command"), "*"):
            with robot.pubsub() as ear, pytest.raises(exceptions.NoPermissionError):
                ear.subscribe(topic)
                ear.get_message(timeout=2.0)
        with robot.pubsub() as ear, pytest.raises(exceptions.NoPermissionError):
            ear.psubscribe("gpss:*")
            ear.get_message(timeout=2.0)
    assert await client.dbsize() == before
    assert await client.get(key(OTHER, "command")) == b"another's"


async def test_a_wrong_or_replaced_password_lets_nobody_in(client: redis.asyncio.Redis, redis_url: str) -> None:
    user, password = await issue(client)
    with logged_in(redis_url, user, "wrong") as stranger, pytest.raises(exceptions.AuthenticationError):
        stranger.ping()
    with pytest.raises(ConflictError, match="has a Redis user already"):
        await issue(client)
    with logged_in(redis_url, user, password) as old:
        assert old.ping()
        _, new_password = await issue(client, replace=True)
        with pytest.raises(exceptions.RedisError):
            old.ping()
    with logged_in(redis_url, user, new_password) as new:
        assert new.ping()
        await revoke_redis_user(client, ROBOT)
        with pytest.raises(exceptions.RedisError):
            new.ping()
    with pytest.raises(NotFoundError):
        await revoke_redis_user(client, ROBOT)


async def test_no_password_is_kept(client: redis.asyncio.Redis) -> None:
    _, password = await issue(client)
    kept = [await client.hgetall("lilliput:redis_users"), await client.execute_command("ACL", "LIST")]  # pyright: ignore[reportGeneralTypeIssues]
    assert password not in str(kept)


async def test_a_redis_that_was_started_again_is_told_its_users(
    client: redis.asyncio.Redis, redis_server: RedisServer
) -> None:
    user, password = await issue(client)
    await client.execute_command("ACL", "SETUSER", "somebody", "on", ">x")
    access = RedisAccess(client, SystemClock())
    await access.keep()
    redis_server.kill()
    with pytest.raises((exceptions.RedisError, OSError)):
        await access.keep()
    redis_server.start()
    with logged_in(redis_server.url, user, password) as robot, pytest.raises(exceptions.AuthenticationError):
        robot.ping()
    await access.keep()
    with logged_in(redis_server.url, user, password) as robot:
        assert robot.set(key(ROBOT, "status"), b"{}")
    await client.execute_command("ACL", "SETUSER", "gpss-gone", "on", ">x")
    await client.execute_command("ACL", "SETUSER", "somebody", "on", ">x")
    redis_server.kill()
    redis_server.start()
    await client.execute_command("ACL", "SETUSER", "gpss-gone", "on", ">x")
    await client.execute_command("ACL", "SETUSER", "somebody", "on", ">x")
    await access.keep()
    names: Any = await client.execute_command("ACL", "USERS")
    assert sorted(names) == [b"default", b"gpss-agv-1", b"somebody"]


async def test_a_damaged_record_keeps_no_other_robot_out(
    client: redis.asyncio.Redis, redis_url: str, caplog: pytest.LogCaptureFixture
) -> None:
    user, password = await issue(client)
    (raw,) = (await client.hgetall(keys.REDIS_USERS)).values()  # pyright: ignore[reportGeneralTypeIssues]
    record = decode(RedisUserRecord, raw)
    harms: dict[str, dict[str, str]] = {
        "agv-0": {"robot": "agv-0", "password_sha256": "no digest"},
        "agv-00": {"robot": "* ~lilliput:*"},
        "agv-01": {"robot": ROBOT, "password_sha256": "0" * 64},
    }
    for name, harm in harms.items():
        await client.hset(keys.REDIS_USERS, name, record.model_copy(update=harm).model_dump_json())  # pyright: ignore[reportGeneralTypeIssues]
    await client.execute_command("ACL", "DELUSER", user)
    await RedisAccess(client, SystemClock()).keep()
    with logged_in(redis_url, user, password) as robot:
        assert robot.ping()
    names: Any = await client.execute_command("ACL", "USERS")
    assert sorted(names) == [b"default", user.encode()]
    for name in harms:
        assert f"{name} is damaged" in caplog.text


async def test_what_redis_refuses_of_one_record_keeps_no_other_robot_out(
    client: redis.asyncio.Redis, redis_url: str, caplog: pytest.LogCaptureFixture
) -> None:
    user, password = await issue(client)
    (raw,) = (await client.hgetall(keys.REDIS_USERS)).values()  # pyright: ignore[reportGeneralTypeIssues]
    record = decode(RedisUserRecord, raw)
    refused = record.model_copy(update={"robot": "agv-0", "password_sha256": "no digest"})
    await client.execute_command("ACL", "DELUSER", user)
    await synchronize(client, {"agv-0": refused, ROBOT: record})
    assert "Redis refuses the user of agv-0" in caplog.text
    with logged_in(redis_url, user, password) as robot:
        assert robot.ping()
