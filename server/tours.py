"""Tours: loops that simulated vehicles drive from a lab's very first start on, so that there is something to see at once.

They are ordinary waypoints, routes and assignments, made once; whoever operates the lab may change, stop or delete them.
"""

import redis.asyncio

from protocol.clock import Clock, SystemClock
from protocol.lab import Lab
from protocol.messages import Leg, Route, Waypoint
from server.repositories.assignments import AssignmentRepository
from server.repositories.documents import Store
from server.repositories.plan import RouteRepository, WaypointRepository

_ACTOR = "first start"
_SPEED_MPS = 0.3
_RADIUS_M = 0.15


async def start_tours(client: redis.asyncio.Redis, lab: Lab, clock: Clock | None = None) -> list[str]:
    """Makes and starts the lab's tours where nothing is planned yet; the vehicles that drive now."""
    clock = clock or SystemClock()
    store = Store(client)
    waypoints, routes = WaypointRepository(store, lab, clock), RouteRepository(store, clock)
    assignments = AssignmentRepository(store, clock)
    if await waypoints.all() or await routes.all():
        return []
    for vehicle, points in lab.simulation.tours.items():
        route, legs = f"tour-{vehicle}"[:32], list[Leg]()
        for number, (x, y) in enumerate(points, start=1):
            area = lab.area_at(x, y)
            assert area is not None  # the lab description has been checked
            name = f"{vehicle[:28]}-{number}"
            waypoint = Waypoint(id=name, area=area.id, x=x, y=y, radius_m=_RADIUS_M)
            await waypoints.put(waypoint, _ACTOR, create=True)
            legs.append(Leg(waypoint=name, speed_mps=_SPEED_MPS))
        await routes.put(Route(id=route, legs=tuple(legs), loop=True), _ACTOR, create=True)
        await assignments.start(vehicle, route, 1.0, _ACTOR)
    return list(lab.simulation.tours)
