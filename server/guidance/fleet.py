"""The core of guidance: a snapshot goes in, a command for every vehicle of the lab comes out, with what changed and what is
to be told. Pure: no Redis, no clock, no chance."""

from collections.abc import Mapping
from dataclasses import replace

from mapping.grid import FloorGrid
from protocol.channels import OBSTACLES
from protocol.errors import DecodeError
from protocol.lab import Lab
from protocol.messages import Command, Event, EventLevel, GuidanceState, Movement, ReasonCode
from server.guidance.blockage import robot_shapes
from server.guidance.decision import Ground
from server.guidance.parameters import GuidanceParameters
from server.guidance.robot import RobotGuidance, Surroundings, View
from server.guidance.snapshot import AssignmentChange, Outcome, Snapshot
from server.guidance.telling import DeadlockWatch, ProgressWatch, reason_event

_NS = 1_000_000_000


class Guidance:
    """Guides the vehicles of a lab. Commands of an instance are ordered by their sequence, which never repeats."""

    def __init__(self, lab: Lab, parameters: GuidanceParameters | None = None) -> None:
        self._parameters = parameters or GuidanceParameters()
        self._vehicles = {vehicle.id: vehicle for vehicle in lab.vehicles}
        ground = Ground(lab.areas)
        self._robots = {name: RobotGuidance(spec, ground, self._parameters) for name, spec in self._vehicles.items()}
        self._sequence = 0
        self._told: dict[str, tuple[ReasonCode, str | None, bool]] = {}
        self._since: dict[str, tuple[ReasonCode, int]] = {}
        self._deadlocks = DeadlockWatch(self._parameters.deadlock_s)
        self._progress = ProgressWatch(self._parameters.no_progress_s)

    def cycle(self, snapshot: Snapshot, epoch: int) -> Outcome:
        """One cycle at the snapshot's time, as the guidance of that epoch."""
        self._sequence += 1
        events: list[Event] = []
        grid = self._grid(snapshot)
        around = Surroundings(grid, robot_shapes(self._vehicles, snapshot, self._parameters))
        views = {
            name: self._dated(name, robot.cycle(snapshot, around), snapshot) for name, robot in self._robots.items()
        }
        for name, view in views.items():
            events.extend(self._told_of(name, view, snapshot))
        waits_for = {
            name: view.blockage.robot
            for name, view in views.items()
            if view.decision.reason.code is ReasonCode.ROBOT_AHEAD and view.blockage and view.blockage.robot
        }
        events.extend(self._deadlocks.look(waits_for, snapshot))
        events.extend(self._progress.look(views, snapshot))
        return Outcome(
            commands={name: self._command(name, view, snapshot, epoch) for name, view in views.items()},
            states={name: _state(name, view, snapshot) for name, view in views.items()},
            changes=tuple(_changes(views, snapshot)),
            events=tuple(events),
        )

    def _command(self, robot: str, view: View, snapshot: Snapshot, epoch: int) -> Command:
        decision = view.decision
        return Command(
            robot=robot,
            epoch=epoch,
            sequence=self._sequence,
            stamp_ns=snapshot.now_ns,
            deadline_ns=snapshot.now_ns + round(self._parameters.command_lifetime_s * _NS),
            movement=decision.movement,
            reason=decision.reason,
            target=decision.target,
            speed_mps=decision.speed_mps,
            final=decision.final,
            path=decision.path,
            linear_mps=decision.linear_mps,
            angular_radps=decision.angular_radps,
        )

    def _dated(self, robot: str, view: View, snapshot: Snapshot) -> View:
        """The view with the time since when its reason's code holds."""
        decision = view.decision
        code, since_ns = self._since.get(robot, (None, 0))
        if code != decision.reason.code:
            since_ns = snapshot.now_ns
            self._since[robot] = decision.reason.code, since_ns
        reason = decision.reason.model_copy(update={"since_ns": since_ns})
        return replace(view, decision=replace(decision, reason=reason))

    def _told_of(self, robot: str, view: View, snapshot: Snapshot) -> list[Event]:
        """An event when a robot's reason, or the robot that it waits for, changed; nothing about what was so at the start."""
        waiting = view.decision.movement is Movement.WAITING
        other = view.blockage.robot if view.blockage is not None and waiting else None
        # A hand that drives and a hand that was lost have the same code.
        reason = (view.decision.reason.code, other, waiting)
        before = self._told.get(robot)
        self._told[robot] = reason
        if before is None or before == reason:
            return []
        return [reason_event(robot, view.decision, snapshot.now_ns)]

    def _grid(self, snapshot: Snapshot) -> FloorGrid | None:
        raster = snapshot.obstacles
        if raster is None or snapshot.age_s(raster.stamp_ns) > OBSTACLES.stale_after_s:
            return None
        try:
            return FloorGrid.from_raster(raster)
        except DecodeError:
            return None  # an obstacle map that contradicts itself is none


def takeover_event(epoch: int, now_ns: int) -> Event:
    """That this guidance is the active one from now on."""
    return Event(
        stamp_ns=now_ns,
        level=EventLevel.INFO,
        source="guidance",
        kind="guidance_active",
        text=f"guidance is active, epoch {epoch}",
    )


def _changes(views: Mapping[str, View], snapshot: Snapshot) -> list[AssignmentChange]:
    changes: list[AssignmentChange] = []
    for name, view in views.items():
        before = snapshot.assignments.get(name)
        if before is not None and view.assignment is not None and view.assignment != before:
            changes.append(AssignmentChange(before, view.assignment))
    return changes


def _state(robot: str, view: View, snapshot: Snapshot) -> GuidanceState:
    return GuidanceState(
        robot=robot,
        stamp_ns=snapshot.now_ns,
        reason=view.decision.reason,
        blocked=view.blocked,
        blockage=view.blockage,
        box=view.box,
        carrot=view.carrot,
        path=view.path,
        leg=view.leg,
    )
