"""Robots as an operator sees them, their settings, their routes, and the stick."""

from typing import Annotated

from fastapi import APIRouter, Header, Path, Query
from pydantic import ConfigDict, Field

from protocol.messages import Assignment, ManualDrive, Response, RobotSettings
from protocol.messages.base import Finite, Identifier
from server.access import Operator, RobotId, Viewer
from server.context import Ctx
from server.errors import ConflictError
from server.live.reading import read_fleet, read_responses
from server.routes.answers import refusals
from server.views.base import Body
from server.views.robots import RobotView, robot_view

router = APIRouter(prefix="/robots", tags=["robots"])


_Tab = Annotated[
    str | None,
    Header(
        alias="X-Lilliput-Tab",
        pattern=r"^[A-Za-z0-9_-]{1,64}$",
        description="Tells one tab, or one thread of a program, from another of the same login: each has a hand of its own.",
    ),
]


_Entry = Annotated[str, Path(pattern=r"^[0-9a-z-]{1,64}$")]


class Start(Body):
    """Which route to drive; `speed_scale` multiplies the speed of every leg."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"route": "charge", "speed_scale": 1.0}]})

    route: Identifier = Field(examples=["charge"])
    speed_scale: Annotated[float, Field(strict=True, gt=0, le=2, allow_inf_nan=False)] = 1.0


class Twist(Body):
    """What the hand on the stick asks for: m/s forward, rad/s to the left."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"linear_mps": 0.2, "angular_radps": -0.5}]})

    linear_mps: Finite = Field(examples=[0.2])
    angular_radps: Finite = Field(examples=[-0.5])


@router.get("", summary="All robots", responses=refusals())
async def list_robots(_identity: Viewer, context: Ctx) -> list[RobotView]:
    """Every robot of the lab description with all that is known of it."""
    now_ns = context.clock.now_ns()
    fleet = await read_fleet(context.bus, now_ns)
    return [robot_view(vehicle, fleet, now_ns) for vehicle in context.lab.vehicles]


@router.get("/{robot_id}", summary="One robot", responses=refusals(404))
async def get_robot(_identity: Viewer, robot_id: RobotId, context: Ctx) -> RobotView:
    """All that is known of the robot."""
    vehicle = context.vehicle(robot_id)
    now_ns = context.clock.now_ns()
    return robot_view(vehicle, await read_fleet(context.bus, now_ns), now_ns)


@router.get("/{robot_id}/responses", summary="What a robot answered", responses=refusals(404))
async def list_responses(
    _identity: Viewer, robot_id: RobotId, context: Ctx, count: Annotated[int, Query(ge=1, le=1000)] = 100
) -> list[Response]:
    """The robot's newest responses to commands, oldest first: accepted, refused and why, or reached."""
    context.vehicle(robot_id)
    return await read_responses(context.bus, robot_id, count)


@router.put("/{robot_id}/settings", summary="Set the obstacle box", responses=refusals(404))
async def put_robot_settings(
    identity: Operator, robot_id: RobotId, settings: RobotSettings, context: Ctx
) -> RobotSettings:
    """Replaces what an operator has set for this robot; what is absent falls back to the lab description."""
    context.vehicle(robot_id)
    return await context.settings.put(robot_id, settings, identity.name)


@router.put("/{robot_id}/assignment", summary="Start a route", responses=refusals(404, 409))
async def start_route(identity: Operator, robot_id: RobotId, start: Start, context: Ctx) -> Assignment:
    """Gives the robot a route. Refused while the emergency stop is engaged, while it has another one that is not over
    (one that was started by `first start`, a simulated lab's tours, is replaced), and when a waypoint of the route is
    missing."""
    context.vehicle(robot_id)
    return await context.assignments.start(robot_id, start.route, start.speed_scale, identity.name)


@router.post("/{robot_id}/assignment/pause", summary="Pause the route", responses=refusals(404, 409))
async def pause_route(identity: Operator, robot_id: RobotId, context: Ctx) -> Assignment:
    """The robot holds still until the route is resumed."""
    context.vehicle(robot_id)
    return await context.assignments.pause(robot_id, identity.name)


@router.post("/{robot_id}/assignment/resume", summary="Resume the route", responses=refusals(404, 409))
async def resume_route(identity: Operator, robot_id: RobotId, context: Ctx) -> Assignment:
    """The robot drives on where it was paused."""
    context.vehicle(robot_id)
    return await context.assignments.resume(robot_id, identity.name)


@router.delete("/{robot_id}/assignment", summary="Stop the route", responses=refusals(404, 409))
async def stop_route(identity: Operator, robot_id: RobotId, context: Ctx) -> Assignment:
    """Ends the route for good and empties the queue; the robot holds still."""
    context.vehicle(robot_id)
    return await context.assignments.stop(robot_id, identity.name)


@router.post("/{robot_id}/assignment/skip", summary="Skip a leg", responses=refusals(404, 409))
async def skip_leg(identity: Operator, robot_id: RobotId, context: Ctx) -> Assignment:
    """The robot goes on with the next leg from where it is; the stay at the end of this one is left out too. Skipping the last
    leg ends the route, and the next of the queue begins."""
    context.vehicle(robot_id)
    return await context.assignments.skip(robot_id, identity.name)


@router.post("/{robot_id}/assignment/proceed", summary="Let it go on from a stop", responses=refusals(404, 409))
async def proceed(identity: Operator, robot_id: RobotId, context: Ctx) -> Assignment:
    """Confirms what a robot stays for at the end of a leg (a load taken, a charge that suffices). Refused while it does not
    stay anywhere."""
    context.vehicle(robot_id)
    return await context.assignments.proceed(robot_id, identity.name)


@router.post("/{robot_id}/assignment/cancel", summary="Cancel the route", responses=refusals(404, 409))
async def cancel_route(identity: Operator, robot_id: RobotId, context: Ctx) -> Assignment:
    """Ends the route, also one that failed, and the next of the queue begins."""
    context.vehicle(robot_id)
    return await context.assignments.cancel(robot_id, identity.name)


@router.post("/{robot_id}/queue", summary="Queue a route", status_code=201, responses=refusals(404, 409))
async def queue_route(identity: Operator, robot_id: RobotId, start: Start, context: Ctx) -> Assignment:
    """The robot drives the route after all that it has to do; a looped route ends at the end of its lap when something is
    queued. With nothing to do it begins at once, and is refused as a start is."""
    context.vehicle(robot_id)
    return await context.assignments.enqueue(robot_id, start.route, start.speed_scale, identity.name)


@router.delete("/{robot_id}/queue", summary="Empty the queue", responses=refusals(404))
async def empty_queue(identity: Operator, robot_id: RobotId, context: Ctx) -> Assignment:
    """What is being driven goes on."""
    context.vehicle(robot_id)
    return await context.assignments.dequeue(robot_id, None, identity.name)


@router.delete("/{robot_id}/queue/{entry_id}", summary="Take a route out of the queue", responses=refusals(404))
async def dequeue_route(identity: Operator, robot_id: RobotId, entry_id: _Entry, context: Ctx) -> Assignment:
    """By the id of its entry."""
    context.vehicle(robot_id)
    return await context.assignments.dequeue(robot_id, entry_id, identity.name)


@router.put("/{robot_id}/manual", summary="Drive by hand", responses=refusals(404, 409))
async def drive_by_hand(
    identity: Operator, robot_id: RobotId, twist: Twist, context: Ctx, tab: _Tab = None
) -> ManualDrive:
    """Takes or renews the stick for half a second with this twist, and answers with what is applied: it is clipped to
    what the robot can do. Manual drive outranks the route. Refused while somebody else holds the stick and while the
    emergency stop is engaged."""
    vehicle = context.vehicle(robot_id)
    if (await context.emergency_stop.get()).engaged:
        raise ConflictError("the emergency stop is engaged; release it before driving by hand")
    return await context.manual.drive(vehicle, twist.linear_mps, twist.angular_radps, identity.hand(tab), identity.name)


@router.delete("/{robot_id}/manual", summary="Let go of the stick", status_code=204, responses=refusals(404, 409))
async def let_go(identity: Operator, robot_id: RobotId, context: Ctx, tab: _Tab = None) -> None:
    """Hands the robot back to its route at once. Refused while somebody else holds the stick."""
    context.vehicle(robot_id)
    await context.manual.release(robot_id, identity.hand(tab), identity.name)
