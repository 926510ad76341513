"""The lab description, the system's health and its history."""

from typing import Annotated

from fastapi import APIRouter, Query, Request
from redis.exceptions import RedisError

from protocol.channels import EVENTS
from protocol.messages import Event
from server.access import Viewer, identify, identify_by_memory
from server.context import Context, Ctx
from server.roles import Role
from server.routes.answers import refusals
from server.views.health import HealthSummary, HealthView
from server.views.lab import LabView, lab_view

router = APIRouter(tags=["lab"])


@router.get("/lab", summary="The lab description", responses=refusals())
async def get_lab(_identity: Viewer, context: Ctx) -> LabView:
    """What exists: areas, cameras, floor tags, vehicles, zones, ports; without the simulation's truth."""
    return lab_view(context.lab)


@router.get("/health", summary="Health of the system", tags=["health"])
async def get_health(request: Request, context: Ctx) -> HealthView | HealthSummary:
    """For viewers: how old the newest message of every channel is, which processes run, and what is missing since when.
    Everybody else gets a HealthSummary. Answers 200 also when something is wrong, Redis included: see `state`."""
    health = await context.hub.health()
    return health if await _looks(request, context) else health.summary()


async def _looks(request: Request, context: Context) -> bool:
    """Whether a viewer asks; while Redis is out of reach, whether one did lately."""
    try:
        identity = await identify(request, context)
    except (RedisError, OSError):
        identity = identify_by_memory(request, context)
    return identity is not None and identity.has(Role.VIEWER)


@router.get("/events", summary="History", responses=refusals())
async def list_events(
    _identity: Viewer, context: Ctx, count: Annotated[int, Query(ge=1, le=1000)] = 100
) -> list[Event]:
    """The newest events, oldest first: who did what, and what went wrong."""
    return [received.message for received in await context.bus.history(EVENTS, count)]
