"""Who looks for a way out, and which: robots that have waited long enough drive around what blocks them; of robots that wait for
each other one yields.

The rule for a ring (two robots nose to nose are the smallest): the one with the least priority yields, of equals the last by
id; it drives around the others if it can do so clear of where they are about to drive, and else out of their way, to come
back when they have passed. If it can do neither, the next one tries. The rule names the same robot every time, so that
robots do not take turns in yielding; and one that went around in vain steps aside the next time. Searches take time: there
are only so many per cycle.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from shapely.geometry import MultiLineString
from shapely.geometry.base import BaseGeometry

from protocol.lab import VehicleSpec
from protocol.messages import Event, EventLevel, RobotSettings
from server.effective_box import effective_box, effective_detours
from server.guidance.box import Body
from server.guidance.decision import Ground
from server.guidance.line import Line
from server.guidance.line_driving import LineDriver
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point
from server.guidance.robot import RobotGuidance
from server.guidance.snapshot import Snapshot
from server.guidance.stepping_aside import Aside
from server.guidance.view import Surroundings, View
from server.guidance.way_out import Floor, NoWay, lane_of, way_around, way_aside

_STANDS_MPS = 0.05
_LANE_M = 3.0
"""How far ahead of the others a robot that drives around them keeps off their lanes; one that makes way keeps off `_WAY_M`."""
_WAY_M = 8.0
_BESIDE_M, _OUT_OF_WAY_M = 0.1, 0.25
"""What stays free beside the others' obstacle boxes; more for a robot that is to stand there, for it may stop a little before."""
_CLAIM_M = 3.0
_AGAIN_S = 30.0
"""Robots that meet again this soon after one drove around the other need another way out."""
_UNKNOWN_AHEAD_M = 0.8
"""Where floor that nobody sees is taken to begin, ahead of a robot that waits before it."""


class Unblocking:
    """Remembers which robots of a ring have searched in vain, and which rings were driven around lately."""

    def __init__(self, robots: Mapping[str, RobotGuidance], ground: Ground, parameters: GuidanceParameters) -> None:
        self._robots, self._ground, self._parameters = robots, ground, parameters
        self._in_vain: dict[frozenset[str], list[str]] = {}
        self._again_s: dict[frozenset[str], float] = {}
        self._went_around_s: dict[frozenset[str], float] = {}

    def look(
        self,
        views: Mapping[str, View],
        rings: Sequence[Sequence[str]],
        lasting: Sequence[Sequence[str]],
        snapshot: Snapshot,
        around: Surroundings,
    ) -> list[Event]:
        """`rings` are all robots that wait for each other, `lasting` those that have done so for a while. What was found counts
        from the next cycle on."""
        events: list[Event] = []
        aside = [robot for robot in self._robots.values() if robot.is_aside]
        if aside:
            paths = {name: view.path for name, view in views.items() if view.leg is not None}
            for robot in aside:
                robot.look_aside(paths, snapshot.now_s)
        if around.grid is None:
            return events
        floor = Floor(around.grid, self._ground.area, around.robots)
        searches = self._parameters.searches_per_cycle
        for robot in aside:
            if searches and robot.wants_back(snapshot.now_s):
                searches -= 1
                blocked = robot.blocked(snapshot, None, "back to its route")
                ways = way_around(blocked, floor, self._parameters) if blocked is not None else NoWay.ROOM
                robot.come_back(None if isinstance(ways, NoWay) else ways, snapshot.now_s)
        for ring in lasting:
            if searches and self._again_s.get(frozenset(ring), -math.inf) <= snapshot.now_s:
                searches -= 1
                events += self._resolve(ring, views, snapshot, floor)
        self._forget(lasting, snapshot.now_s)
        for name in self._waiting_long(views, {name for ring in rings for name in ring}, snapshot)[:searches]:
            self._go_around(name, views[name], snapshot, floor)
        return events

    def _resolve(self, ring: Sequence[str], views: Mapping[str, View], snapshot: Snapshot, floor: Floor) -> list[Event]:
        """Has the next robot of a ring, by the rule, look for a way out; when all have done so in vain, that is told."""
        key, settings = frozenset(ring), snapshot.settings
        may = [n for n in ring if effective_detours(self._robots[n].spec.detours, settings.get(n)).enabled]
        order = sorted(sorted(may, reverse=True), key=lambda name: settings.get(name, RobotSettings()).priority)
        tried = self._in_vain.setdefault(key, [])
        name = next((name for name in order if name not in tried), None)
        if name is not None:
            how = self._yield(name, key, views, snapshot, floor)
            if how:
                self._in_vain.pop(key)
                others = ", ".join(other for other in ring if other != name)
                return [_event(EventLevel.INFO, "deadlock_yield", f"{name} yields to {others}: it {how}", snapshot)]
            tried.append(name)
            if len(tried) < len(order):
                return []
        told = key in self._again_s
        self._in_vain.pop(key)
        self._again_s[key] = snapshot.now_s + self._parameters.retry_s
        if told:
            return []
        text = f"none of {', '.join(ring)} has room to let the others pass; drive one of them away by hand"
        return [_event(EventLevel.ERROR, "deadlock_unresolved", text, snapshot)]

    def _yield(
        self, name: str, ring: frozenset[str], views: Mapping[str, View], snapshot: Snapshot, floor: Floor
    ) -> str:
        """What the robot does from now on to resolve the ring; empty when it has no way out."""
        robot, view = self._robots[name], views[name]
        place = (view.blockage.x, view.blockage.y) if view.blockage is not None else None
        others = ring - {name}
        blocked = robot.blocked(snapshot, place, f"around {', '.join(sorted(others))}")
        if blocked is None:
            return ""
        lately = snapshot.now_s - self._went_around_s.get(ring, -math.inf) < _AGAIN_S
        if not lately and not robot.is_aside:
            beside = replace(floor, lanes=self._lanes(name, others, views, snapshot, _LANE_M, _BESIDE_M))
            detours = way_around(blocked, beside, self._parameters)
            if not isinstance(detours, NoWay):
                self._went_around_s[ring] = snapshot.now_s
                robot.divert(detours)
                return "drives around"
        lanes = self._lanes(name, others, views, snapshot, _WAY_M, _OUT_OF_WAY_M)
        line = way_aside(blocked, floor, lanes, self._parameters)
        if line is None:
            return ""
        reach_m = max(_radius_m(self._robots[other].spec) for other in (*others, name))
        ahead: list[Point] = [blocked.here, *Line(view.path or [blocked.here]).part(0.0, _CLAIM_M)]
        back = MultiLineString([ahead, line.points])
        claimed = back.buffer(2 * reach_m + self._parameters.clearance_m)
        robot.step_aside(Aside(LineDriver(line, self._parameters), others, snapshot.now_s, claimed))
        return f"makes way at ({line.end[0]:.2f}, {line.end[1]:.2f})"

    def _lanes(
        self,
        name: str,
        others: frozenset[str],
        views: Mapping[str, View],
        snapshot: Snapshot,
        length_m: float,
        beside_m: float,
    ) -> list[BaseGeometry]:
        """Where the others are about to drive, as wide as their obstacle boxes and something beside them."""
        lanes: list[BaseGeometry] = []
        for other in sorted(others):
            spec = self._robots[other].spec
            size = effective_box(spec.obstacle_box, snapshot.settings.get(other))
            half_m = max(Body.of(spec).half_width_m, size.width_m / 2)
            lane = lane_of(views[other].path, length_m, half_m + beside_m, self._robots[name].spec)
            if lane is not None:
                lanes.append(lane)
        return lanes

    def _waiting_long(self, views: Mapping[str, View], in_rings: set[str], snapshot: Snapshot) -> list[str]:
        """Robots that have waited long enough for what does not move, the longest first."""
        found: list[tuple[float, str]] = []
        for name, robot in self._robots.items():
            stuck = robot.stuck
            if not views[name].blocked or name in in_rings or stuck.since_s is None or snapshot.now_s < stuck.again_s:
                continue
            detours = effective_detours(robot.spec.detours, snapshot.settings.get(name))
            if not detours.enabled or stuck.for_s(snapshot.now_s) < detours.after_s:
                continue
            other = stuck.blockage.robot if stuck.blockage is not None else None
            pose = snapshot.poses.get(other) if other is not None else None
            if pose is None or math.hypot(pose.vx, pose.vy) < _STANDS_MPS:
                found.append((stuck.since_s, name))
        return [name for _, name in sorted(found)]

    def _go_around(self, name: str, view: View, snapshot: Snapshot, floor: Floor) -> None:
        robot = self._robots[name]
        if robot.is_aside:
            robot.stay_no_more_aside()
            return
        blockage = robot.stuck.blockage
        if blockage is not None:
            place = (blockage.x, blockage.y)
            what = blockage.robot or f"what is at ({blockage.x:.2f}, {blockage.y:.2f})"
        else:
            place = Line(view.path).at(_UNKNOWN_AHEAD_M) if view.path else None
            what = "floor that no camera sees"
        blocked = robot.blocked(snapshot, place, f"around {what}") if place is not None else None
        detours = way_around(blocked, floor, self._parameters) if blocked is not None else NoWay.ROOM
        if not isinstance(detours, NoWay):
            robot.divert(detours)
            return
        clearance = effective_detours(robot.spec.detours, snapshot.settings.get(name)).clearance_m
        without = " on which it has room to turn" if detours is NoWay.TURNING else ""
        robot.stuck = replace(
            robot.stuck,
            in_vain=f"there is no way around with {clearance:.2f} m beside it{without}",
            again_s=snapshot.now_s + self._parameters.retry_s,
        )

    def _forget(self, lasting: Sequence[Sequence[str]], now_s: float) -> None:
        rings = {frozenset(ring) for ring in lasting}
        self._in_vain = {key: tried for key, tried in self._in_vain.items() if key in rings}
        self._again_s = {key: again_s for key, again_s in self._again_s.items() if key in rings}
        self._went_around_s = {k: s for k, s in self._went_around_s.items() if now_s - s < _AGAIN_S}


def _radius_m(spec: VehicleSpec) -> float:
    return max(math.hypot(x, y) for x, y in spec.footprint)


def _event(level: EventLevel, kind: str, text: str, snapshot: Snapshot) -> Event:
    return Event(stamp_ns=snapshot.now_ns, level=level, source="guidance", kind=kind, text=text)
