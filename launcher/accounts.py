"""Users, tokens and first orders that a system needs at its start, made through the server's own functions."""

from collections.abc import AsyncGenerator, Sequence
from contextlib import asynccontextmanager

import redis.asyncio

from launcher.environment import SystemSettings
from protocol.lab import load_lab
from server.auth import Role, bootstrap, issue_token
from server.tours import start_tours


class ServerAccounts:
    """The first administrator and the robots' tokens of one system."""

    def __init__(self, settings: SystemSettings) -> None:
        self._settings = settings

    async def ensure_admin(self) -> str | None:
        """The new password of `admin` when there was no user yet, else None."""
        async with self._client() as client:
            return await bootstrap(client)

    async def start_tours(self) -> list[str]:
        """Sends the simulated vehicles on the lab's tours; which ones."""
        async with self._client() as client:
            return await start_tours(client, load_lab(self._settings.lab))

    async def robot_tokens(self, robots: Sequence[str]) -> dict[str, str]:
        """A fresh token for each robot; it makes the one of the start before void, so nothing need be kept."""
        async with self._client() as client:
            return {
                robot: await issue_token(client, f"agent {robot}", Role.ROBOT, robot, replace=True) for robot in robots
            }

    @asynccontextmanager
    async def _client(self) -> AsyncGenerator[redis.asyncio.Redis]:
        async with redis.asyncio.Redis.from_url(self._settings.redis_url) as client:
            yield client
