"""Redis users of GPSS robots: what each may do, and keeping Redis to it.

A robot reads its own four documents, writes and publishes its status and its response, and hears its own topics. Everything
else is refused: other keys, KEYS, SCAN, CONFIG, EVAL, FLUSHALL, other topics. Redis 6 knows no write-only keys, so writing is
allowed by the command's first argument.
"""

import logging
import re
from typing import Any

import redis.asyncio
from redis.exceptions import RedisError, ResponseError

from protocol.clock import Clock, SystemClock
from protocol.gpss import READ, WRITTEN, key, user_name
from server.repositories.documents import Store
from server.repositories.redis_users import REDIS_USERS, RedisUserRecord, RedisUserRepository

_USER = re.compile(r"^gpss-(?P<robot>[a-z0-9][a-z0-9_-]{0,31})$")
_ACTOR = "launcher"
_logger = logging.getLogger(__name__)


def rules(robot: str) -> list[str]:
    """The rules of that robot's user, without its password."""
    documents = [key(robot, name) for name in (*READ, *WRITTEN)]
    written = [key(robot, name) for name in WRITTEN]
    return [
        "-@all",
        "+ping",
        "+get",
        "+subscribe",
        "+unsubscribe",
        "+client|setname",
        *(f"+{command}|{document}" for command in ("set", "publish") for document in written),
        "resetkeys",
        *(f"~{document}" for document in documents),
        "resetchannels",
        *(f"&{document}" for document in documents),
    ]


async def apply(client: redis.asyncio.Redis, record: RedisUserRecord) -> None:
    """Makes Redis' user be what the record says, whatever it was."""
    name = user_name(record.robot)
    await _execute(client, "ACL", "SETUSER", name, "reset", "on", f"#{record.password_sha256}", *rules(record.robot))


async def synchronize(client: redis.asyncio.Redis, records: dict[str, RedisUserRecord]) -> None:
    """Makes Redis' users of robots be those of the records, no more and no less. Others' users are left alone.

    What Redis refuses of one record keeps no other robot out; it is logged."""
    for name in await _execute(client, "ACL", "USERS"):
        found = _USER.match(name.decode(errors="replace"))
        if found is not None and found["robot"] not in records:
            await _execute(client, "ACL", "DELUSER", name)
    for robot, record in records.items():
        if record.robot != robot:
            _logger.warning("%s: %s is damaged: it is of %s", REDIS_USERS.key, robot, record.robot)
            continue
        try:
            await apply(client, record)
        except ResponseError as error:
            _logger.warning("Redis refuses the user of %s: %s", robot, error)


async def issue_redis_user(
    client: redis.asyncio.Redis, robot: str, *, replace: bool = False, clock: Clock | None = None
) -> tuple[str, str]:
    """Name and password of a robot's Redis user, the latter shown nowhere else. ConflictError when it has one already, unless
    that is to be replaced; whoever is logged in with the old password is thrown out."""
    repository = RedisUserRepository(Store(client), clock or SystemClock())
    password, record = await repository.issue(robot, _ACTOR, replace=replace)
    await _execute(client, "ACL", "DELUSER", user_name(robot))  # ends its connections
    await apply(client, record)
    return user_name(robot), password


async def revoke_redis_user(client: redis.asyncio.Redis, robot: str, clock: Clock | None = None) -> None:
    """Ends the user and its connections. NotFoundError when the robot has none."""
    await RedisUserRepository(Store(client), clock or SystemClock()).revoke(robot, _ACTOR)
    await _execute(client, "ACL", "DELUSER", user_name(robot))


class RedisAccess:
    """Keeps Redis' users in step with the records; a Redis that was started again has forgotten them."""

    def __init__(self, client: redis.asyncio.Redis, clock: Clock) -> None:
        self._redis = client
        self._repository = RedisUserRepository(Store(client), clock)
        self._known: tuple[str, dict[str, RedisUserRecord]] | None = None

    async def keep(self) -> None:
        """Looks once, and makes right what is not. RedisError while Redis is out of reach."""
        try:
            run: Any = (await self._redis.info("server"))["run_id"]
            records = await self._repository.all()
            if self._known != (run, records):
                await synchronize(self._redis, records)
                self._known = run, records
        except (RedisError, OSError):
            self._known = None
            raise


async def _execute(client: redis.asyncio.Redis, *words: str | bytes) -> Any:
    return await client.execute_command(*words)  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
