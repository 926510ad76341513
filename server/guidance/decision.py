"""What one robot is to do now, for reasons in the order of their weight: emergency stop, hand on the stick, connection,
assignment, pose, area (spec gpss, "Safety"). What the route and the obstacle box say is added by `robot`."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely
from shapely.geometry import LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from geometry import SE2
from protocol.lab import Area, VehicleSpec
from protocol.messages import (
    Assignment,
    AssignmentState,
    ManualDrive,
    Movement,
    Reason,
    ReasonCode,
    StopAction,
    Target,
    TrackedPose,
)
from server.guidance.line import Line
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point as PathPoint
from server.guidance.snapshot import Snapshot, extrapolated

_SEAM_M = 0.02
"""A path along a border, or over a seam between two areas that were measured apart, does not leave them."""


@dataclass(frozen=True, slots=True)
class Decision:
    """A command without its addressing."""

    movement: Movement
    reason: Reason
    target: Target | None = None
    speed_mps: float = 0.0
    final: bool = False
    path: tuple[PathPoint, ...] = ()
    action: StopAction | None = None
    linear_mps: float = 0.0
    angular_radps: float = 0.0


# Most robots are told the same cycle after cycle, and many the same as others.
@lru_cache(maxsize=1024)
def no_action(code: ReasonCode, text: str = "") -> Decision:
    return Decision(Movement.NO_ACTION, Reason(code=code, text=text))


@lru_cache(maxsize=1024)
def wait(code: ReasonCode, text: str = "") -> Decision:
    return Decision(Movement.WAITING, Reason(code=code, text=text))


class Ground:
    """The areas of a lab, joined: where robots may be."""

    def __init__(self, areas: Sequence[Area]) -> None:
        self.area: BaseGeometry = shapely.union_all([Polygon(area.outline) for area in areas])
        self._tolerant = self.area.buffer(_SEAM_M, join_style="mitre")
        box = shapely.box(*self.area.bounds)
        self._rectangle = self.area.bounds if self.area.equals(box) else None
        shapely.prepare(self.area)
        shapely.prepare(self._tolerant)

    def contains(self, x: float, y: float) -> bool:
        return bool(self.area.covers(Point(x, y)))

    def leaving(self, path: Sequence[PathPoint], within_m: float = math.inf) -> PathPoint | None:
        """Where the path first leaves every area, within so many metres along it; None when it does not."""
        if not path:
            return None
        near = Line(path)
        points = near.part(0.0, min(within_m, near.length_m))
        if len(points) < 2 or self._within_rectangle(points):
            return None
        line = LineString(points)
        if self._tolerant.covers(line):
            return None
        outside = shapely.get_coordinates(line.difference(self._tolerant))
        along = np.asarray(shapely.line_locate_point(line, shapely.points(outside)))
        first = outside[int(np.argmin(along))]
        return float(first[0]), float(first[1])

    def _within_rectangle(self, points: Sequence[PathPoint]) -> bool:
        """Whether the ground is a rectangle along the axes with all these points in it: then so is what is between them."""
        if self._rectangle is None:
            return False
        low_x, low_y, high_x, high_y = self._rectangle
        return all(low_x <= x <= high_x and low_y <= y <= high_y for x, y in points)

    def distance(self, x: float, y: float) -> float:
        """Metres to the nearest point of an area, 0 inside."""
        return float(self.area.distance(Point(x, y)))


def stopped_by_latch(snapshot: Snapshot) -> Decision | None:
    """What outranks everything else: the emergency stop."""
    latch = snapshot.emergency_stop
    if latch is None or not latch.engaged:
        return None
    by = f" by {latch.by}" if latch.by else ""
    return wait(ReasonCode.EMERGENCY_STOP, f"engaged{by}" + (f": {latch.reason}" if latch.reason else ""))


def by_hand(
    hand: ManualDrive,
    pose: TrackedPose | None,
    age_s: float,
    spec: VehicleSpec,
    ground: Ground,
    p: GuidanceParameters,
    zone_mps: float = math.inf,
) -> Decision:
    """The hand's twist within the vehicle's limits, and within `zone_mps` where the robot is. Obstacles are the hand's business,
    the border of the area is not: a robot inside stops before it, one outside may only come nearer. A robot that no camera
    sees is not driven at all: it would refuse (its own dead-man's switch wants a pose), and nobody could keep it from people
    and walls."""
    if pose is None:
        return wait(ReasonCode.POSE_STALE, f"{hand.by} cannot drive it by hand: no camera sees it")
    limits = spec.limits
    linear = _clip(hand.linear_mps, min(limits.speed_mps, zone_mps))
    angular = _clip(hand.angular_radps, limits.yaw_rate_radps)
    text = f"driven by {hand.by}"
    if linear and not _may_go(extrapolated(pose, age_s), linear, spec, ground, p):
        linear, text = 0.0, f"{text}, held at the border of the area"
    return Decision(Movement.DRIVE, Reason(code=ReasonCode.MANUAL, text=text), linear_mps=linear, angular_radps=angular)


def without_work(assignment: Assignment | None, connected: bool) -> Decision | None:
    """NoAction when nothing is to be done, else None."""
    active = assignment is not None and assignment.state in (AssignmentState.RUNNING, AssignmentState.PAUSED)
    if active:
        return None
    if not connected:
        return no_action(ReasonCode.NOT_CONNECTED, "the robot does not report")
    if assignment is None or assignment.state is AssignmentState.STOPPED:
        return no_action(ReasonCode.IDLE)
    if assignment.state is AssignmentState.DONE:
        return no_action(ReasonCode.ROUTE_DONE, f"route {assignment.route} is done")
    return no_action(ReasonCode.WAYPOINT_MISSING, assignment.reason or f"route {assignment.route} failed")


def cannot_follow(
    robot: str, snapshot: Snapshot, assignment: Assignment, pose: TrackedPose | None, ground: Ground
) -> Decision | None:
    """Waiting when a robot with a route cannot drive it now, whatever stands in its way; else None."""
    if not snapshot.connected(robot):
        return wait(ReasonCode.NOT_CONNECTED, "the robot does not report")
    if assignment.state is AssignmentState.PAUSED:
        return wait(ReasonCode.PAUSED, f"route {assignment.route} is paused")
    if pose is None:
        last = snapshot.poses.get(robot)
        if last is None:
            return wait(ReasonCode.POSE_STALE, "no camera has seen the robot yet")
        return wait(
            ReasonCode.POSE_STALE,
            f"last seen {snapshot.age_s(last.stamp_ns):.1f} s ago at ({last.x:.2f}, {last.y:.2f})",
        )
    if not ground.contains(pose.x, pose.y):
        return wait(ReasonCode.OUTSIDE_AREA, f"({pose.x:.2f}, {pose.y:.2f}) is in no area; drive it back by hand")
    return None


def _may_go(pose: SE2, linear: float, spec: VehicleSpec, ground: Ground, p: GuidanceParameters) -> bool:
    """Whether the robot could still stop in an area, or comes nearer to one."""
    travel = linear * p.reaction_s + math.copysign(linear**2 / (2 * spec.limits.braking_mps2), linear)
    x, y = pose.x + travel * math.cos(pose.yaw), pose.y + travel * math.sin(pose.yaw)
    if ground.contains(pose.x, pose.y):
        return ground.contains(x, y)
    return ground.distance(x, y) < ground.distance(pose.x, pose.y)


def _clip(value: float, limit: float) -> float:
    return min(limit, max(-limit, value))
