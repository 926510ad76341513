"""The core of guidance: a snapshot goes in, a command for every vehicle of the lab comes out, with what changed and what is
to be told. Pure: no Redis, no clock, no chance."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace

from mapping.grid import FloorGrid
from protocol.channels import OBSTACLES
from protocol.errors import DecodeError
from protocol.lab import Lab
from protocol.messages import Event, EventLevel, FloorRaster, Movement, ReasonCode, SpeedZone
from server.guidance.blockage import robot_shapes
from server.guidance.decision import Ground
from server.guidance.floor_sums import FloorSums
from server.guidance.parameters import GuidanceParameters
from server.guidance.robot import RobotGuidance
from server.guidance.snapshot import AssignmentChange, Outcome, Snapshot
from server.guidance.speed_limits import SpeedLimits
from server.guidance.telling import DeadlockWatch, ProgressWatch, reason_event
from server.guidance.unblocking import Unblocking
from server.guidance.view import Surroundings, View
from server.guidance.wording import Cycle, Wording
from server.repositories.speed_zones import speed_zones_of

_NS = 1_000_000_000


class Guidance:
    """Guides the vehicles of a lab. Commands of an instance are ordered by their sequence, which never repeats."""

    def __init__(self, lab: Lab, parameters: GuidanceParameters | None = None, *, said: int = 0) -> None:
        self._parameters = parameters or GuidanceParameters()
        self._vehicles = {vehicle.id: vehicle for vehicle in lab.vehicles}
        ground = Ground(lab.areas)
        self._robots = {name: RobotGuidance(spec, ground, self._parameters) for name, spec in self._vehicles.items()}
        self._sequence = said
        self._told: dict[str, tuple[ReasonCode, str | None, bool]] = {}
        self._since: dict[str, tuple[ReasonCode, int]] = {}
        self._dated_of: dict[str, tuple[View, View]] = {}
        self._wording = Wording()
        self._deadlocks = DeadlockWatch(self._parameters.deadlock_s)
        self._progress = ProgressWatch(self._parameters.no_progress_s)
        self._raster: FloorRaster | None = None
        self._known_grid: FloorGrid | None = None
        self._sums: FloorSums | None = None
        self._unblocking = Unblocking(self._robots, ground, self._parameters)
        self._lab_zones = tuple(speed_zones_of(lab).values())
        self._limits = SpeedLimits(self._lab_zones, self._parameters)
        self._drawn_zones: Mapping[str, SpeedZone] = {}

    @property
    def sequence(self) -> int:
        """Of the commands that were said last; another guidance that goes on from there takes it as `said`."""
        return self._sequence

    def cycle(self, snapshot: Snapshot, epoch: int) -> Outcome:
        """One cycle at the snapshot's time, as the guidance of that epoch."""
        self._sequence += 1
        events: list[Event] = []
        grid = self._grid(snapshot)
        robots = robot_shapes(self._vehicles, snapshot, self._parameters)
        around = Surroundings(grid, self._sums, robots, self._speed_limits(snapshot))
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
        watch = self._deadlocks
        events.extend(watch.look(waits_for, snapshot))
        events.extend(self._unblocking.look(views, watch.rings, watch.lasting, snapshot, around))
        events.extend(self._progress.look(views, snapshot))
        deadline_ns = snapshot.now_ns + round(self._parameters.command_lifetime_s * _NS)
        commands, states = self._wording.say(views, Cycle(epoch, self._sequence, snapshot.now_ns, deadline_ns))
        return Outcome(
            commands=commands,
            states=states,
            changes=tuple(_changes(views, snapshot)),
            events=tuple(events),
        )

    def _dated(self, robot: str, view: View, snapshot: Snapshot) -> View:
        """The view with the time since when its reason's code holds; the very same as a cycle ago where nothing is new."""
        before = self._dated_of.get(robot)
        if before is not None and before[0] == view:
            return before[1]
        decision = view.decision
        code, since_ns = self._since.get(robot, (None, 0))
        if code != decision.reason.code:
            since_ns = snapshot.now_ns
            self._since[robot] = decision.reason.code, since_ns
        reason = decision.reason.model_copy(update={"since_ns": since_ns})
        dated = replace(view, decision=replace(decision, reason=reason))
        self._dated_of[robot] = view, dated
        return dated

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

    def _speed_limits(self, snapshot: Snapshot) -> SpeedLimits:
        """Of the lab's zones and those that operators drew, which may be other ones at any time."""
        if snapshot.speed_zones != self._drawn_zones:
            self._drawn_zones = dict(snapshot.speed_zones)
            self._limits = SpeedLimits((*self._lab_zones, *self._drawn_zones.values()), self._parameters)
        return self._limits

    def _grid(self, snapshot: Snapshot) -> FloorGrid | None:
        """The obstacle map while it is fresh; read once per raster."""
        raster = snapshot.obstacles
        if raster is not self._raster:
            self._raster, self._known_grid, self._sums = raster, None, None
            with suppress(DecodeError):  # an obstacle map that contradicts itself is none
                self._known_grid = FloorGrid.from_raster(raster) if raster is not None else None
                self._sums = FloorSums(self._known_grid) if self._known_grid is not None else None
        fresh = raster is not None and snapshot.age_s(raster.stamp_ns) <= OBSTACLES.stale_after_s
        return self._known_grid if fresh else None


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
