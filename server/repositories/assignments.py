"""Assignments: which route a robot drives and how far it has come; durable, written by two processes.

The service starts, pauses, resumes and stops; guidance advances legs and ends. Neither overwrites what it has not seen:
the writes here watch the hash and begin again when it changed, those of guidance (in a script of its own, fenced by its
lease) land only on exactly what it had read; and `changed_ns` grows with every write, so that no two are alike.
"""

import secrets
from dataclasses import dataclass

from protocol.clock import Clock
from protocol.messages import Assignment, AssignmentState, Event, EventLevel
from server.errors import ConflictError, NotFoundError
from server.repositories.documents import Store, Transaction
from server.repositories.emergency_stop import EMERGENCY_STOPS, read_emergency_stop
from server.repositories.plan import ASSIGNMENTS, PLAN, ROUTES, WAYPOINTS, is_over

TOURS = "first start"
"""Who starts the tours of a lab's first start. They are there to be seen, and in nobody's way: whoever starts a route on
a robot that drives one for `TOURS` replaces it."""


@dataclass(frozen=True, slots=True)
class _Step:
    """A change that a person may ask for: from which states, to which, and its words."""

    sources: tuple[AssignmentState, ...]
    target: AssignmentState
    kind: str
    done: str


_PAUSE = _Step((AssignmentState.RUNNING,), AssignmentState.PAUSED, "route_paused", "paused")
_RESUME = _Step((AssignmentState.PAUSED,), AssignmentState.RUNNING, "route_resumed", "resumed")
_STOP = _Step((AssignmentState.RUNNING, AssignmentState.PAUSED), AssignmentState.STOPPED, "route_stopped", "stopped")


class AssignmentRepository:
    """The newest assignment of each robot."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def all(self) -> dict[str, Assignment]:
        """By robot, those that are over included."""
        return await self._store.all(ASSIGNMENTS)

    async def start(self, robot: str, route: str, speed_scale: float, actor: str) -> Assignment:
        """Gives the robot a route. NotFoundError when there is no such route; ConflictError while the emergency stop is
        engaged, another assignment (one of the tours aside) is not over, or a waypoint of the route is missing."""

        async def work(transaction: Transaction) -> Assignment:
            if (await read_emergency_stop(transaction)).engaged:
                raise ConflictError("the emergency stop is engaged; release it before starting a route")
            current = await transaction.find(ASSIGNMENTS, robot)
            busy = current is not None and not is_over(current)
            if busy and current is not None and current.started_by != TOURS:
                raise ConflictError(f"{robot} has route {current.route!r} ({current.state}); stop it first")
            found = await transaction.get(ROUTES, route)
            if found is None:
                raise NotFoundError(f"there is no route {route!r}")
            waypoints = await transaction.all(WAYPOINTS)
            missing = sorted({leg.waypoint for leg in found.legs} - waypoints.keys())
            if missing:
                raise ConflictError(f"route {route!r} needs waypoint {', '.join(missing)}, which does not exist")
            assignment = begun(robot, route, speed_scale, actor, _after(current, self._clock.now_ns()))
            transaction.put(ASSIGNMENTS, robot, assignment)
            instead = f", in place of {current.route}" if busy and current is not None else ""
            text = f"{actor} started route {route} on {robot}{instead}"
            transaction.record(self._event(actor, "route_started", text))
            return assignment

        return await self._store.transaction((*PLAN, EMERGENCY_STOPS), work)

    async def pause(self, robot: str, actor: str) -> Assignment:
        """NotFoundError when the robot never had a route, ConflictError unless one runs."""
        return await self._step(robot, actor, _PAUSE)

    async def resume(self, robot: str, actor: str) -> Assignment:
        """NotFoundError when the robot never had a route, ConflictError unless one is paused."""
        return await self._step(robot, actor, _RESUME)

    async def stop(self, robot: str, actor: str) -> Assignment:
        """NotFoundError when the robot never had a route, ConflictError when it is over already."""
        return await self._step(robot, actor, _STOP)

    async def _step(self, robot: str, actor: str, step: _Step) -> Assignment:
        async def work(transaction: Transaction) -> Assignment:
            current = await transaction.find(ASSIGNMENTS, robot)
            if current is None:
                raise NotFoundError(f"{robot} has no route")
            if current.state not in step.sources:
                raise ConflictError(f"the route of {robot} is {current.state}, it cannot be {step.done}")
            changed = current.model_copy(
                update={
                    "state": step.target,
                    "changed_ns": _after(current, self._clock.now_ns()),
                    "reason": f"{step.done} by {actor}",
                }
            )
            transaction.put(ASSIGNMENTS, robot, changed)
            transaction.record(self._event(actor, step.kind, f"{actor} {step.done} route {current.route} of {robot}"))
            return changed

        return await self._store.transaction((ASSIGNMENTS,), work)

    def _event(self, actor: str, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)


def begun(robot: str, route: str, speed_scale: float, actor: str, now_ns: int) -> Assignment:
    """A new assignment, at its beginning."""
    return Assignment(
        id=secrets.token_hex(8),
        robot=robot,
        route=route,
        state=AssignmentState.RUNNING,
        speed_scale=speed_scale,
        started_ns=now_ns,
        changed_ns=now_ns,
        started_by=actor,
    )


def _after(current: Assignment | None, now_ns: int) -> int:
    """A stamp that differs from the current one's even when a clock stands still or was set back."""
    return now_ns if current is None else max(now_ns, current.changed_ns + 1)
