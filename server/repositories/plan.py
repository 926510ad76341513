"""Waypoints and routes: durable, checked against the lab and against each other (spec gpss, "The operator's side").

A route names waypoints and an assignment names a route, so every write watches all three: none of them can come to name
something that is gone. A route that is being driven may be neither changed nor deleted; its waypoints may be moved.
"""

from protocol import keys
from protocol.clock import Clock
from protocol.lab import Lab
from protocol.messages import Assignment, AssignmentState, Event, EventLevel, Route, Waypoint
from server.errors import ConflictError, InvalidError, NotFoundError
from server.repositories.documents import Documents, Store, Transaction

WAYPOINTS = Documents(keys.WAYPOINTS, Waypoint)
ROUTES = Documents(keys.ROUTES, Route)
ASSIGNMENTS = Documents(keys.ASSIGNMENTS, Assignment)
PLAN = (WAYPOINTS, ROUTES, ASSIGNMENTS)
"""The hashes that name each other."""


def is_over(assignment: Assignment) -> bool:
    """Whether nothing more will be driven of it."""
    return assignment.state not in (AssignmentState.RUNNING, AssignmentState.PAUSED)


class WaypointRepository:
    """Waypoints by id."""

    def __init__(self, store: Store, lab: Lab, clock: Clock) -> None:
        self._store, self._lab, self._clock = store, lab, clock

    async def all(self) -> dict[str, Waypoint]:
        return await self._store.all(WAYPOINTS)

    async def put(self, waypoint: Waypoint, actor: str, *, create: bool) -> Waypoint:
        """Writes the waypoint. InvalidError when it is not in its area, ConflictError when `create` and it exists."""
        require_in_area(self._lab, waypoint)

        async def work(transaction: Transaction) -> Waypoint:
            old = await transaction.find(WAYPOINTS, waypoint.id)
            if create and old is not None:
                raise ConflictError(f"waypoint {waypoint.id!r} exists already")
            transaction.put(WAYPOINTS, waypoint.id, waypoint)
            kind, done = ("waypoint_created", "placed") if old is None else ("waypoint_changed", "changed")
            text = f"{actor} {done} waypoint {waypoint.id} at ({waypoint.x:.3f}, {waypoint.y:.3f})"
            transaction.record(_event(self._clock, actor, kind, text))
            return waypoint

        return await self._store.transaction(PLAN, work)

    async def delete(self, waypoint_id: str, actor: str) -> None:
        """NotFoundError when there is none, ConflictError while a route uses it."""

        async def work(transaction: Transaction) -> None:
            if not await transaction.exists(WAYPOINTS, waypoint_id):
                raise NotFoundError(f"there is no waypoint {waypoint_id!r}")
            routes = await transaction.all(ROUTES)
            users = sorted(r.id for r in routes.values() if any(leg.waypoint == waypoint_id for leg in r.legs))
            if users:
                raise ConflictError(f"waypoint {waypoint_id!r} is used by route {', '.join(users)}")
            transaction.delete(WAYPOINTS, waypoint_id)
            text = f"{actor} deleted waypoint {waypoint_id}"
            transaction.record(_event(self._clock, actor, "waypoint_deleted", text))

        await self._store.transaction(PLAN, work)


class RouteRepository:
    """Routes by id."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def all(self) -> dict[str, Route]:
        return await self._store.all(ROUTES)

    async def put(self, route: Route, actor: str, *, create: bool) -> Route:
        """Writes the route. InvalidError when a leg's waypoint does not exist, ConflictError when `create` and it exists
        or while it is being driven."""

        async def work(transaction: Transaction) -> Route:
            old = await transaction.find(ROUTES, route.id)
            if create and old is not None:
                raise ConflictError(f"route {route.id!r} exists already")
            waypoints = await transaction.all(WAYPOINTS)
            for index, leg in enumerate(route.legs):
                if leg.waypoint not in waypoints:
                    raise InvalidError(("body", "legs", index, "waypoint"), f"there is no waypoint {leg.waypoint!r}")
            await _require_not_driven(transaction, route.id, "changed")
            transaction.put(ROUTES, route.id, route)
            kind, done = ("route_created", "made") if old is None else ("route_changed", "changed")
            text = f"{actor} {done} route {route.id} ({' > '.join(leg.waypoint for leg in route.legs)})"
            transaction.record(_event(self._clock, actor, kind, text[:500]))
            return route

        return await self._store.transaction(PLAN, work)

    async def delete(self, route_id: str, actor: str) -> None:
        """NotFoundError when there is none, ConflictError while it is being driven."""

        async def work(transaction: Transaction) -> None:
            if not await transaction.exists(ROUTES, route_id):
                raise NotFoundError(f"there is no route {route_id!r}")
            await _require_not_driven(transaction, route_id, "deleted")
            transaction.delete(ROUTES, route_id)
            text = f"{actor} deleted route {route_id}"
            transaction.record(_event(self._clock, actor, "route_deleted", text))

        await self._store.transaction(PLAN, work)


def require_in_area(lab: Lab, waypoint: Waypoint) -> None:
    """InvalidError, saying what is wrong, unless the waypoint lies in the area that it names."""
    areas = {area.id: area for area in lab.areas}
    if waypoint.area not in areas:
        known = ", ".join(sorted(areas))
        raise InvalidError(("body", "area"), f"there is no area {waypoint.area!r} (areas: {known})")
    if areas[waypoint.area].contains(waypoint.x, waypoint.y):
        return
    place = f"({waypoint.x:g}, {waypoint.y:g})"
    other = lab.area_at(waypoint.x, waypoint.y)
    if other is None:
        raise InvalidError(("body",), f"waypoint {waypoint.id!r} at {place} lies outside every area")
    raise InvalidError(
        ("body", "area"), f"waypoint {waypoint.id!r} at {place} lies in area {other.id!r}, not in {waypoint.area!r}"
    )


async def _require_not_driven(transaction: Transaction, route_id: str, what: str) -> None:
    assignments = await transaction.all(ASSIGNMENTS)
    drivers = sorted(a.robot for a in assignments.values() if a.route == route_id and not is_over(a))
    if drivers:
        raise ConflictError(f"route {route_id!r} is being driven by {', '.join(drivers)}; stop it before it is {what}")
    waiting = sorted(a.robot for a in assignments.values() if any(entry.route == route_id for entry in a.queue))
    if waiting and what == "deleted":
        raise ConflictError(f"route {route_id!r} is queued for {', '.join(waiting)}; take it out before it is {what}")


def _event(clock: Clock, actor: str, kind: str, text: str) -> Event:
    return Event(stamp_ns=clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)
