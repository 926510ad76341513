"""Puts the service together: routes, refusals, headers, and what lives as long as the app does."""

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager

import httpx
from fastapi import APIRouter, FastAPI
from fastapi.routing import APIRoute
from starlette.types import Lifespan

from protocol.bus import Bus
from protocol.clock import Clock, SystemClock
from protocol.lab import Lab
from server import refusals
from server.auth.passwords import Passwords
from server.configuration import Configuration
from server.context import Context
from server.going_on import for_ever
from server.live.hub import LiveHub
from server.methods import AllowedMethods
from server.routes import (
    accounts,
    calibration,
    cameras,
    console,
    emergency_stop,
    lab,
    live,
    plan,
    robot_side,
    robots,
    scene_proxy,
    session,
    simulation,
    speed_zones,
    timings,
)
from server.security_headers import SecurityHeaders

_ROUTES = (
    session,
    lab,
    robots,
    robot_side,
    plan,
    speed_zones,
    emergency_stop,
    cameras,
    calibration,
    simulation,
    accounts,
    timings,
    live,
)
_LARGEST_BODY = 1 << 20
_CANCEL_AGAIN_S = 0.1

_DESCRIPTION = """Fleet control of a lab or factory floor: waypoints, routes, robots, cameras, the emergency stop.

Programs send `Authorization: Bearer TOKEN` (`./lilliput token`); browsers hold a session cookie, and send
`X-Lilliput: 1` with every change. Roles: `viewer` < `operator` < `admin`; `robot` speaks for one robot only.
Stamps are nanoseconds since the epoch, positions metres in the map frame, angles radians counter-clockwise.
The live stream is a WebSocket at `/api/live`: a `LiveSnapshot`, then `LiveChanges`."""


def create_app(
    configuration: Configuration,
    lab_description: Lab,
    clock: Clock | None = None,
    passwords: Passwords | None = None,
) -> FastAPI:
    """The app of one server. Nothing is opened before its lifespan begins."""
    clock = clock or SystemClock()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncGenerator[None]:
        async with AsyncExitStack() as stack:
            bus = await stack.enter_async_context(_bus(configuration.redis_url, clock))
            hub = LiveHub(bus, lab_description, clock)
            scene = await stack.enter_async_context(_scene_client(configuration.scene_port))
            app.state.context = Context.build(
                configuration, lab_description, clock, bus, hub, scene, passwords or Passwords()
            )
            await stack.enter_async_context(_running(clock, *hub.parts()))
            stack.callback(hub.feeds.close)
            yield

    return assemble(lifespan)


def assemble(lifespan: Lifespan[FastAPI] | None = None) -> FastAPI:
    """Routes, refusals and headers, without anything behind them."""
    app = FastAPI(
        title="Lilliput",
        version="0.1.0",
        description=_DESCRIPTION,
        lifespan=lifespan,
        openapi_url="/api/openapi.json",
        docs_url=None,
        redoc_url=None,
        separate_input_output_schemas=False,
        generate_unique_id_function=_operation_id,
        max_body_size=_LARGEST_BODY,
        redirect_slashes=False,
    )
    api = APIRouter(prefix="/api")
    for module in _ROUTES:
        api.include_router(module.router)
    app.include_router(api)
    app.include_router(scene_proxy.router)
    app.include_router(console.router)
    refusals.install(app)
    AllowedMethods("/api", (route for module in _ROUTES for route in module.router.routes)).install(app)
    app.add_middleware(SecurityHeaders)
    return app


def _operation_id(route: APIRoute) -> str:
    return route.name


@asynccontextmanager
async def _bus(url: str, clock: Clock) -> AsyncGenerator[Bus]:
    bus = Bus.connect(url, clock)
    try:
        yield bus
    finally:
        await bus.close()


@asynccontextmanager
async def _scene_client(port: int) -> AsyncGenerator[httpx.AsyncClient]:
    async with httpx.AsyncClient(
        base_url=f"http://127.0.0.1:{port}",
        timeout=httpx.Timeout(10.0, connect=2.0),
        trust_env=False,
        verify=False,  # noqa: S501  # plain HTTP on loopback: saves reading the certificates
    ) as client:
        yield client


@asynccontextmanager
async def _running(clock: Clock, *functions: Callable[[], Awaitable[None]]) -> AsyncGenerator[None]:
    """Runs them beside the app until it ends."""
    tasks = [asyncio.create_task(for_ever(function, clock)) for function in functions]
    try:
        yield
    finally:
        # Python 3.11's wait_for, which redis-py sends through, swallows a cancellation that comes as it is done
        # (python/cpython#86296), so one may not be enough.
        while waiting := [task for task in tasks if not task.done()]:
            for task in waiting:
                task.cancel()
            await asyncio.wait(waiting, timeout=_CANCEL_AGAIN_S)
