"""The robot's side: registration, the stream of commands, responses (spec gpss, "The protocol")."""

from typing import Annotated

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse
from pydantic import ConfigDict, Field
from redis.exceptions import RedisError

from protocol import messages
from protocol.channels import POSES, REGISTRATIONS, RESPONSES
from protocol.errors import DecodeError
from protocol.messages import Event, EventLevel, Registration
from server.access import RobotId, ThisRobot, ThisRobotOrOperator, still_stands
from server.context import Context, Ctx
from server.direct_writes import direct_write
from server.errors import InvalidError, UnavailableError
from server.live.command_stream import command_stream
from server.repositories.history import record
from server.routes.answers import refusals
from server.views.base import Body, View

router = APIRouter(prefix="/robots/{robot_id}", tags=["robot's side"])


class Introduction(Body):
    """What a robot says when it starts, and again as often as it is asked to. `session` differs after each of its restarts."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"kind": "wifibot", "udp_port": 40123, "session": "b1946ac9"}]}
    )

    kind: Annotated[str, Field(max_length=64, examples=["wifibot"])] = ""
    udp_port: Annotated[
        int, Field(strict=True, gt=0, lt=65536, examples=[40123], description="Where it hears POSE datagrams.")
    ]
    session: Annotated[str, Field(max_length=64)] = ""


_REGISTRATIONS_HZ = 25.0
"""So many a second are enough."""


class RegistrationView(View):
    """Where the robot sends its STATUS datagrams, how often to expect poses, and how soon to register again."""

    robots_udp: int
    pose_rate_hz: float
    again_s: float


@router.post("/registration", summary="Register a robot", responses=refusals(404))
async def register_robot(
    identity: ThisRobot, robot_id: RobotId, introduction: Introduction, request: Request, context: Ctx
) -> RegistrationView:
    """Tells where the robot listens: the address that this request comes from, and the port in it."""
    context.vehicle(robot_id)
    known = context.introduced.get(robot_id)
    if known != introduction.session:  # else it is one of those that come every few seconds
        known = await _registered_session(context, robot_id)
    registration = Registration(
        robot=robot_id,
        kind=introduction.kind,
        host=request.client.host if request.client else "127.0.0.1",
        udp_port=introduction.udp_port,
        session=introduction.session,
        stamp_ns=context.clock.now_ns(),
    )
    if not await context.bus.publish(REGISTRATIONS, robot_id, registration):
        raise UnavailableError("Redis is out of reach; register again")
    context.introduced[robot_id] = registration.session
    if known != registration.session:
        text = f"{robot_id} registered from {registration.host}:{registration.udp_port}"
        now_ns = context.clock.now_ns()
        event = Event(stamp_ns=now_ns, level=EventLevel.INFO, source=identity.name, kind="robot_registered", text=text)
        await record(context.bus, event)
    return RegistrationView(
        robots_udp=context.configuration.udp_port,
        pose_rate_hz=POSES.rate_hz,
        again_s=_again_s(len(context.lab.vehicles)),
    )


def _again_s(robots: int) -> float:
    """As often as the channel says; a large fleet's robots less often, but before they count as missing."""
    usual_s = 1.0 / REGISTRATIONS.rate_hz
    return min(max(usual_s, robots / _REGISTRATIONS_HZ), 0.75 * REGISTRATIONS.stale_after_s)


async def _registered_session(context: Context, robot_id: str) -> str | None:
    """That of the robot's newest registration with any server; None when there is none, or a damaged one."""
    try:
        old = await context.bus.latest(REGISTRATIONS, robot_id)
    except DecodeError:
        return None
    return None if old is None else old.session


@router.get(
    "/commands",
    summary="Stream of commands",
    response_class=StreamingResponse,
    responses={
        200: {
            "description": (
                "Server-sent events: first `emergency_stop` (EmergencyStop), again at each of its changes; `command` "
                "(Command), only the newest if the robot is slow; a comment every half second while nothing happens."
            ),
            "content": {
                "text/event-stream": {
                    "schema": {"type": "string"},
                    "example": 'event: emergency_stop\ndata: {"engaged":false,"epoch":0}\n\n',
                }
            },
        },
        **refusals(404),
    },
)
async def stream_commands(
    _identity: ThisRobotOrOperator, robot_id: RobotId, request: Request, context: Ctx
) -> StreamingResponse:
    """Commands for the robot as server-sent events, for as long as it listens and its token is valid."""
    context.vehicle(robot_id)

    async def may_listen() -> bool:
        try:
            return await still_stands(request, context)
        except (RedisError, OSError):
            return True  # the robot hears nothing new then, and stops by itself

    return StreamingResponse(
        command_stream(context.hub.feeds, robot_id, context.clock, may_listen, direct_write(request.scope)),
        media_type="text/event-stream",
        headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"},
    )


@router.post("/responses", summary="Answer a command", status_code=204, responses=refusals(404))
async def post_response(_identity: ThisRobot, robot_id: RobotId, response: messages.Response, context: Ctx) -> None:
    """What became of a command: accepted or refused, what is really applied, and when its target was reached."""
    context.vehicle(robot_id)
    if response.robot != robot_id:
        raise InvalidError(("body", "robot"), f"is {response.robot!r}, the address says {robot_id!r}")
    await context.bus.publish(RESPONSES, robot_id, response)
