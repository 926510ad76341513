"""The documents that views show, as this server keeps them: each hash is read again when it is announced as changed, and all of
them now and then, for not everybody who writes announces it."""

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from protocol.bus import Bus
from protocol.lab import Lab
from protocol.messages import Assignment, CameraFault, RobotSettings, Route, SimulatedObject, SpeedZone, Waypoint
from server.repositories.camera_faults import CAMERA_FAULTS
from server.repositories.documents import Documents, Store
from server.repositories.plan import ASSIGNMENTS, ROUTES, WAYPOINTS
from server.repositories.robot_settings import ROBOT_SETTINGS
from server.repositories.simulated_objects import SIMULATED_OBJECTS
from server.repositories.speed_zones import SPEED_ZONES, speed_zones_of


class KeptDocuments:
    """By id. Every `read` raises redis-py's errors, or BusUnavailableError, while Redis is out of reach."""

    def __init__(self, bus: Bus, lab: Lab) -> None:
        self._store, self._lab = Store(bus.redis), lab
        self.waypoints: Mapping[str, Waypoint] = {}
        self.routes: Mapping[str, Route] = {}
        self.objects: Mapping[str, SimulatedObject] = {}
        self.speed_zones: Mapping[str, SpeedZone] = speed_zones_of(lab)
        self.faults: Mapping[str, CameraFault] = {}
        self.assignments: Mapping[str, Assignment] = {}
        self.settings: Mapping[str, RobotSettings] = {}
        self._readers: dict[str, Callable[[], Awaitable[None]]] = {
            WAYPOINTS.key: self._read_waypoints,
            ROUTES.key: self._read_routes,
            SIMULATED_OBJECTS.key: self._read_objects,
            SPEED_ZONES.key: self._read_speed_zones,
            CAMERA_FAULTS.key: self._read_faults,
            ASSIGNMENTS.key: self.read_assignments,
            ROBOT_SETTINGS.key: self._read_settings,
        }

    async def read(self, key: str) -> None:
        """Those of the hash with that key; nothing when it is none of these."""
        if key in self._readers:
            await self._readers[key]()

    async def read_all(self) -> None:
        """All of them."""
        for read in self._readers.values():
            await read()

    async def read_assignments(self) -> None:
        """Which guidance moves on without announcing it."""
        self.assignments = await self._all(ASSIGNMENTS)

    async def _read_waypoints(self) -> None:
        self.waypoints = await self._all(WAYPOINTS)

    async def _read_routes(self) -> None:
        self.routes = await self._all(ROUTES)

    async def _read_objects(self) -> None:
        self.objects = await self._all(SIMULATED_OBJECTS)

    async def _read_speed_zones(self) -> None:
        self.speed_zones = {**await self._all(SPEED_ZONES), **speed_zones_of(self._lab)}

    async def _read_faults(self) -> None:
        self.faults = await self._all(CAMERA_FAULTS)

    async def _read_settings(self) -> None:
        self.settings = await self._all(ROBOT_SETTINGS)

    async def _all(self, documents: Documents[Any]) -> dict[str, Any]:
        return await self._store.all(documents)
