"""One robot's share of guidance: its precedence of reasons, its route and its obstacle box, cycle after cycle."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from geometry import SE2
from mapping.grid import CELL_M
from protocol.lab import VehicleSpec
from protocol.messages import (
    Assignment,
    AssignmentState,
    ManualDrive,
    Movement,
    Reason,
    ReasonCode,
    Route,
    TrackedPose,
)
from server.effective_box import effective_box, effective_detours
from server.guidance import decision as decide
from server.guidance.box import Body, BoxRequest, PlannedPath, outline
from server.guidance.decision import Decision, Ground
from server.guidance.following import Detour, Goal, RouteFollower, Sight
from server.guidance.lookout import Lookout, Seen
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point
from server.guidance.route_plan import Progress, RoutePlan, resolve
from server.guidance.snapshot import Snapshot, extrapolated
from server.guidance.staying import reason_to_stay
from server.guidance.stepping_aside import Aside
from server.guidance.stuck import Stuck
from server.guidance.turning import swept_by_turning, turn_ahead
from server.guidance.view import Surroundings, View
from server.guidance.way_out import Blocked


@dataclass(frozen=True, slots=True)
class _Way:
    """Where a robot is to go now: what to ask of it, the path ahead, the line for controllers that follow one, the speed that it
    may have (m/s) and why it goes there."""

    goal: Goal
    path: PlannedPath
    line: tuple[Point, ...]
    speed_mps: float
    reason: Reason


@dataclass(frozen=True, slots=True)
class _Planned:
    """A plan with what it was made of."""

    key: tuple[int, bool]
    parts: Sequence[object]
    plan: RoutePlan | str


class RobotGuidance:
    """Memory and rules of one robot."""

    def __init__(self, spec: VehicleSpec, ground: Ground, parameters: GuidanceParameters) -> None:
        self.spec = spec
        self._ground = ground
        self._parameters = parameters
        self._radius_m = max(math.hypot(x, y) for x, y in spec.footprint)
        self._assigned: tuple[str, int, int] | None = None
        self._lookout = Lookout(spec, ground, parameters)
        self._follower = RouteFollower(parameters)
        self._blocked_at_s: float | None = None
        self._blocked_by = Reason(code=ReasonCode.OBSTACLE)
        self._hand: ManualDrive | None = None
        self._aside: Aside | None = None
        self._aside_over = False
        self._back_again_s = 0.0
        self._planned: _Planned | None = None
        self.stuck = Stuck()

    def cycle(self, snapshot: Snapshot, around: Surroundings) -> View:
        """What the robot is to do now."""
        robot = self.spec.id
        assignment = snapshot.assignments.get(robot)
        self._meet(assignment)
        pose = snapshot.fresh_pose(robot)
        decision = decide.stopped_by_latch(snapshot)
        hand = snapshot.hand(robot)
        self._hand = hand or self._hand
        if decision is None and hand is not None:
            age_s = snapshot.age_s(pose.stamp_ns) if pose is not None else 0.0
            decision = decide.by_hand(
                hand, pose, age_s, self.spec, self._ground, self._parameters, self._zone_mps(pose, around)
            )
        if decision is None:
            decision = decide.without_work(assignment, snapshot.connected(robot))
        if assignment is None or assignment.state not in (AssignmentState.RUNNING, AssignmentState.PAUSED):
            return self._idle(decision or decide.no_action(ReasonCode.IDLE), snapshot, assignment)
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

    def divert(self, detours: Mapping[int, Detour]) -> None:
        """Makes a detour from now on."""
        self._follower.divert(detours)
        self._aside, self._blocked_at_s, self.stuck = None, None, Stuck()

    def step_aside(self, aside: Aside) -> None:
        """Drives out of the way from now on."""
        self._aside, self._aside_over, self._back_again_s = aside, False, 0.0
        self._blocked_at_s, self.stuck = None, Stuck()

    def come_back(self, detours: Mapping[int, Detour] | None, now_s: float) -> None:
        """Returns to the route after having been aside; where no way back was found (None) it waits for one."""
        if detours is None:
            self._back_again_s = now_s + self._parameters.retry_s
        else:
            self.divert(detours)

    def stay_no_more_aside(self) -> None:
        """Gives up going aside, and goes straight to the end of its leg."""
        self._follower = RouteFollower(self._parameters)
        self._aside, self.stuck = None, Stuck()

    def wants_back(self, now_s: float) -> bool:
        """Whether the robot is aside, nobody has to be let pass any more, and it is time to look for the way back."""
        return self._aside is not None and self._aside_over and now_s >= self._back_again_s

    @property
    def is_aside(self) -> bool:
        """Whether the robot is out of the way, or on its way there."""
        return self._aside is not None

    def look_aside(self, paths: Mapping[str, tuple[Point, ...]], now_s: float) -> None:
        """Looks whether those for whom the robot is aside have passed."""
        if self._aside is not None:
            self._aside_over = self._aside.over(paths, now_s)

    def blocked(self, snapshot: Snapshot, place: Point | None, why: str) -> Blocked | None:
        """What a search for a way out must know of the robot; None when it has no route to come back to, or is not seen."""
        assignment, pose = snapshot.assignments.get(self.spec.id), snapshot.fresh_pose(self.spec.id)
        plan = self._plan(snapshot, assignment) if assignment is not None else ""
        if assignment is None or pose is None or isinstance(plan, str):
            return None
        settings = snapshot.settings.get(self.spec.id)
        size, detours = effective_box(self.spec.obstacle_box, settings), effective_detours(self.spec.detours, settings)
        body = Body.of(self.spec)
        return Blocked(
            spec=self.spec,
            pose=extrapolated(pose, snapshot.age_s(pose.stamp_ns)),
            plan=plan,
            leg=assignment.leg,
            follower=self._follower,
            place=place,
            why=why,
            room_m=max(body.half_width_m + detours.clearance_m, size.width_m / 2 + CELL_M),
            unknown=size.unknown,
        )

    def _meet(self, assignment: Assignment | None) -> None:
        """Forgets what is not true any more when there is another assignment, or a person sent the robot to another leg."""
        met = _key(assignment)
        if met != self._assigned:
            self._assigned = met
            self._follower = RouteFollower(self._parameters)
            self._blocked_at_s, self._aside, self.stuck = None, None, Stuck()

    def _idle(self, decision: Decision, snapshot: Snapshot, assignment: Assignment | None) -> View:
        """A robot whose route is over begins with the next of its queue. After a failure, and while the emergency stop is
        engaged, that waits."""
        over = assignment is not None and assignment.state in (AssignmentState.DONE, AssignmentState.STOPPED)
        if assignment is None or not over or not assignment.queue or decide.stopped_by_latch(snapshot) is not None:
            return View(decision, assignment=assignment)
        entry, *rest = assignment.queue
        begun = Assignment(
            id=entry.id,
            robot=assignment.robot,
            route=entry.route,
            state=AssignmentState.RUNNING,
            speed_scale=entry.speed_scale,
            started_ns=snapshot.now_ns,
            changed_ns=max(snapshot.now_ns, assignment.changed_ns + 1),
            started_by=entry.queued_by,
            queue=tuple(rest),
        )
        return View(decision, assignment=begun)

    def _plan(self, snapshot: Snapshot, assignment: Assignment) -> RoutePlan | str:
        """The route with its waypoints, or a sentence about what is missing. Looked up anew only when any of it is."""
        route = snapshot.routes.get(assignment.route)
        if route is None:
            return f"route {assignment.route} does not exist"
        parts = [route, *(snapshot.waypoints.get(leg.waypoint) for leg in route.legs)]
        key = (assignment.leg, bool(assignment.queue))
        known = self._planned
        if known is None or known.key != key or not _same(known.parts, parts):
            known = self._planned = _Planned(key, parts, self._resolved(route, snapshot, assignment))
        return known.plan

    def _resolved(self, route: Route, snapshot: Snapshot, assignment: Assignment) -> RoutePlan | str:
        plan = resolve(route, snapshot.waypoints)
        if isinstance(plan, str):
            return f"waypoint {plan} of route {assignment.route} does not exist"
        if assignment.leg >= len(plan.stops):
            return f"route {assignment.route} has {len(plan.stops)} legs, the robot was on its {assignment.leg + 1}th"
        if assignment.queue:
            plan = replace(plan, loop=False)  # what waits begins at the end of the lap
        for start, end in plan.ways(assignment.leg):
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
        hand = snapshot.former_hand(self.spec.id, hold_s)
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
        self.stuck = Stuck()
        if pose is not None:
            here = extrapolated(pose, snapshot.age_s(pose.stamp_ns))
            path = _rounded(self._follower.planned_path(plan, assignment.leg, here).points)
        return View(decision, path=path, leg=assignment.leg, assignment=assignment)

    def _stay(self, snapshot: Snapshot, assignment: Assignment, plan: RoutePlan, pose: TrackedPose) -> View | None:
        """A robot at the end of a leg for as long as it has something to do there; None when it may go on."""
        leg = plan.stops[assignment.leg].leg
        reason = reason_to_stay(leg, assignment, snapshot.statuses.get(self.spec.id), snapshot.now_ns)
        if reason is None:
            return None
        decision = Decision(Movement.WAITING, reason, action=leg.action)
        return self._standing(decision, snapshot, assignment, plan, pose)

    def _follow(
        self, snapshot: Snapshot, around: Surroundings, assignment: Assignment, plan: RoutePlan, pose: TrackedPose
    ) -> View:
        measured = Sight(SE2(pose.x, pose.y, pose.yaw), snapshot.at_rest(self.spec.id), snapshot.now_s)
        here = extrapolated(pose, snapshot.age_s(pose.stamp_ns))
        if self._aside is not None:
            return self._make_way(snapshot, around, assignment, plan, pose, here)
        progress = Progress(assignment.leg, assignment.laps)
        if assignment.at_stop_ns is None:
            progress = self._follower.advance(plan, progress, measured)
            if progress.staying:
                assignment = _changed(assignment, snapshot, at_stop_ns=snapshot.now_ns)
        if assignment.at_stop_ns is not None:
            staying = self._stay(snapshot, assignment, plan, pose)
            if staying is not None:
                return staying
            progress = self._follower.depart(plan, Progress(assignment.leg, assignment.laps))
        if (progress.leg, progress.laps) != (assignment.leg, assignment.laps) or progress.done:
            changes: dict[str, object] = {
                "leg": progress.leg,
                "laps": progress.laps,
                "at_stop_ns": None,
                "proceed": False,
            }
            if progress.done:
                changes["state"] = AssignmentState.DONE
            assignment = _changed(assignment, snapshot, **changes)
            self._assigned = _key(assignment)
        if progress.done:
            return View(
                decide.no_action(ReasonCode.ROUTE_DONE, f"route {assignment.route} is done"), assignment=assignment
            )
        stop = plan.stops[progress.leg]
        path = self._follower.planned_path(plan, progress.leg, here)
        speed = self._limited(min(stop.speed_mps * assignment.speed_scale, self.spec.limits.speed_mps), path, around)
        goal = self._follower.goal(plan, progress.leg, replace(measured, pose=here), speed)
        detour = self._follower.detour
        reason = Reason(code=ReasonCode.ROUTE, text=f"to {stop.waypoint.id}")
        if detour is not None:
            text = f"{detour.why}, on the way to {stop.waypoint.id}"
            reason = Reason(code=ReasonCode.DETOUR, text=text)
        line = () if goal.turn_to is not None else self._follower.path_ahead(plan, progress.leg, here)
        view = self._drive(snapshot, around, pose, here, _Way(goal, path, line, speed, reason))
        left = self._follower.detour_ahead(here)
        return replace(view, leg=progress.leg, assignment=assignment, detour=_rounded(left))

    def _make_way(
        self,
        snapshot: Snapshot,
        around: Surroundings,
        assignment: Assignment,
        plan: RoutePlan,
        pose: TrackedPose,
        here: SE2,
    ) -> View:
        """A robot that lets others pass: on its way aside, or there."""
        assert self._aside is not None
        aside, names = self._aside, ", ".join(sorted(self._aside.others))
        why = "has no way back to its route yet" if self._aside_over else f"lets {names} pass"
        reason = Reason(code=ReasonCode.YIELDING, text=why)
        if aside.there(here, snapshot.at_rest(self.spec.id)):
            return self._standing(Decision(Movement.WAITING, reason), snapshot, assignment, plan, pose)
        speed = plan.stops[assignment.leg].speed_mps * assignment.speed_scale
        goal, path = aside.goal(here, min(speed, self.spec.limits.speed_mps), self._parameters)
        limited = self._limited(goal.speed_mps, path, around)
        goal = replace(goal, speed_mps=limited)
        view = self._drive(snapshot, around, pose, here, _Way(goal, path, _rounded(path.points), limited, reason))
        return replace(view, leg=assignment.leg, assignment=assignment, detour=_rounded(path.points))

    def _drive(self, snapshot: Snapshot, around: Surroundings, pose: TrackedPose, here: SE2, way: "_Way") -> View:
        """A robot that goes its way, as far as what is in its obstacle box, or around it where it turns, lets it."""
        goal = way.goal
        turn_rad = turn_ahead(here, goal)
        sweep = swept_by_turning(here, turn_rad, self.spec) if turn_rad else None
        if goal.turn_to is not None:
            # The robot stays where it is: the obstacle box counts again when it leaves.
            go = Decision(Movement.ROTATE, way.reason, target=goal.target, final=True)
            seen, carrot = Seen(outline(sweep.area) if sweep is not None else ()), None
        else:
            go = Decision(
                Movement.MOVE_TO,
                way.reason,
                target=goal.target,
                speed_mps=goal.speed_mps,
                final=goal.final,
                path=way.line,
            )
            size = effective_box(self.spec.obstacle_box, snapshot.settings.get(self.spec.id))
            forward_mps = pose.vx * math.cos(here.yaw) + pose.vy * math.sin(here.yaw)
            box = BoxRequest(here, way.path, size, self.spec, way.speed_mps, forward_mps, self._parameters)
            seen, carrot = self._lookout.ahead(around, box), (goal.target.x, goal.target.y)
        if seen.reason is None and sweep is not None:
            seen = replace(self._lookout.turning(around, sweep, here), outline=seen.outline)
        reason, blockage = seen.reason, seen.blockage
        self.stuck = self.stuck.after(reason, blockage, snapshot.now_s)
        reason = self._debounced(reason, snapshot.now_s)
        if reason is not None and self.stuck.in_vain:
            reason = reason.model_copy(update={"text": f"{reason.text}; {self.stuck.in_vain}"})
        return View(
            go if reason is None else Decision(Movement.WAITING, reason),
            blocked=reason is not None,
            blockage=blockage,
            box=seen.outline,
            carrot=(round(carrot[0], 3), round(carrot[1], 3)) if carrot is not None else None,
            path=_rounded(way.path.points),
        )

    def _limited(self, speed_mps: float, path: PlannedPath, around: Surroundings) -> float:
        """The speed, no higher than the zones along the path allow."""
        limit = around.limits.along(path.points, self._radius_m, speed_mps)
        return speed_mps if limit is None else limit.speed_mps

    def _zone_mps(self, pose: TrackedPose | None, around: Surroundings) -> float:
        """The limit of the zone that the robot is in."""
        limit = around.limits.at((pose.x, pose.y), self._radius_m) if pose is not None else None
        return math.inf if limit is None else limit.speed_mps

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


def _rounded(points: Sequence[Point]) -> tuple[Point, ...]:
    return tuple((round(x, 3), round(y, 3)) for x, y in points)


def _same(before: Sequence[object], now: Sequence[object]) -> bool:
    """Whether both are made of the very same objects; what was read anew and is equal is no harm, only work."""
    return len(before) == len(now) and all(a is b for a, b in zip(before, now, strict=True))


def _key(assignment: Assignment | None) -> tuple[str, int, int] | None:
    """What guidance knows an assignment by: it moves it from leg to leg itself."""
    return None if assignment is None else (assignment.id, assignment.leg, assignment.laps)
