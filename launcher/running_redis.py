"""How commands reach what a running system keeps: its Redis, and the server's refusals in one line."""

import argparse
import asyncio
import os
from collections.abc import Awaitable, Callable
from typing import TypeVar

import redis.asyncio
from redis.exceptions import RedisError

from launcher.errors import LauncherError, UsageError
from launcher.lab_file import read_lab, state_folder
from launcher.redis_server import private_url, shown_url, socket_path
from server.errors import ServiceError

T = TypeVar("T")


def with_redis(arguments: argparse.Namespace, work: Callable[[redis.asyncio.Redis], Awaitable[T]]) -> T:
    """Does `work` on the Redis of REDIS_URL, else on the private one of the state folder; LauncherError when it is away,
    UsageError for what the server refuses."""
    url = os.environ.get("REDIS_URL")
    if not url:
        _, lab = read_lab(arguments.lab)
        state = state_folder(arguments.state, lab)
        if not socket_path(state).exists():
            raise LauncherError(f"no system runs on {state}: start `./lilliput up`, or name its folder with --state")
        url = private_url(state, opened=lab.ports.redis is not None)
    return asyncio.run(_work(url, work))


async def _work(url: str, work: Callable[[redis.asyncio.Redis], Awaitable[T]]) -> T:
    try:
        async with redis.asyncio.Redis.from_url(url, socket_timeout=5.0, socket_connect_timeout=5.0) as client:
            return await work(client)
    except (RedisError, OSError) as error:
        raise LauncherError(f"Redis at {shown_url(url)} does not answer: {error}") from error
    except (ServiceError, ValueError) as error:
        raise UsageError(str(error)) from error
