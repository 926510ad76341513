"""Orders and what robots say of themselves (spec gpss): Command, Status, Response, waypoints, routes, assignments."""

from enum import StrEnum
from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from protocol.messages.base import (
    NUMERIC,
    Counted,
    Finite,
    Flag,
    Identifier,
    Message,
    NonNegative,
    PointXY,
    Positive,
    StampNs,
)

Order = tuple[Counted, Counted]
"""(epoch, sequence) of a command."""
MOST_PATH_POINTS = 64
ZoneOutline = Annotated[tuple[PointXY, ...], Field(min_length=3, max_length=64)]
ZoneSpeed = Annotated[float, Field(strict=True, gt=0, le=10, allow_inf_nan=False)]
"""Of speed zones, in the lab file too: what it may hold must be what goes to clients. Metres, m/s."""


class Movement(StrEnum):
    """What a command asks for. The first four are GPSS's; `Drive` carries a hand-driven twist."""

    MOVE_TO = "MoveTo"
    WAITING = "Waiting"
    NO_ACTION = "NoAction"
    ROTATE = "Rotate"
    DRIVE = "Drive"


class StopAction(StrEnum):
    """What a robot stops for."""

    PICK_UP = "pick_up"
    DROP_OFF = "drop_off"
    CHARGE = "charge"


class ReasonCode(StrEnum):
    """Why a robot drives, waits or stands; machine-readable."""

    ROUTE = "route"
    DETOUR = "detour"
    YIELDING = "yielding"
    AT_STOP = "at_stop"
    ROUTE_DONE = "route_done"
    MANUAL = "manual"
    IDLE = "idle"
    PAUSED = "paused"
    OBSTACLE = "obstacle"
    ROBOT_AHEAD = "robot_ahead"
    EMERGENCY_STOP = "emergency_stop"
    POSE_STALE = "pose_stale"
    COMMAND_STALE = "command_stale"
    OBSTACLES_UNKNOWN = "obstacles_unknown"
    OUTSIDE_AREA = "outside_area"
    WAYPOINT_MISSING = "waypoint_missing"
    NOT_CONNECTED = "not_connected"
    DRIVER_FAULT = "driver_fault"
    PROTECTIVE_FIELD = "protective_field"
    BATTERY_EMPTY = "battery_empty"


class Reason(Message):
    """A code for machines and a sentence for people, e.g. ("obstacle", "0.42 m ahead at (3.1, 0.9)"); since when it holds."""

    code: ReasonCode
    text: str = ""
    since_ns: StampNs | None = None


class Target(Message):
    """Where to drive, metres in the map frame, and the heading to end with (rad) if it matters."""

    x: Finite
    y: Finite
    yaw: Finite | None = None


class Command(Message):
    """Server to robot, rewritten many times while driving.

    Commands of one robot are ordered by (epoch, sequence): the epoch grows each time a guidance takes over, so a robot
    refuses what an older brain still sends. A command is not to be obeyed after `deadline_ns`.

    `path` is the operator's line around the robot: from a little behind it over the next waypoints to where it is to arrive
    next, or some metres ahead; the robot is to be able to stop at its end. A robot may follow it instead of heading for the
    target; it is empty where there is none, as from servers that know no paths.
    """

    robot: Identifier
    epoch: Counted
    sequence: Counted
    stamp_ns: StampNs
    deadline_ns: StampNs
    movement: Movement
    reason: Reason
    target: Target | None = None
    speed_mps: NonNegative = 0.0
    final: Flag = Field(
        default=False, description="Whether the target is a place to arrive at, not a carrot on the way."
    )
    path: Annotated[tuple[PointXY, ...], Field(max_length=MOST_PATH_POINTS)] = ()
    action: StopAction | None = Field(
        default=None, description="What the robot stands still for, at a stop of its route."
    )
    linear_mps: Finite = 0.0
    angular_radps: Finite = 0.0

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.movement is Movement.MOVE_TO and self.target is None:
            raise ValueError("MoveTo needs a target")
        if self.movement is Movement.ROTATE and (self.target is None or self.target.yaw is None):
            raise ValueError("Rotate needs a target with yaw")
        return self

    @property
    def order(self) -> tuple[int, int]:
        """Commands with a smaller order than one already obeyed are to be ignored."""
        return self.epoch, self.sequence


class Mode(StrEnum):
    """VDA5050's operating modes, as far as they apply."""

    AUTOMATIC = "AUTOMATIC"
    MANUAL = "MANUAL"


class Status(Message):
    """Robot to server, continuously: where it believes to be and what it really does."""

    robot: Identifier
    sequence: Counted
    stamp_ns: StampNs
    x: Finite | None = Field(default=None, description="None until the robot has been localized once.")
    y: Finite | None = None
    yaw: Finite | None = None
    linear_mps: Finite
    angular_radps: Finite
    ip: str = ""
    area: str | None = None
    battery: Annotated[float, Field(strict=True, ge=0, le=1)] | None = Field(
        default=None, description="Share of full charge."
    )
    mode: Mode = Mode.AUTOMATIC
    faults: tuple[str, ...] = ()
    command_order: Order | None = Field(default=None, description="(epoch, sequence) of the newest command accepted.")
    stopped_by: Reason | None = Field(default=None, description="Why the robot itself holds still, if it does.")
    pose_age_s: NonNegative | None = None
    command_age_s: NonNegative | None = None
    command_loss: Annotated[float, Field(strict=True, ge=0, le=1)] | None = Field(
        default=None,
        description="Share of guidance's commands of the last seconds that did not reach the robot in time.",
    )
    stop_epoch: Counted | None = Field(
        default=None, description="Epoch of the emergency stop that the robot holds; None while it holds none."
    )


class Outcome(StrEnum):
    """What became of a command. `accepted` has an empty reached_ns, as in the report."""

    ACCEPTED = "accepted"
    REFUSED = "refused"
    REACHED = "reached"


class Response(Message):
    """Robot to server: the command it answers, what was really applied, and when the target was reached (empty before)."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "robot": "wifibot-14",
                    "command_order": [3, 1207],
                    "command_stamp_ns": 1_700_000_000_000_000_000,
                    "stamp_ns": 1_700_000_000_020_000_000,
                    "outcome": "accepted",
                    "movement": "MoveTo",
                    "applied_speed_mps": 0.3,
                }
            ]
        }
    )

    robot: Identifier
    command_order: Order
    command_stamp_ns: StampNs
    stamp_ns: StampNs
    outcome: Outcome
    movement: Movement
    applied_speed_mps: NonNegative = 0.0
    reached_ns: StampNs | None = None
    reason: str = ""


class Waypoint(Message):
    """A place on the floor: metres in the map frame; the radius within which it counts as reached; the heading (rad) to
    leave it with if that matters."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"id": "charger", "area": "camp", "x": 1.0, "y": 1.0, "radius_m": 0.15, "yaw": None}]
        }
    )

    id: Identifier
    area: Identifier
    x: Finite
    y: Finite
    radius_m: Annotated[float, Field(strict=True, gt=0, le=5, allow_inf_nan=False)] = 0.15
    yaw: Finite | None = None


class Leg(Message):
    """One leg of a route: the waypoint it ends at, the speed set-point on the way there, and what happens at its end.

    `movement` `MoveTo` drives there; `Rotate` only turns, where the robot stands, to the heading of the leg's end or, without
    one, towards the waypoint. A leg with a heading, a stay, an action or a confirmation ends at rest.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"waypoint": "charger", "speed_mps": 0.3},
                {"waypoint": "shelf", "action": "pick_up", "dwell_s": 5},
            ]
        }
    )

    waypoint: Identifier
    speed_mps: Annotated[float, Field(strict=True, gt=0, le=10, allow_inf_nan=False)] = 0.3
    movement: Literal[Movement.MOVE_TO, Movement.ROTATE] = Movement.MOVE_TO
    yaw: Finite | None = Field(default=None, description="Heading to end with (rad); null: the waypoint's.")
    dwell_s: Annotated[float, Field(strict=True, ge=0, le=86_400, allow_inf_nan=False)] = Field(
        default=0.0, description="How long the robot stays at the leg's end, at least."
    )
    action: StopAction | None = None
    confirm: Flag = Field(default=False, description="Whether it stays until a person lets it go on.")
    charge_to: Annotated[float, Field(strict=True, gt=0, le=1)] = Field(
        default=0.9,
        description="The share of full charge at which charging ends; without a battery to read, `dwell_s` decides.",
    )

    @property
    def stays(self) -> bool:
        """Whether the robot has anything to wait for at the leg's end."""
        return self.dwell_s > 0 or self.action is not None or self.confirm


class Route(Message):
    """Ordered legs, driven once or looped."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"id": "charge", "legs": [{"waypoint": "charger", "speed_mps": 0.3}], "loop": False}]
        }
    )

    id: Identifier
    legs: Annotated[tuple[Leg, ...], Field(min_length=1, max_length=1000)]
    loop: Flag = False


MOST_QUEUED = 32
"""Routes that may wait for one robot."""


class QueuedRoute(Message):
    """A route that waits for a robot to be done with what it drives; its id becomes the assignment's."""

    id: Annotated[str, Field(min_length=1, max_length=64)]
    route: Identifier
    speed_scale: Annotated[float, Field(strict=True, gt=0, le=2, allow_inf_nan=False)] = 1.0
    queued_ns: StampNs
    queued_by: str = ""


class AssignmentState(StrEnum):
    """The life of an assignment; RUNNING and PAUSED are not over."""

    RUNNING = "running"
    PAUSED = "paused"
    DONE = "done"
    STOPPED = "stopped"
    FAILED = "failed"


class Assignment(Message):
    """A route given to a robot, and how far it has come. Durable: it survives every restart.

    `queue` holds the routes that follow, first in, first out. They begin when this one is done or cancelled; after a failure
    they wait for a person.
    """

    id: Annotated[str, Field(min_length=1, max_length=64)]
    robot: Identifier
    route: Identifier
    state: AssignmentState
    leg: Counted = Field(default=0, description="Index of the leg being driven.")
    laps: Counted = 0
    speed_scale: Annotated[float, Field(strict=True, gt=0, le=2, allow_inf_nan=False)] = 1.0
    at_stop_ns: StampNs | None = Field(
        default=None,
        description="Since when the robot is at the end of its leg, where it stays a while; null on the way.",
    )
    proceed: Flag = Field(default=False, description="Whether a person has let it go on from where it stays.")
    started_ns: StampNs
    changed_ns: StampNs
    started_by: str = ""
    reason: str = ""
    queue: Annotated[tuple[QueuedRoute, ...], Field(max_length=MOST_QUEUED)] = ()


class RobotSettings(Message):
    """What an operator may set per robot; absent fields fall back to the lab description."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"box_start_m": 0.0, "box_length_m": 0.8, "box_width_m": 0.6, "stop_at_waypoint": None}]
        }
    )

    box_start_m: NonNegative | None = None
    box_length_m: Positive | None = None
    box_width_m: Positive | None = None
    stop_at_waypoint: Flag | None = None
    box_robots: Flag | None = Field(default=None, description="Whether other robots in the box count.")
    box_unknown: Flag | None = Field(default=None, description="Whether floor in the box that no camera sees counts.")
    detours: Flag | None = Field(default=None, description="Whether it drives around what blocks it.")
    detour_after_s: NonNegative | None = Field(
        default=None, description="How long it waits before it looks for a way around."
    )
    detour_clearance_m: NonNegative | None = Field(
        default=None, description="What it keeps free beside itself on a detour."
    )
    priority: Annotated[int, Field(ge=0, le=9), NUMERIC] = Field(
        default=0,
        description="Among robots that wait for each other the one with the least yields; of equals the last by id.",
    )


class SpeedZone(Message):
    """A part of the floor where robots drive no faster than `speed_mps`: an outline in metres, map frame. It holds for a robot
    while any part of it is inside."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"id": "doorway", "outline": [[3.0, 1.0], [4.0, 1.0], [4.0, 2.0], [3.0, 2.0]], "speed_mps": 0.2}
            ]
        }
    )

    id: Identifier
    outline: ZoneOutline
    speed_mps: ZoneSpeed


class Registration(Message):
    """A robot's introduction: where it listens for UDP and who it is. `session` differs after each restart."""

    robot: Identifier
    kind: str = ""
    host: str
    udp_port: Annotated[int, Field(gt=0, lt=65536), NUMERIC]
    session: str = Field(default="", max_length=64)
    stamp_ns: StampNs = 0


class ManualDrive(Message):
    """A hand on the stick: the twist asked for, by whom, and until when it counts (the lease)."""

    robot: Identifier
    linear_mps: Finite
    angular_radps: Finite
    holder: str = Field(description="Tells one browser session or token from another.")
    by: str = Field(default="", description="Who that is, for people.")
    expires_ns: StampNs


class EmergencyStop(Message):
    """The fleet-wide latch. Engaged until a person releases it; `epoch` grows with every change."""

    engaged: Flag
    epoch: Counted = 0
    stamp_ns: StampNs = 0
    by: str = ""
    reason: str = ""
