"""A whole system with its own Redis, in this process: what it makes at the start, and that its end always comes."""

import asyncio
import socket
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
import redis.asyncio

from launcher.accounts import ServerAccounts
from launcher.environment import SystemSettings
from launcher.errors import LauncherError
from launcher.paths import DEFAULT_LAB
from launcher.processes import ProcessKind, expand, select
from launcher.redis_server import redis_url, socket_path
from launcher.system import Accounts, System, Terminal
from protocol.lab import load_lab
from server.auth import Role, list_tokens, list_users


class Screen:
    """What a person sees."""

    def __init__(self) -> None:
        self.steps: list[str] = []
        self.results: list[str] = []
        self._more = asyncio.Event()

    def terminal(self) -> Terminal:
        def step(line: str) -> None:
            self.steps.append(line)
            self._more.set()

        return Terminal(step, self.results.append)

    async def until(self, beginning: str) -> None:
        """Returns when a step begins like this."""
        while not any(step.startswith(beginning) for step in self.steps):
            self._more.clear()
            await self._more.wait()


@pytest.fixture
def settings(tmp_path: Path) -> SystemSettings:
    return SystemSettings(
        lab=DEFAULT_LAB,
        state=tmp_path,
        redis_url="",
        host="127.0.0.1",
        http_port=1,
        server_url="http://127.0.0.1:1",
        udp_key="ab" * 32,
    )


@pytest.fixture
def screen() -> Screen:
    return Screen()


def system(
    names: set[str], settings: SystemSettings, accounts: Callable[[SystemSettings], Accounts], screen: Screen
) -> System:
    return System(select(expand(load_lab(DEFAULT_LAB)), names), settings, accounts, screen.terminal())


async def test_accounts_are_made_once_and_tokens_anew(settings: SystemSettings, screen: Screen) -> None:
    """Straight against the accounts, with nothing but Redis running."""
    only_redis = system({"redis"}, settings, ServerAccounts, screen)
    task = asyncio.create_task(only_redis.run_until_stopped())
    async with asyncio.timeout(20), redis.asyncio.Redis.from_url(redis_url(socket_path(settings.state))) as client:
        while not await answers(client):
            pass
        accounts = ServerAccounts(replace(settings, redis_url=redis_url(socket_path(settings.state))))
        password = await accounts.ensure_admin()
        assert password is not None
        assert len(password) >= 16
        assert await accounts.ensure_admin() is None
        first = await accounts.robot_tokens(["wifibot-14", "wifibot-15"])
        second = await accounts.robot_tokens(["wifibot-14"])
        assert first["wifibot-14"] != second["wifibot-14"]
        tokens = await list_tokens(client)
        assert sorted((token.robot, token.role) for token in tokens) == [
            ("wifibot-14", Role.ROBOT),
            ("wifibot-15", Role.ROBOT),
        ]
        assert [user.role for user in await list_users(client)] == [Role.ADMIN]
    only_redis.stop()
    await task
    assert screen.steps[-1] == "ending everything"


async def test_the_end_comes_also_when_a_cancellation_is_lost(settings: SystemSettings, screen: Screen) -> None:
    called = asyncio.Event()

    class Stubborn:
        async def start_tours(self) -> list[str]:
            return []

        async def ensure_admin(self) -> str | None:
            return None

        async def robot_tokens(self, robots: Sequence[str]) -> dict[str, str]:
            called.set()
            try:
                await asyncio.Event().wait()
            except asyncio.CancelledError:
                await asyncio.Event().wait()
            return {}

    stubborn = system({"redis"}, settings, lambda settings: Stubborn(), screen)
    task = asyncio.create_task(stubborn.run_until_stopped())
    await asyncio.wait_for(called.wait(), 20)
    stubborn.stop()
    await asyncio.wait_for(task, 5.0)


async def test_a_start_that_fails_says_why_and_leaves_nothing(settings: SystemSettings, screen: Screen) -> None:
    class Refusing:
        async def start_tours(self) -> list[str]:
            return []

        async def ensure_admin(self) -> str | None:
            return None

        async def robot_tokens(self, robots: Sequence[str]) -> dict[str, str]:
            raise LauncherError("no tokens today")

    refusing = system({"redis"}, settings, lambda settings: Refusing(), screen)
    with pytest.raises(LauncherError, match="no tokens today"):
        await asyncio.wait_for(refusing.run_until_stopped(), 20)
    assert not socket_path(settings.state).exists()


async def test_the_first_password_is_told_once_even_when_the_start_fails(
    settings: SystemSettings, screen: Screen
) -> None:
    class Refusing(ServerAccounts):
        async def robot_tokens(self, robots: Sequence[str]) -> dict[str, str]:
            raise LauncherError("no tokens today")

    for _ in range(2):
        failing = system({"redis", "server"}, settings, Refusing, screen)
        with pytest.raises(LauncherError):
            await asyncio.wait_for(failing.run_until_stopped(), 20)
        assert len(screen.results) == 1
        assert screen.results[0].startswith("Log in as: admin, password ")


SERVER_CODE = """
import http.server, os, signal
signal.signal(signal.SIGTERM, lambda *_: os._exit(0))
http.server.HTTPServer(("127.0.0.1", int(os.environ["LILLIPUT_HTTP_PORT"])), http.server.BaseHTTPRequestHandler).serve_forever()
"""
AGENT_CODE = """
import os, time, urllib.error, urllib.request
try:
    urllib.request.urlopen(os.environ["LILLIPUT_SERVER"])
except urllib.error.HTTPError as error:
    print("WARNING the server answered", error.code, os.environ["LILLIPUT_TOKEN"][:9], flush=True)
time.sleep(600)
"""


async def test_the_console_is_announced_when_it_answers_and_the_others_find_it(
    settings: SystemSettings, screen: Screen
) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    table = [
        ProcessKind("redis", (), "", lambda lab: ("",)),
        ProcessKind("agent", ("-c", AGENT_CODE), "", lambda lab: ("wifibot-14",), needs_token=True),
        ProcessKind("server", ("-c", SERVER_CODE), "", lambda lab: ("",), starts_first=True),
    ]
    here = replace(settings, http_port=port, server_url=f"http://127.0.0.1:{port}")
    running = System(expand(load_lab(DEFAULT_LAB), table), here, ServerAccounts, screen.terminal())
    task = asyncio.create_task(running.run_until_stopped())
    await asyncio.wait_for(screen.until("agent-wifibot-14: "), 20)
    running.stop()
    await asyncio.wait_for(task, 5)
    assert "agent-wifibot-14: WARNING the server answered 501 lilliput_" in screen.steps
    assert screen.results[0] == f"Console:   http://127.0.0.1:{port}"
    assert screen.results[1].startswith("Log in as: admin, password ")
    assert not any("starting it again" in step for step in screen.steps)


async def answers(client: redis.asyncio.Redis) -> bool:
    try:
        return bool(await client.ping())  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
    except redis.asyncio.ConnectionError:
        await asyncio.sleep(0.01)
        return False
