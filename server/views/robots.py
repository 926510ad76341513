"""How a robot looks to an operator: where it is and how old that is, what it does, and what it waits for."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from pydantic import Field

from protocol.channels import COMMANDS, POSES, STATUSES
from protocol.lab import Detours, Limits, ObstacleBox, VehicleSpec
from protocol.messages import (
    Assignment,
    AssignmentState,
    Command,
    EmergencyStop,
    GuidanceState,
    ManualDrive,
    Mode,
    Movement,
    Reason,
    ReasonCode,
    Registration,
    RobotSettings,
    Status,
    Target,
    TrackedPose,
)
from protocol.messages.guidance import Blockage
from server.effective_box import effective_box, effective_detours
from server.repositories.plan import is_over
from server.views.base import AgeS, Outline, PointXY, View, age_s


class Connection(StrEnum):
    """VDA5050's words: OFFLINE never said anything, CONNECTION_BROKEN fell silent."""

    ONLINE = "ONLINE"
    OFFLINE = "OFFLINE"
    CONNECTION_BROKEN = "CONNECTION_BROKEN"


class RobotState(StrEnum):
    """What a robot does, in a word; `lost`: no camera has seen it lately."""

    OFFLINE = "offline"
    EMERGENCY_STOP = "emergency_stop"
    FAULT = "fault"
    MANUAL = "manual"
    LOST = "lost"
    DRIVING = "driving"
    WAITING = "waiting"
    PAUSED = "paused"
    IDLE = "idle"


class PoseView(View):
    """Where the cameras see the robot's rotation centre: metres and radians in the map frame, m/s, rad/s."""

    x: float
    y: float
    yaw: float
    vx: float
    vy: float
    yaw_rate: float
    stamp_ns: int
    age_s: AgeS
    fresh: bool = Field(description="Whether it is young enough to drive by.")
    cameras: tuple[str, ...]
    area: str | None
    position_std_m: float = Field(description="Standard deviation of the position along its worse axis.")


class StatusView(View):
    """What the robot says of itself, as last heard."""

    stamp_ns: int
    age_s: AgeS
    x: float | None = Field(description="Where it believes to be; null until it has been localized once.")
    y: float | None
    yaw: float | None
    linear_mps: float
    angular_radps: float
    ip: str
    battery: float | None = Field(description="Share of full charge.")
    mode: Mode
    faults: tuple[str, ...]
    stopped_by: Reason | None = Field(description="Why the robot itself holds still, if it does.")
    pose_age_s: float | None
    command_age_s: float | None
    command_loss: float | None = Field(
        description="Share of guidance's commands of the last seconds that did not reach the robot in time."
    )
    loss: float | None = Field(
        description="Share of the robot's statuses of the last seconds that did not arrive here."
    )


class CommandView(View):
    """What guidance asks of the robot, if that is fresh."""

    movement: Movement
    target: Target | None
    speed_mps: float
    final: bool
    reason: Reason


class GuidanceView(View):
    """How guidance sees the robot: the obstacle box and what is in it, the temporary waypoint and the path ahead."""

    blocked: bool = Field(description="Whether the obstacle box counts as taken (draw it red).")
    blockage: Blockage | None
    box: Outline = Field(description="Outline of the obstacle box; empty while there is none.")
    carrot: PointXY | None
    path: Outline
    detour: Outline = Field(
        description="What is left of its way around something, or out of the way; empty on its route."
    )
    leg: int | None


class ManualView(View):
    """Who drives by hand, while their lease is fresh."""

    holder: str
    by: str
    linear_mps: float
    angular_radps: float
    expires_ns: int


class RobotView(View):
    """A robot with all that is known of it."""

    id: str
    kind: str
    footprint: Outline = Field(description="Metres, seen from the rotation centre: x forward, y left.")
    limits: Limits
    connection: Connection
    last_heard_ns: int | None
    state: RobotState
    reason: Reason | None = Field(description="Why it waits or stands still; null while it drives.")
    pose: PoseView | None
    status: StatusView | None
    command: CommandView | None
    assignment: Assignment | None = Field(description="Its newest one, also when that is over.")
    guidance: GuidanceView | None
    manual: ManualView | None
    obstacle_box: ObstacleBox = Field(description="In force: the lab's, with the operator's settings over it.")
    detours: Detours = Field(description="In force: whether and when it drives around what blocks it.")
    settings: RobotSettings = Field(description="What the operator has set; null falls back to the lab description.")

    def without_ages(self) -> "RobotView":
        """The same without what changes by time alone, to tell whether anything new is known."""
        pose = self.pose and self.pose.model_copy(update={"age_s": 0.0})
        status = self.status and self.status.model_copy(update={"age_s": 0.0})
        return self.model_copy(update={"pose": pose, "status": status})


@dataclass(slots=True)
class FleetState:
    """The newest of everything about robots, by robot."""

    poses: Mapping[str, TrackedPose] = field(default_factory=dict[str, TrackedPose])
    statuses: Mapping[str, Status] = field(default_factory=dict[str, Status])
    registrations: Mapping[str, Registration] = field(default_factory=dict[str, Registration])
    commands: Mapping[str, Command] = field(default_factory=dict[str, Command])
    guidance: Mapping[str, GuidanceState] = field(default_factory=dict[str, GuidanceState])
    manual: Mapping[str, ManualDrive] = field(default_factory=dict[str, ManualDrive])
    assignments: Mapping[str, Assignment] = field(default_factory=dict[str, Assignment])
    settings: Mapping[str, RobotSettings] = field(default_factory=dict[str, RobotSettings])
    losses: Mapping[str, float] = field(default_factory=dict[str, float])
    emergency_stop: EmergencyStop = field(default_factory=lambda: EmergencyStop(engaged=False))


def robot_view(vehicle: VehicleSpec, fleet: FleetState, now_ns: int) -> RobotView:
    """How the vehicle looks at `now_ns`."""
    robot = vehicle.id
    pose = _pose(fleet.poses.get(robot), now_ns)
    status = _status(fleet.statuses.get(robot), fleet.losses.get(robot), now_ns)
    command = _command(fleet.commands.get(robot), now_ns)
    guidance = _guidance(fleet.guidance.get(robot), now_ns)
    manual = _manual(fleet.manual.get(robot), now_ns)
    assignment = fleet.assignments.get(robot)
    settings = fleet.settings.get(robot) or RobotSettings()
    connection, last_heard_ns = _connection(fleet, robot, now_ns)
    state, reason = _state(connection, fleet, pose, status, command, manual, assignment)
    if reason is not None and reason.since_ns is None:
        reason = reason.model_copy(update={"since_ns": _since_ns(reason.code, fleet, robot, last_heard_ns)})
    return RobotView(
        id=robot,
        kind=vehicle.kind,
        footprint=vehicle.footprint,
        limits=vehicle.limits,
        connection=connection,
        last_heard_ns=last_heard_ns,
        state=state,
        reason=reason,
        pose=pose,
        status=status,
        command=command,
        assignment=assignment,
        guidance=guidance,
        manual=manual,
        obstacle_box=effective_box(vehicle.obstacle_box, settings),
        detours=effective_detours(vehicle.detours, settings),
        settings=settings,
    )


def _connection(fleet: FleetState, robot: str, now_ns: int) -> tuple[Connection, int | None]:
    stamps = [
        message.stamp_ns
        for message in (fleet.statuses.get(robot), fleet.registrations.get(robot))
        if message is not None
    ]
    if not stamps:
        return Connection.OFFLINE, None
    status = fleet.statuses.get(robot)
    online = status is not None and age_s(status.stamp_ns, now_ns) <= STATUSES.stale_after_s
    return (Connection.ONLINE if online else Connection.CONNECTION_BROKEN), max(stamps)


def _since_ns(code: ReasonCode, fleet: FleetState, robot: str, last_heard_ns: int | None) -> int | None:
    """Since when a reason holds that the server itself has found."""
    pose, status, command = fleet.poses.get(robot), fleet.statuses.get(robot), fleet.commands.get(robot)
    assignment = fleet.assignments.get(robot)
    said = status.stopped_by if status is not None else None
    match code:
        case ReasonCode.NOT_CONNECTED:
            return last_heard_ns
        case ReasonCode.EMERGENCY_STOP:
            return fleet.emergency_stop.stamp_ns or None
        case ReasonCode.POSE_STALE:
            return None if pose is None else pose.stamp_ns
        case ReasonCode.COMMAND_STALE:
            return None if command is None else command.stamp_ns
        case ReasonCode.PAUSED:
            return None if assignment is None else assignment.changed_ns
        case _:
            return said.since_ns if said is not None and said.code is code else None


def _state(
    connection: Connection,
    fleet: FleetState,
    pose: PoseView | None,
    status: StatusView | None,
    command: CommandView | None,
    manual: ManualView | None,
    assignment: Assignment | None,
) -> tuple[RobotState, Reason | None]:
    """What matters most first: a robot that cannot be reached is that before anything else."""
    if connection is not Connection.ONLINE:
        never = connection is Connection.OFFLINE
        text = "no agent has ever connected" if never else "its agent has fallen silent"
        return RobotState.OFFLINE, Reason(code=ReasonCode.NOT_CONNECTED, text=text)
    if fleet.emergency_stop.engaged:
        text = fleet.emergency_stop.reason or f"engaged by {fleet.emergency_stop.by or 'somebody'}"
        return RobotState.EMERGENCY_STOP, Reason(code=ReasonCode.EMERGENCY_STOP, text=text)
    if status is not None and status.stopped_by is not None and status.stopped_by.code is ReasonCode.EMERGENCY_STOP:
        return RobotState.EMERGENCY_STOP, status.stopped_by
    if status is not None and status.faults:
        return RobotState.FAULT, Reason(code=ReasonCode.DRIVER_FAULT, text="; ".join(status.faults))
    if manual is not None:
        return RobotState.MANUAL, Reason(code=ReasonCode.MANUAL, text="driven by hand")
    stopped_by = status.stopped_by if status is not None else None
    active = assignment is not None and not is_over(assignment)
    if pose is None or not pose.fresh:
        text = "no camera has ever seen it" if pose is None else "no camera sees it"
        return RobotState.LOST, Reason(code=ReasonCode.POSE_STALE, text=text)
    if command is None:
        if not active:
            return RobotState.IDLE, stopped_by
        return RobotState.WAITING, Reason(code=ReasonCode.COMMAND_STALE, text="guidance sends no commands")
    if active and assignment is not None and assignment.state is AssignmentState.PAUSED:
        return RobotState.PAUSED, Reason(code=ReasonCode.PAUSED, text=assignment.reason)
    if command.movement is Movement.WAITING:
        return RobotState.WAITING, command.reason
    if command.movement is Movement.NO_ACTION:
        return RobotState.IDLE, command.reason
    if stopped_by is not None:
        return RobotState.WAITING, stopped_by
    return RobotState.DRIVING, None


def _pose(pose: TrackedPose | None, now_ns: int) -> PoseView | None:
    if pose is None:
        return None
    age = age_s(pose.stamp_ns, now_ns)
    xx, xy, _, yy, _, _ = pose.covariance
    # The larger eigenvalue of the position's 2 x 2 covariance.
    variance = (xx + yy) / 2 + ((xx - yy) ** 2 / 4 + xy**2) ** 0.5
    return PoseView(
        x=pose.x,
        y=pose.y,
        yaw=pose.yaw,
        vx=pose.vx,
        vy=pose.vy,
        yaw_rate=pose.yaw_rate,
        stamp_ns=pose.stamp_ns,
        age_s=age,
        fresh=age <= POSES.stale_after_s,
        cameras=pose.cameras,
        area=pose.area,
        position_std_m=max(0.0, variance) ** 0.5,
    )


def _status(status: Status | None, loss: float | None, now_ns: int) -> StatusView | None:
    if status is None:
        return None
    return StatusView(
        stamp_ns=status.stamp_ns,
        age_s=age_s(status.stamp_ns, now_ns),
        x=status.x,
        y=status.y,
        yaw=status.yaw,
        linear_mps=status.linear_mps,
        angular_radps=status.angular_radps,
        ip=status.ip,
        battery=status.battery,
        mode=status.mode,
        faults=status.faults,
        stopped_by=status.stopped_by,
        pose_age_s=status.pose_age_s,
        command_age_s=status.command_age_s,
        command_loss=None if status.command_loss is None else round(status.command_loss, 2),
        loss=loss,
    )


def _command(command: Command | None, now_ns: int) -> CommandView | None:
    if command is None or age_s(command.stamp_ns, now_ns) > COMMANDS.stale_after_s:
        return None
    return CommandView(
        movement=command.movement,
        target=command.target,
        speed_mps=command.speed_mps,
        final=command.final,
        reason=command.reason,
    )


def _guidance(state: GuidanceState | None, now_ns: int) -> GuidanceView | None:
    if state is None or age_s(state.stamp_ns, now_ns) > COMMANDS.stale_after_s:
        return None
    return GuidanceView(
        blocked=state.blocked,
        blockage=state.blockage,
        box=state.box,
        carrot=state.carrot,
        path=state.path,
        detour=state.detour,
        leg=state.leg,
    )


def _manual(drive: ManualDrive | None, now_ns: int) -> ManualView | None:
    if drive is None or drive.expires_ns <= now_ns:
        return None
    return ManualView(
        holder=drive.holder,
        by=drive.by,
        linear_mps=drive.linear_mps,
        angular_radps=drive.angular_radps,
        expires_ns=drive.expires_ns,
    )
