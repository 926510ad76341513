"""The service under test: in this process, over a real Redis, with accounts of every role; with or without real sockets."""

import asyncio
import socket
import time
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import httpx
from argon2 import PasswordHasher
from fastapi import FastAPI

from protocol.bus import Bus
from protocol.clock import Clock, SystemClock
from protocol.lab import Lab, load_lab
from server.app import create_app
from server.auth.passwords import Passwords
from server.binding import datagrams
from server.configuration import Configuration
from server.context import Context
from server.going_on import for_ever
from server.intake.service import IntakeService
from server.repositories.documents import Store
from server.repositories.tokens import TokenRepository
from server.repositories.users import UserRepository
from server.roles import Role
from server.serving import Server, listening, server

ROOT = Path(__file__).parents[2]
PASSWORD = "correct horse"
ROBOT = "wifibot-14"
OTHER_ROBOT = "wifibot-15"
_PEOPLE = (Role.VIEWER, Role.OPERATOR, Role.ADMIN)


@cache
def gulliver() -> Lab:
    return load_lab(ROOT / "labs" / "gulliver.yaml")


@dataclass
class Service:
    """`tokens` by who: viewer, operator, admin, robot, other-robot. `http(who)` is a client that sends that token."""

    app: FastAPI
    base_url: str
    transport: httpx.AsyncBaseTransport | None
    tokens: dict[str, str]
    udp_port: int = 2020
    intake: IntakeService | None = None
    _clients: list[httpx.AsyncClient] = field(default_factory=list[httpx.AsyncClient])

    @property
    def context(self) -> Context:
        return self.app.state.context

    def http(self, who: str | None = None) -> httpx.AsyncClient:
        headers = {"Authorization": f"Bearer {self.tokens[who]}"} if who else {}
        client = httpx.AsyncClient(
            transport=self.transport, base_url=self.base_url, headers=headers, trust_env=False, timeout=10, verify=False
        )
        self._clients.append(client)
        return client

    async def close(self) -> None:
        for client in self._clients:
            await client.aclose()


@asynccontextmanager
async def in_process(
    redis_url: str, clock: Clock | None = None, lab: Lab | None = None, console: Path = Path("/nonexistent")
) -> AsyncGenerator[Service]:
    """The app with its lifespan, called directly."""
    app = _app(redis_url, clock, lab, console, scene_port=1)
    async with app.router.lifespan_context(app):
        context: Context = app.state.context
        service = Service(app, "http://console", httpx.ASGITransport(app), await _accounts(context))
        try:
            yield service
        finally:
            await service.close()


@asynccontextmanager
async def served(
    redis_url: str,
    *,
    scene_port: int = 1,
    udp_key: bytes | None = None,
    dead_after_ms: int = 10_000,
    accounts: bool = True,
) -> AsyncGenerator[tuple[Service, Server]]:
    """The app behind uvicorn on a free port of this host, an intake beside it."""
    robots = datagrams("127.0.0.1", 0)
    udp_port = robots.getsockname()[1]
    app = _app(redis_url, None, None, Path("/nonexistent"), scene_port=scene_port, udp_port=udp_port)
    with listening("127.0.0.1", 0, dead_after_ms) as listener:
        port = listener.getsockname()[1]
        serving = server(app)
        task = asyncio.create_task(serving.serve(sockets=[listener]))
        await until(lambda: serving.started or task.done())
        context: Context = app.state.context
        service = Service(app, f"http://127.0.0.1:{port}", None, await _accounts(context) if accounts else {})
        service.udp_port = udp_port
        try:
            async with intake(redis_url, robots, udp_key) as service.intake:
                yield service, serving
        finally:
            await service.close()
            serving.should_exit = True
            await asyncio.wait_for(task, 5)


@asynccontextmanager
async def intake(
    redis_url: str, robots: socket.socket, key: bytes | None = None, lab: Lab | None = None
) -> AsyncGenerator[IntakeService]:
    """An intake that listens on the bound socket, and closes it."""
    clock = SystemClock()
    bus = Bus.connect(redis_url, clock)
    taking = IntakeService(lab or gulliver(), bus, clock, key)
    async with taking.listening(robots):
        tasks = [asyncio.create_task(for_ever(part, clock)) for part in taking.parts()]
        try:
            yield taking
        finally:
            while waiting := [task for task in tasks if not task.done()]:
                for task in waiting:
                    task.cancel()
                await asyncio.wait(waiting, timeout=0.1)
            await bus.close()


async def until(condition: Callable[[], bool | Awaitable[bool]], within_s: float = 15.0) -> None:
    """Returns when the condition holds; fails when it does not within the time."""
    deadline = time.monotonic() + within_s
    while True:
        holds = condition()
        if holds if isinstance(holds, bool) else await holds:
            return
        assert time.monotonic() < deadline, "waited in vain"
        await asyncio.sleep(0.005)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def cheap_passwords() -> Passwords:
    return Passwords(PasswordHasher(time_cost=1, memory_cost=8, parallelism=1))


def _app(
    redis_url: str,
    clock: Clock | None,
    lab: Lab | None,
    console: Path,
    *,
    scene_port: int,
    udp_port: int = 2020,
) -> FastAPI:
    configuration = Configuration(
        host="127.0.0.1",
        http_port=0,
        udp_port=udp_port,
        scene_port=scene_port,
        redis_url=redis_url,
        console=console,
    )
    return create_app(configuration, lab or gulliver(), clock or SystemClock(), cheap_passwords())


async def _accounts(context: Context) -> dict[str, str]:
    """A user and a token of every role; users are called like their role."""
    store = Store(context.bus.redis)
    users, tokens = UserRepository(store, context.clock), TokenRepository(store, context.clock)
    password_hash = await cheap_passwords().hash(PASSWORD)
    known = await users.all()
    issued: dict[str, str] = {}
    for role in _PEOPLE:
        if role.value not in known:
            await users.create(role.value, role, password_hash, "test")
        issued[role.value], _ = await tokens.issue(f"{role.value} token", role, None, "test", replace=True)
    issued["robot"], _ = await tokens.issue("robot token", Role.ROBOT, ROBOT, "test", replace=True)
    issued["other-robot"], _ = await tokens.issue("other robot token", Role.ROBOT, OTHER_ROBOT, "test", replace=True)
    return issued
