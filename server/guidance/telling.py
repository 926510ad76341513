"""What guidance tells people: events for changes, robots that wait for each other, robots that do not get on."""

from collections.abc import Mapping

from protocol.messages import Event, EventLevel, Movement, ReasonCode
from server.guidance.decision import Decision
from server.guidance.path import Point, distance
from server.guidance.robot import View
from server.guidance.snapshot import Snapshot

_PROGRESS_M = 0.1
_CALM = frozenset({
    ReasonCode.ROUTE, ReasonCode.ROUTE_DONE, ReasonCode.MANUAL, ReasonCode.IDLE, ReasonCode.PAUSED,
    ReasonCode.DETOUR, ReasonCode.YIELDING, ReasonCode.AT_STOP,
})  # fmt: skip
_VERBS = {
    Movement.MOVE_TO: "drives",
    Movement.ROTATE: "turns",
    Movement.DRIVE: "is driven by hand",
    Movement.WAITING: "waits",
    Movement.NO_ACTION: "has nothing to do",
}
_KINDS = {
    Movement.MOVE_TO: "robot_driving",
    Movement.ROTATE: "robot_driving",
    Movement.DRIVE: "robot_manual",
    Movement.WAITING: "robot_waiting",
    Movement.NO_ACTION: "robot_idle",
}


def reason_event(robot: str, decision: Decision, now_ns: int) -> Event:
    """That a robot now does something else, and why."""
    code, text = decision.reason.code, decision.reason.text
    kind = _KINDS[decision.movement]
    lost = code is ReasonCode.MANUAL and decision.movement is Movement.WAITING
    level = EventLevel.INFO if code in _CALM and not lost else EventLevel.WARNING
    if code is ReasonCode.ROUTE_DONE:
        kind = "route_done"
    elif code is ReasonCode.WAYPOINT_MISSING:
        kind, level = "route_failed", EventLevel.ERROR
    elif code is ReasonCode.AT_STOP:
        kind = "stop_reached"
    elif code in (ReasonCode.DETOUR, ReasonCode.YIELDING):
        kind = f"robot_{code.value}"
    why = code.value.replace("_", " ")
    sentence = f"{robot} {_VERBS[decision.movement]}: {why}{', ' + text if text else ''}"
    if code in (ReasonCode.ROUTE_DONE, ReasonCode.WAYPOINT_MISSING) and text:
        sentence = f"{robot}: {text}"
    elif code is ReasonCode.ROUTE and text:
        sentence = f"{robot} {_VERBS[decision.movement]} {text}"
    elif code is ReasonCode.DETOUR:
        sentence = f"{robot} makes a detour {text}"
    elif code in (ReasonCode.AT_STOP, ReasonCode.YIELDING) and text:
        sentence = f"{robot} {text}"
    return Event(stamp_ns=now_ns, level=level, source=robot, kind=kind, text=sentence)


class DeadlockWatch:
    """Robots that wait for each other in a ring: named once when it has lasted, and again only after it was broken. `rings` are
    all that there are now, `lasting` those that have lasted, each from its smallest member."""

    def __init__(self, after_s: float) -> None:
        self._after_s = after_s
        self._since: dict[frozenset[str], float] = {}
        self._told: set[frozenset[str]] = set()
        self.rings: list[list[str]] = []
        self.lasting: list[list[str]] = []

    def look(self, waits_for: Mapping[str, str], snapshot: Snapshot) -> list[Event]:
        rings = _rings(waits_for)
        self._since = {key: self._since.get(key, snapshot.now_s) for key in rings}
        self._told &= rings.keys()
        events: list[Event] = []
        self.rings = list(rings.values())
        self.lasting = [ring for key, ring in rings.items() if snapshot.now_s - self._since[key] >= self._after_s]
        for ring in self.lasting:
            key = frozenset(ring)
            if key in self._told:
                continue
            self._told.add(key)
            text = ", ".join(f"{robot} waits for {waits_for[robot]}" for robot in ring)
            events.append(
                Event(
                    stamp_ns=snapshot.now_ns,
                    level=EventLevel.ERROR,
                    source="guidance",
                    kind="deadlock",
                    text=f"robots wait for each other: {text}",
                )
            )
        return events


class ProgressWatch:
    """Robots that are told to drive and do not get on: named once per standstill."""

    def __init__(self, after_s: float) -> None:
        self._after_s = after_s
        self._marks: dict[str, tuple[Point, float]] = {}
        self._told: set[str] = set()

    def look(self, views: Mapping[str, View], snapshot: Snapshot) -> list[Event]:
        events: list[Event] = []
        for name, view in views.items():
            pose = snapshot.poses.get(name)
            if view.decision.movement is not Movement.MOVE_TO or pose is None:
                self._forget(name)
                continue
            here = (pose.x, pose.y)
            place, since = self._marks.setdefault(name, (here, snapshot.now_s))
            if distance(place, here) > _PROGRESS_M:
                self._forget(name)
            elif snapshot.now_s - since > self._after_s and name not in self._told:
                self._told.add(name)
                events.append(
                    Event(
                        stamp_ns=snapshot.now_ns,
                        level=EventLevel.WARNING,
                        source=name,
                        kind="no_progress",
                        text=f"{name} is told to drive but has not moved for {snapshot.now_s - since:.0f} s"
                        f" at ({pose.x:.2f}, {pose.y:.2f})",
                    )
                )
        return events

    def _forget(self, name: str) -> None:
        self._marks.pop(name, None)
        self._told.discard(name)


def _rings(waits_for: Mapping[str, str]) -> dict[frozenset[str], list[str]]:
    """The closed rings in a graph in which everyone waits for at most one other, each from its smallest member."""
    rings: dict[frozenset[str], list[str]] = {}
    seen: set[str] = set()
    for start in sorted(waits_for):
        chain: dict[str, int] = {}
        name: str | None = start
        while name is not None and name not in seen and name not in chain:
            chain[name] = len(chain)
            name = waits_for.get(name)
        if name is not None and name in chain:
            ring = list(chain)[chain[name] :]
            first = ring.index(min(ring))
            rings[frozenset(ring)] = ring[first:] + ring[:first]
        seen |= chain.keys()
    return rings
