"""One robot's share of guidance: its precedence of reasons, its route and its obstacle box, cycle after cycle."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import shapely
from shapely.geometry.base import BaseGeometry

from geometry import SE2
from mapping.grid import FloorGrid
from protocol.channels import OBSTACLES
from protocol.lab import VehicleSpec
from protocol.messages import (
    Assignment,
    AssignmentState,
    Blockage,
    ManualDrive,
    Movement,
    Reason,
    ReasonCode,
    TrackedPose,
)
from server.effective_box import effective_box
from server.guidance import decision as decide
from server.guidance.blockage import nearest_blockage, observed_share
from server.guidance.box import Body, Box, PlannedPath, footprint_at, obstacle_box, outline, reach_m
from server.guidance.decision import Decision, Ground
from server.guidance.following import Progress, RouteFollower, RoutePlan, Sight, resolve
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point
from server.guidance.snapshot import Snapshot, extrapolated
from server.guidance.turning import swept_by_turning, turn_ahead


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What all robots share in one cycle: the obstacle raster (None: unknown or too old) and the floor that each robot
    covers."""

    grid: FloorGrid | None
    robots: Mapping[str, BaseGeometry]


@dataclass(frozen=True, slots=True)
class View:
    """One robot's result of a cycle: the decision, what the map shows of it, and its assignment as it now is."""

    decision: Decision
    blocked: bool = False
    blockage: Blockage | None = None
    box: tuple[Point, ...] = ()
    carrot: Point | None = None
    path: tuple[Point, ...] = ()
    leg: int | None = None
    assignment: Assignment | None = None


class RobotGuidance:
    """Memory and rules of one robot."""

    def __init__(self, spec: VehicleSpec, ground: Ground, parameters: GuidanceParameters) -> None:
        self._spec = spec
        self._ground = ground
        self._parameters = parameters
        self._assignment_id: str | None = None
        self._follower = RouteFollower(parameters)
        self._blocked_at_s: float | None = None
        self._blocked_by = Reason(code=ReasonCode.OBSTACLE)
        self._hand: ManualDrive | None = None

    def cycle(self, snapshot: Snapshot, around: Surroundings) -> View:
        """What the robot is to do now."""
        robot = self._spec.id
        assignment = snapshot.assignments.get(robot)
        self._meet(assignment)
        pose = snapshot.fresh_pose(robot)
        decision = decide.stopped_by_latch(snapshot)
        hand = snapshot.hand(robot)
        self._hand = hand or self._hand
        if decision is None and hand is not None:
            age_s = snapshot.age_s(pose.stamp_ns) if pose is not None else 0.0
            decision = decide.by_hand(hand, pose, age_s, self._spec, self._ground, self._parameters)
        if decision is None:
            decision = decide.without_work(assignment, snapshot.connected(robot))
        if assignment is None or assignment.state not in (AssignmentState.RUNNING, AssignmentState.PAUSED):
            return View(decision or decide.no_action(ReasonCode.IDLE), assignment=assignment)
        plan = self._plan(snapshot, assignment)
        if isinstance(plan, str):
            failed = _changed(assignment, snapshot, state=AssignmentState.FAILED, reason=plan)
            return View(decision or decide.no_action(ReasonCode.WAYPOINT_MISSING, plan), assignment=failed)
        decision = decision or decide.cannot_follow(robot, snapshot, assignment, pose, self._ground)
        decision = decision or self._hand_lost(snapshot)
        if decision is not None or pose is None:
            self._follower.interrupt()
            return self._standing(decision or decide.wait(ReasonCode.POSE_STALE), snapshot, assignment, plan, pose)
        return self._follow(snapshot, around, assignment, plan, pose)

    def _meet(self, assignment: Assignment | None) -> None:
        """Forgets the last assignment when there is another one."""
        name = assignment.id if assignment is not None else None
        if name != self._assignment_id:
            self._assignment_id = name
            self._follower = RouteFollower(self._parameters)
            self._blocked_at_s = None

    def _plan(self, snapshot: Snapshot, assignment: Assignment) -> RoutePlan | str:
        """The route with its waypoints, or a sentence about what is missing."""
        route = snapshot.routes.get(assignment.route)
        if route is None:
            return f"route {assignment.route} does not exist"
        plan = resolve(route, snapshot.waypoints)
        if isinstance(plan, str):
            return f"waypoint {plan} of route {assignment.route} does not exist"
        if assignment.leg >= len(plan.stops):
            return f"route {assignment.route} has {len(plan.stops)} legs, the robot was on its {assignment.leg + 1}th"
        for leg in range(0 if plan.loop else max(1, assignment.leg), len(plan.stops)):
            start, end = plan.stops[leg - 1], plan.stops[leg]
            place = self._ground.leaving((start.point, end.point))
            if place is not None:
                return (
                    f"the straight way from {start.waypoint.id} to {end.waypoint.id} of route {assignment.route} "
                    f"leaves every area at ({place[0]:.2f}, {place[1]:.2f})"
                )
        return plan

    def _hand_lost(self, snapshot: Snapshot) -> Decision | None:
        """Waiting for a while after a hand's lease ran out without its letting go: that is a broken connection, and whoever
        drove does not expect the robot to go its own way at once. Letting go leaves a record that was never in force: a
        zero twist that ended when it was written."""
        hold_s = self._parameters.manual_lost_hold_s
        hand = snapshot.former_hand(self._spec.id, hold_s)
        if hand is None or (hand.linear_mps == hand.angular_radps == 0.0 and hand != self._hand):
            return None
        return decide.wait(
            ReasonCode.MANUAL, f"the hand of {hand.by} was lost; its route goes on {hold_s:g} s after that"
        )

    def _standing(
        self, decision: Decision, snapshot: Snapshot, assignment: Assignment, plan: RoutePlan, pose: TrackedPose | None
    ) -> View:
        """A robot with a route that does not follow it now: the path is shown all the same."""
        path: tuple[Point, ...] = ()
        if pose is not None:
            here = extrapolated(pose, snapshot.age_s(pose.stamp_ns))
            path = _rounded(self._follower.planned_path(plan, assignment.leg, here))
        return View(decision, path=path, leg=assignment.leg, assignment=assignment)

    def _follow(
        self, snapshot: Snapshot, around: Surroundings, assignment: Assignment, plan: RoutePlan, pose: TrackedPose
    ) -> View:
        measured = Sight(SE2(pose.x, pose.y, pose.yaw), snapshot.at_rest(self._spec.id), snapshot.now_s)
        progress = self._follower.advance(plan, Progress(assignment.leg, assignment.laps), measured)
        if (progress.leg, progress.laps) != (assignment.leg, assignment.laps):
            assignment = _changed(assignment, snapshot, leg=progress.leg, laps=progress.laps)
        if progress.done:
            done = _changed(assignment, snapshot, state=AssignmentState.DONE)
            return View(decide.no_action(ReasonCode.ROUTE_DONE, f"route {done.route} is done"), assignment=done)
        here = extrapolated(pose, snapshot.age_s(pose.stamp_ns))
        stop = plan.stops[progress.leg]
        speed = min(stop.speed_mps * assignment.speed_scale, self._spec.limits.speed_mps)
        goal = self._follower.goal(plan, progress.leg, replace(measured, pose=here), speed)
        path = self._follower.planned_path(plan, progress.leg, here)
        route = Reason(code=ReasonCode.ROUTE, text=f"to {stop.waypoint.id}")
        turn_rad = turn_ahead(here, goal)
        sweep = swept_by_turning(here, turn_rad, self._spec) if turn_rad else None
        blockage: Blockage | None = None
        reason: Reason | None = None
        if goal.turn_to is not None:
            # The robot stays where it is: the obstacle box counts again when it leaves.
            go = Decision(Movement.ROTATE, route, target=goal.target, final=True)
            shown, carrot = sweep, None
        else:
            ahead = self._follower.path_ahead(plan, progress.leg, here)
            go = Decision(
                Movement.MOVE_TO, route, target=goal.target, speed_mps=goal.speed_mps, final=goal.final, path=ahead
            )
            shown, carrot = self._box(snapshot, path, here, pose, speed), (goal.target.x, goal.target.y)
            reason = self._leaves_ground(snapshot, path, speed)
            if reason is None:
                blockage, reason = self._look(around, shown, here, turning=False)
        if reason is None and sweep is not None:
            blockage, reason = self._look(around, sweep, here, turning=True)
        reason = self._debounced(reason, snapshot.now_s)
        return View(
            go if reason is None else Decision(Movement.WAITING, reason),
            blocked=reason is not None,
            blockage=blockage,
            box=outline(shown.area) if shown is not None else (),
            carrot=(round(carrot[0], 3), round(carrot[1], 3)) if carrot is not None else None,
            path=_rounded(path),
            leg=progress.leg,
            assignment=assignment,
        )

    def _leaves_ground(self, snapshot: Snapshot, path: PlannedPath, commanded_mps: float) -> Reason | None:
        """The reason to wait when the path leaves every area within the reach of the obstacle box."""
        size = effective_box(self._spec.obstacle_box, snapshot.settings.get(self._spec.id))
        place = self._ground.leaving(path.points, reach_m(size, self._spec, commanded_mps, self._parameters))
        if place is None:
            return None
        text = f"the way ahead leaves every area at ({place[0]:.2f}, {place[1]:.2f})"
        return Reason(code=ReasonCode.OUTSIDE_AREA, text=text)

    def _box(self, snapshot: Snapshot, path: PlannedPath, here: SE2, pose: TrackedPose, commanded_mps: float) -> Box:
        size = effective_box(self._spec.obstacle_box, snapshot.settings.get(self._spec.id))
        forward = SE2(0.0, 0.0, -here.yaw).apply((pose.vx, pose.vy))
        return obstacle_box(here, path, size, self._spec, commanded_mps, float(forward[0]), self._parameters)

    def _look(
        self, around: Surroundings, box: Box, here: SE2, *, turning: bool
    ) -> tuple[Blockage | None, Reason | None]:
        """What is in the box, or on the floor that a turn sweeps, and the reason to wait for it."""
        if around.grid is None:
            text = f"the obstacle map is missing or older than {OBSTACLES.stale_after_s:g} s"
            return None, Reason(code=ReasonCode.OBSTACLES_UNKNOWN, text=text)
        footprint = footprint_at(here, self._spec)
        own = footprint.buffer(self._parameters.own_margin_m)
        front = Body.of(self._spec).front_m
        blockage = nearest_blockage(self._spec.id, box, own, front, around.grid, around.robots)
        if blockage is not None:
            if turning:  # there is no way ahead along which to measure
                away_m = round(footprint.distance(shapely.Point(blockage.x, blockage.y)), 3)
                blockage = blockage.model_copy(update={"distance_m": away_m})
            beside = "beside it, in the way of its turning," if turning else "ahead"
            where = f"{blockage.distance_m:.2f} m {beside} at ({blockage.x:.2f}, {blockage.y:.2f})"
            if blockage.robot is None:
                return blockage, Reason(code=ReasonCode.OBSTACLE, text=where)
            return blockage, Reason(code=ReasonCode.ROBOT_AHEAD, text=f"{blockage.robot} {where}")
        unseen = 1.0 - observed_share(box.area.intersection(self._ground.area).difference(own), around.grid)
        if unseen > self._parameters.unseen_share:
            return None, Reason(
                code=ReasonCode.OBSTACLES_UNKNOWN,
                text=f"no camera sees {unseen:.0%} of the {'floor around' if turning else 'way ahead'}",
            )
        return None, None

    def _debounced(self, reason: Reason | None, now_s: float) -> Reason | None:
        """Blocked at once; clear only after a while of being clear."""
        if reason is not None:
            self._blocked_at_s, self._blocked_by = now_s, reason
            return reason
        if self._blocked_at_s is not None and now_s - self._blocked_at_s < self._parameters.clear_for_s:
            return self._blocked_by
        self._blocked_at_s = None
        return None


def _changed(assignment: Assignment, snapshot: Snapshot, **changes: object) -> Assignment:
    # `changed_ns` grows with every write, whatever the clock does: the service compares it.
    return assignment.model_copy(update={**changes, "changed_ns": max(snapshot.now_ns, assignment.changed_ns + 1)})


def _rounded(path: PlannedPath) -> tuple[Point, ...]:
    return tuple((round(x, 3), round(y, 3)) for x, y in path.points)
