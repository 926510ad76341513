"""What the routes share for the life of the app: built by the lifespan, handed to each route as a dependency."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, cast

import httpx
from fastapi import Depends
from starlette.requests import HTTPConnection

from protocol.bus import Bus
from protocol.clock import Clock
from protocol.lab import Lab, VehicleSpec
from server.auth.known_credentials import KnownCredentials
from server.auth.passwords import Passwords
from server.auth.throttle import LoginThrottle
from server.configuration import Configuration
from server.errors import NotFoundError
from server.live.hub import LiveHub
from server.live.latch import EmergencyStopLatch
from server.repositories.assignments import AssignmentRepository
from server.repositories.calibration import CalibrationRepository
from server.repositories.camera_faults import CameraFaultRepository
from server.repositories.documents import Store
from server.repositories.manual import ManualDriveRepository
from server.repositories.plan import RouteRepository, WaypointRepository
from server.repositories.robot_settings import RobotSettingsRepository
from server.repositories.sessions import SessionRepository
from server.repositories.simulated_objects import SimulatedObjectRepository
from server.repositories.speed_zones import SpeedZoneRepository
from server.repositories.tokens import TokenRepository
from server.repositories.users import UserRepository


@dataclass(slots=True)
class Context:
    """The service's parts; `introduced` holds the session of each robot's newest registration with this server."""

    configuration: Configuration
    lab: Lab
    clock: Clock
    bus: Bus
    hub: LiveHub
    scene: httpx.AsyncClient
    passwords: Passwords
    throttle: LoginThrottle
    known: KnownCredentials
    users: UserRepository
    tokens: TokenRepository
    sessions: SessionRepository
    waypoints: WaypointRepository
    routes: RouteRepository
    assignments: AssignmentRepository
    settings: RobotSettingsRepository
    speed_zones: SpeedZoneRepository
    emergency_stop: EmergencyStopLatch
    manual: ManualDriveRepository
    objects: SimulatedObjectRepository
    faults: CameraFaultRepository
    calibration: CalibrationRepository
    vehicles: Mapping[str, VehicleSpec]
    introduced: dict[str, str] = field(default_factory=dict[str, str])

    @classmethod
    def build(
        cls,
        configuration: Configuration,
        lab: Lab,
        clock: Clock,
        bus: Bus,
        hub: LiveHub,
        scene: httpx.AsyncClient,
        passwords: Passwords,
    ) -> "Context":
        """The context with its repositories on the bus's Redis."""
        store = Store(bus.redis)
        return cls(
            configuration=configuration,
            lab=lab,
            clock=clock,
            bus=bus,
            hub=hub,
            scene=scene,
            passwords=passwords,
            throttle=LoginThrottle(clock),
            known=KnownCredentials(clock),
            users=UserRepository(store, clock),
            tokens=TokenRepository(store, clock),
            sessions=SessionRepository(store),
            waypoints=WaypointRepository(store, lab, clock),
            routes=RouteRepository(store, clock),
            assignments=AssignmentRepository(store, clock),
            settings=RobotSettingsRepository(store, clock),
            speed_zones=SpeedZoneRepository(store, lab, clock),
            emergency_stop=hub.latch,
            manual=ManualDriveRepository(store, clock),
            objects=SimulatedObjectRepository(store, clock),
            faults=CameraFaultRepository(store, lab, clock),
            calibration=CalibrationRepository(store, lab, clock),
            vehicles={vehicle.id: vehicle for vehicle in lab.vehicles},
        )

    def vehicle(self, robot: str) -> VehicleSpec:
        """NotFoundError when the lab description has no such robot."""
        vehicle = self.vehicles.get(robot)
        if vehicle is None:
            raise NotFoundError(f"there is no robot {robot!r} in lab {self.lab.name!r}")
        return vehicle


async def _context(connection: HTTPConnection) -> Context:
    # Not a plain function: FastAPI would send each request to a thread and back.
    return cast("Context", connection.app.state.context)


Ctx = Annotated[Context, Depends(_context)]
