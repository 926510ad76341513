"""Assignments: which route a robot drives, how far it has come and what follows; durable, written by two processes.

The service starts, queues, pauses, resumes, skips, cancels and stops; guidance advances legs, ends, and begins what is queued.
Neither overwrites what it has not seen:
the writes here watch the hash and begin again when it changed, those of guidance (in a script of its own, fenced by its
lease) land only on exactly what it had read; and `changed_ns` grows with every write, so that no two are alike.
"""

import secrets
from dataclasses import dataclass
from typing import TypeGuard

from protocol.clock import Clock
from protocol.messages import Assignment, AssignmentState, Event, EventLevel, QueuedRoute
from protocol.messages.fleet import MOST_QUEUED
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
_CANCEL = _Step(
    (AssignmentState.RUNNING, AssignmentState.PAUSED, AssignmentState.FAILED),
    AssignmentState.STOPPED,
    "route_cancelled",
    "cancelled",
)


class AssignmentRepository:
    """The newest assignment of each robot."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def all(self) -> dict[str, Assignment]:
        """By robot, those that are over included."""
        return await self._store.all(ASSIGNMENTS)

    async def start(self, robot: str, route: str, speed_scale: float, actor: str) -> Assignment:
        """Gives the robot a route. NotFoundError when there is no such route; ConflictError while the emergency stop is
        engaged, another assignment (one of the tours aside) is not over, or a waypoint of the route is missing. What was queued
        follows it."""

        async def work(transaction: Transaction) -> Assignment:
            current = await transaction.find(ASSIGNMENTS, robot)
            if _busy(current):
                raise ConflictError(f"{robot} has route {current.route!r} ({current.state}); stop it first")
            return await self._begin(transaction, robot, current, route, speed_scale, actor)

        return await self._store.transaction((*PLAN, EMERGENCY_STOPS), work)

    async def enqueue(self, robot: str, route: str, speed_scale: float, actor: str) -> Assignment:
        """Lets the robot drive the route after all it has to do; it begins at once when that is nothing, and is refused as in
        `start` then. NotFoundError when there is no such route, ConflictError when a waypoint of it is missing or too much is
        queued already."""

        async def work(transaction: Transaction) -> Assignment:
            current = await transaction.find(ASSIGNMENTS, robot)
            if current is None or not (_busy(current) or current.queue):
                return await self._begin(transaction, robot, current, route, speed_scale, actor)
            await _require_drivable(transaction, route)
            if len(current.queue) >= MOST_QUEUED:
                raise ConflictError(f"{len(current.queue)} routes wait for {robot} already, more cannot")
            entry = QueuedRoute(
                id=secrets.token_hex(8),
                route=route,
                speed_scale=speed_scale,
                queued_ns=self._clock.now_ns(),
                queued_by=actor,
            )
            queue = (*current.queue, entry)
            text = f"{actor} queued route {route} for {robot}, number {len(queue)} of what waits"
            return self._written(transaction, current, {"queue": queue}, actor, "route_queued", text)

        return await self._store.transaction((*PLAN, EMERGENCY_STOPS), work)

    async def dequeue(self, robot: str, entry_id: str | None, actor: str) -> Assignment:
        """Takes one route out of the robot's queue, or all of them (None). NotFoundError when it is not there, and when the
        robot never had a route."""

        async def work(transaction: Transaction) -> Assignment:
            current = await self._current(transaction, robot)
            gone = [entry for entry in current.queue if entry_id in (None, entry.id)]
            if not gone and entry_id is not None:
                raise NotFoundError(f"nothing of the id {entry_id!r} is queued for {robot}")
            if not gone:
                return current
            queue = tuple(entry for entry in current.queue if entry not in gone)
            names = ", ".join(entry.route for entry in gone)
            text = f"{actor} took {names} out of the queue of {robot}"
            return self._written(transaction, current, {"queue": queue}, actor, "route_dequeued", text)

        return await self._store.transaction((ASSIGNMENTS,), work)

    async def pause(self, robot: str, actor: str) -> Assignment:
        """NotFoundError when the robot never had a route, ConflictError unless one runs."""
        return await self._step(robot, actor, _PAUSE)

    async def resume(self, robot: str, actor: str) -> Assignment:
        """NotFoundError when the robot never had a route, ConflictError unless one is paused."""
        return await self._step(robot, actor, _RESUME)

    async def stop(self, robot: str, actor: str) -> Assignment:
        """Ends the route, and nothing follows: the queue is emptied. NotFoundError when the robot never had a route,
        ConflictError when it is over already."""
        return await self._step(robot, actor, _STOP, queue=())

    async def cancel(self, robot: str, actor: str) -> Assignment:
        """Ends the route, also one that failed, and lets the next of the queue begin. NotFoundError when the robot never had a
        route, ConflictError when it is over already."""
        return await self._step(robot, actor, _CANCEL)

    async def skip(self, robot: str, actor: str) -> Assignment:
        """Leaves out the rest of the leg, the stay at its end included; skipping the last one ends the route. NotFoundError when
        the robot never had a route, ConflictError when it is over already."""

        async def work(transaction: Transaction) -> Assignment:
            current = await self._current(transaction, robot)
            if is_over(current):
                raise ConflictError(f"the route of {robot} is {current.state}, no leg of it can be skipped")
            route = await transaction.get(ROUTES, current.route)
            if route is None:
                raise ConflictError(f"route {current.route!r} of {robot} does not exist any more; cancel it")
            changes: dict[str, object] = {"at_stop_ns": None, "proceed": False}
            if current.leg + 1 < len(route.legs):
                changes["leg"] = current.leg + 1
            elif route.loop and not current.queue:
                changes |= {"leg": 0, "laps": current.laps + 1}
            else:
                changes |= {"state": AssignmentState.DONE, "reason": f"its last leg was skipped by {actor}"}
            waypoint = route.legs[current.leg].waypoint if current.leg < len(route.legs) else "nowhere"
            text = f"{actor} skipped the leg to {waypoint} of route {current.route} of {robot}"
            return self._written(transaction, current, changes, actor, "leg_skipped", text)

        return await self._store.transaction((ROUTES, ASSIGNMENTS), work)

    async def proceed(self, robot: str, actor: str) -> Assignment:
        """Lets the robot go on from where it stays, whatever it still waits for there. NotFoundError when the robot never had a
        route, ConflictError when it does not stay anywhere."""

        async def work(transaction: Transaction) -> Assignment:
            current = await self._current(transaction, robot)
            if current.at_stop_ns is None or is_over(current):
                raise ConflictError(f"{robot} is not at a stop of its route")
            text = f"{actor} let {robot} go on from its stop"
            return self._written(transaction, current, {"proceed": True}, actor, "stop_confirmed", text)

        return await self._store.transaction((ASSIGNMENTS,), work)

    async def _begin(
        self,
        transaction: Transaction,
        robot: str,
        current: Assignment | None,
        route: str,
        speed_scale: float,
        actor: str,
    ) -> Assignment:
        if (await read_emergency_stop(transaction)).engaged:
            raise ConflictError("the emergency stop is engaged; release it before starting a route")
        await _require_drivable(transaction, route)
        now_ns = _after(current, self._clock.now_ns())
        assignment = begun(robot, route, speed_scale, actor, now_ns, current.queue if current is not None else ())
        transaction.put(ASSIGNMENTS, robot, assignment)
        instead = f", in place of {current.route}" if current is not None and not is_over(current) else ""
        transaction.record(self._event(actor, "route_started", f"{actor} started route {route} on {robot}{instead}"))
        return assignment

    async def _step(self, robot: str, actor: str, step: _Step, **changes: object) -> Assignment:
        async def work(transaction: Transaction) -> Assignment:
            current = await self._current(transaction, robot)
            if current.state not in step.sources:
                raise ConflictError(f"the route of {robot} is {current.state}, it cannot be {step.done}")
            changed = {"state": step.target, "reason": f"{step.done} by {actor}", **changes}
            text = f"{actor} {step.done} route {current.route} of {robot}"
            return self._written(transaction, current, changed, actor, step.kind, text)

        return await self._store.transaction((ASSIGNMENTS,), work)

    async def _current(self, transaction: Transaction, robot: str) -> Assignment:
        current = await transaction.find(ASSIGNMENTS, robot)
        if current is None:
            raise NotFoundError(f"{robot} has no route")
        return current

    def _written(
        self,
        transaction: Transaction,
        current: Assignment,
        changes: dict[str, object],
        actor: str,
        kind: str,
        text: str,
    ) -> Assignment:
        changed = current.model_copy(update={**changes, "changed_ns": _after(current, self._clock.now_ns())})
        transaction.put(ASSIGNMENTS, current.robot, changed)
        transaction.record(self._event(actor, kind, text))
        return changed

    def _event(self, actor: str, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)


def begun(
    robot: str, route: str, speed_scale: float, actor: str, now_ns: int, queue: tuple[QueuedRoute, ...] = ()
) -> Assignment:
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
        queue=queue,
    )


def _busy(current: Assignment | None) -> TypeGuard[Assignment]:
    """Whether something is driven that a new route may not replace."""
    return current is not None and not is_over(current) and current.started_by != TOURS


async def _require_drivable(transaction: Transaction, route: str) -> None:
    """NotFoundError when there is no such route, ConflictError when a waypoint of it is missing."""
    found = await transaction.get(ROUTES, route)
    if found is None:
        raise NotFoundError(f"there is no route {route!r}")
    waypoints = await transaction.all(WAYPOINTS)
    missing = sorted({leg.waypoint for leg in found.legs} - waypoints.keys())
    if missing:
        raise ConflictError(f"route {route!r} needs waypoint {', '.join(missing)}, which does not exist")


def _after(current: Assignment | None, now_ns: int) -> int:
    """A stamp that differs from the current one's even when a clock stands still or was set back."""
    return now_ns if current is None else max(now_ns, current.changed_ns + 1)
