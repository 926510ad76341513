"""Waypoints and routes."""

from typing import Annotated

from fastapi import APIRouter, Path

from protocol.messages import Route, Waypoint
from server.access import Operator, Viewer
from server.context import Ctx
from server.errors import InvalidError
from server.routes.answers import refusals

router = APIRouter(tags=["waypoints and routes"])

_Id = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]


@router.get("/waypoints", summary="All waypoints", responses=refusals())
async def list_waypoints(_identity: Viewer, context: Ctx) -> list[Waypoint]:
    """By id."""
    return list((await context.waypoints.all()).values())


@router.post("/waypoints", summary="Place a waypoint", status_code=201, responses=refusals(409))
async def create_waypoint(identity: Operator, waypoint: Waypoint, context: Ctx) -> Waypoint:
    """It must lie in the area that it names. Refused when the id is taken."""
    return await context.waypoints.put(waypoint, identity.name, create=True)


@router.put("/waypoints/{waypoint_id}", summary="Change a waypoint", responses=refusals())
async def put_waypoint(identity: Operator, waypoint_id: _Id, waypoint: Waypoint, context: Ctx) -> Waypoint:
    """Replaces it as a whole, or places it. Robots on their way to it follow at once."""
    _require_same("waypoint", waypoint_id, waypoint.id)
    return await context.waypoints.put(waypoint, identity.name, create=False)


@router.delete("/waypoints/{waypoint_id}", summary="Delete a waypoint", status_code=204, responses=refusals(404, 409))
async def delete_waypoint(identity: Operator, waypoint_id: _Id, context: Ctx) -> None:
    """Refused while a route uses it."""
    await context.waypoints.delete(waypoint_id, identity.name)


@router.get("/routes", summary="All routes", responses=refusals())
async def list_routes(_identity: Viewer, context: Ctx) -> list[Route]:
    """By id."""
    return list((await context.routes.all()).values())


@router.post("/routes", summary="Make a route", status_code=201, responses=refusals(409))
async def create_route(identity: Operator, route: Route, context: Ctx) -> Route:
    """Every leg's waypoint must exist. Refused when the id is taken."""
    return await context.routes.put(route, identity.name, create=True)


@router.put("/routes/{route_id}", summary="Change a route", responses=refusals(409))
async def put_route(identity: Operator, route_id: _Id, route: Route, context: Ctx) -> Route:
    """Replaces it as a whole, or makes it. Refused while it is being driven."""
    _require_same("route", route_id, route.id)
    return await context.routes.put(route, identity.name, create=False)


@router.delete("/routes/{route_id}", summary="Delete a route", status_code=204, responses=refusals(404, 409))
async def delete_route(identity: Operator, route_id: _Id, context: Ctx) -> None:
    """Refused while it is being driven."""
    await context.routes.delete(route_id, identity.name)


def _require_same(kind: str, in_path: str, in_body: str) -> None:
    if in_path != in_body:
        raise InvalidError(("body", "id"), f"the {kind}'s id is {in_body!r}, the address says {in_path!r}")
