"""Tours: loops that simulated vehicles drive from a lab's very first start on, so that there is something to see at once.

They are ordinary waypoints, routes and assignments, made once; whoever operates the lab may change, stop or delete them, and
starts routes of their own over them.
"""

from collections.abc import Sequence

import redis.asyncio

from protocol.clock import Clock, SystemClock
from protocol.lab import Lab
from protocol.messages import Event, EventLevel, Leg, Route, Waypoint
from server.repositories.assignments import TOURS, begun
from server.repositories.documents import Store, Transaction
from server.repositories.emergency_stop import EMERGENCY_STOPS, read_emergency_stop
from server.repositories.plan import ASSIGNMENTS, PLAN, ROUTES, WAYPOINTS

_SPEED_MPS = 0.3
_RADIUS_M = 0.15


async def start_tours(client: redis.asyncio.Redis, lab: Lab, clock: Clock | None = None) -> list[str]:
    """Makes and starts all of the lab's tours, or none: only where nothing is planned yet and the emergency stop is
    released. The vehicles that drive now."""
    clock = clock or SystemClock()

    async def work(transaction: Transaction) -> list[str]:
        planned = await transaction.all(WAYPOINTS) or await transaction.all(ROUTES)
        if planned or (await read_emergency_stop(transaction)).engaged:
            return []
        for vehicle, points in lab.simulation.tours.items():
            _start_tour(transaction, lab, vehicle, points, clock.now_ns())
        return list(lab.simulation.tours)

    return await Store(client).transaction((*PLAN, EMERGENCY_STOPS), work)


def _start_tour(
    transaction: Transaction, lab: Lab, vehicle: str, points: Sequence[tuple[float, float]], now_ns: int
) -> None:
    route, legs = f"tour-{vehicle}"[:32], list[Leg]()
    for number, (x, y) in enumerate(points, start=1):
        area = lab.area_at(x, y)
        assert area is not None  # the lab description has been checked
        name = f"{vehicle[:28]}-{number}"
        transaction.put(WAYPOINTS, name, Waypoint(id=name, area=area.id, x=x, y=y, radius_m=_RADIUS_M))
        legs.append(Leg(waypoint=name, speed_mps=_SPEED_MPS))
    transaction.put(ROUTES, route, Route(id=route, legs=tuple(legs), loop=True))
    transaction.put(ASSIGNMENTS, vehicle, begun(vehicle, route, 1.0, TOURS, now_ns))
    text = f"{vehicle} drives route {route}, so that there is something to see; starting another route replaces it"
    transaction.record(Event(stamp_ns=now_ns, level=EventLevel.INFO, source=TOURS, kind="route_started", text=text))
