"""The live hub: one subscription to the channels and documents for all browsers and robots of this server.

It keeps the newest of everything, rebuilds the views at most 20 times a second while somebody looks, and tells versions
apart, so that each client gets what it misses at its own pace. Nothing here waits for a client.
"""

import asyncio
import logging
from collections import deque
from collections.abc import AsyncGenerator, Awaitable, Callable, Mapping
from contextlib import aclosing, asynccontextmanager, suppress
from typing import Any, cast

from redis.exceptions import RedisError

from protocol import keys
from protocol.bus import UNAVAILABLE, Bus, ReceivedRaw
from protocol.channels import (
    CAMERA_STATES,
    CHANNELS,
    COMMANDS,
    EMERGENCY_STOP,
    EVENTS,
    GUIDANCE,
    INTAKE,
    LAB_INSTANCE,
    MANUAL,
    OBSTACLES,
    POSES,
    PROCESSES,
    REGISTRATIONS,
    STATUSES,
    Channel,
    Delivery,
)
from protocol.clock import Clock
from protocol.codec import decode
from protocol.errors import BusUnavailableError, DecodeError
from protocol.lab import Lab
from protocol.messages import (
    CameraExtrinsics,
    CameraFault,
    CameraState,
    EmergencyStop,
    Event,
    FloorRaster,
    GuidanceState,
    IntakeState,
    ProcessState,
    Route,
    SimulatedObject,
    Status,
    Waypoint,
)
from server.health import HealthInputs, health_view
from server.live.feeds import CommandFeeds
from server.live.latch import EmergencyStopLatch
from server.live.newest import NewestMessages, decoded_or_none, held_stop, orders
from server.live.reading import read_extrinsics
from server.live.sections import Item, Sections
from server.repositories.camera_faults import CAMERA_FAULTS
from server.repositories.changes import changes
from server.repositories.documents import Documents, Store
from server.repositories.emergency_stop import EmergencyStopRepository
from server.repositories.plan import ASSIGNMENTS, ROUTES, WAYPOINTS
from server.repositories.robot_settings import ROBOT_SETTINGS
from server.repositories.simulated_objects import SIMULATED_OBJECTS
from server.repositories.speed_zones import SPEED_ZONES, speed_zones_of
from server.views.cameras import camera_view
from server.views.health import HealthView, RedisView, UdpView, losses
from server.views.obstacles import obstacles_view
from server.views.robots import FleetState, robot_view

_SUBSCRIBED: tuple[Channel[Any], ...] = (
    POSES,
    STATUSES,
    REGISTRATIONS,
    COMMANDS,
    GUIDANCE,
    MANUAL,
    EMERGENCY_STOP,
    OBSTACLES,
    CAMERA_STATES,
)
_POLLED = tuple(c for c in CHANNELS if c.delivery is Delivery.LATEST and c not in _SUBSCRIBED)
_PERIOD_S = 0.05
_AT_ONCE = 20
"""Robots whose views are made before others on the loop have their turn."""
_PAUSES = 4.0
"""Where views take long (many robots, a busy machine), so much longer than they took is paused before the next ones: watching
takes a fifth of a processor at most."""
_HEALTH_PAUSES = 40.0
"""The same of health, which is made in one piece and changes more slowly."""
_REFRESH_S = 0.25
"""Time alone changes a view: a pose grows stale, a lease runs out."""
_POLL_S = 1.0
_HEALTH_AGE_S = 0.5
_logger = logging.getLogger(__name__)
_AWAY = (*UNAVAILABLE, RedisError, BusUnavailableError)


class LiveHub:
    """Its `parts` must be running for anything to be new."""

    def __init__(self, bus: Bus, lab: Lab, clock: Clock) -> None:
        self.feeds = CommandFeeds()
        self._bus, self._lab, self._clock = bus, lab, clock
        self._store = Store(bus.redis)
        self.latch = EmergencyStopLatch(EmergencyStopRepository(self._store, clock), self.feeds, clock)
        self._started_ns = clock.now_ns()
        self._newest = NewestMessages(CHANNELS)
        self._fleet = FleetState()
        self._raster: FloorRaster | None = None
        self._assignments_due = False
        self._waypoints: dict[str, Waypoint] = {}
        self._routes: dict[str, Route] = {}
        self._objects: dict[str, SimulatedObject] = {}
        self._speed_zones = speed_zones_of(lab)
        self._faults: dict[str, CameraFault] = {}
        self._extrinsics: dict[str, CameraExtrinsics] = {}
        self._away_since_ns: int | None = None
        self._last_event: bytes | None = None
        self._new_events: deque[Event] = deque(maxlen=200)
        self._health: tuple[float, HealthView] | None = None
        self._sections = Sections()
        self._sections.replace("zones", {zone.id: Item(zone) for zone in lab.zones})
        self._clients = 0
        self._readers: dict[str, Callable[[], Awaitable[None]]] = {
            WAYPOINTS.key: self._read_waypoints,
            ROUTES.key: self._read_routes,
            SIMULATED_OBJECTS.key: self._read_objects,
            SPEED_ZONES.key: self._read_speed_zones,
            CAMERA_FAULTS.key: self._read_faults,
            ASSIGNMENTS.key: self._read_assignments,
            ROBOT_SETTINGS.key: self._read_settings,
            keys.stream(EVENTS.name): self._read_events,
        }
        self._reading_events = asyncio.Lock()
        self._building = asyncio.Lock()
        self._dirty = asyncio.Event()
        self._advanced = asyncio.Event()

    def parts(self) -> tuple[Callable[[], Awaitable[None]], ...]:
        """What has to run beside each other, each until cancelled; one that fails may be begun again."""
        return self._follow_channels, self._follow_documents, self._poll, self._rebuild, self.latch.run

    @asynccontextmanager
    async def client(self) -> AsyncGenerator["LiveClient"]:
        """A browser's view of the state, up to date from its beginning."""
        self._clients += 1
        try:
            await self._build()
            yield LiveClient(self)
        finally:
            self._clients -= 1

    @property
    def clients(self) -> int:
        """How many browsers look."""
        return self._clients

    async def health(self) -> HealthView:
        """At most half a second old."""
        now_s = self._clock.monotonic_s()
        if self._health is None or now_s - self._health[0] > _HEALTH_AGE_S:
            await self._read_polled()
            await self._catch_up()
            self._health = (now_s, self._health_view())
        return self._health[1]

    async def newer_than(self, version: int) -> tuple[bytes, int]:
        """Waits until there is something newer; the message for a client at `version`, and its new version."""
        while self._sections.version <= version:
            await self._advanced.wait()
        return self._sections.message(version, self._clock.now_ns()), self._sections.version

    async def _follow_channels(self) -> None:
        async with aclosing(self._bus.subscribe_raw(*_SUBSCRIBED)) as said:
            async for received in said:
                self._take(received)

    def _take(self, received: ReceivedRaw) -> None:
        """What robots wait for goes on at once, the rest when somebody looks."""
        if received.channel is EMERGENCY_STOP:
            for instance, data in received.messages.items():
                if (stop := decoded_or_none(EMERGENCY_STOP, instance, data)) is not None:
                    self.feeds.announced(stop)
        elif received.channel is COMMANDS:
            received = ReceivedRaw(COMMANDS, orders(received.messages))
            for robot, data in received.messages.items():
                self.feeds.command(robot, data)
        elif received.channel is STATUSES:
            for robot, data in received.messages.items():
                if (epoch := held_stop(data)) is not None:
                    self.latch.held(robot, epoch)
        self._newest.take(received)
        self._dirty.set()

    def _guidance_changed(self, before: GuidanceState | None, now: GuidanceState) -> None:
        """Guidance moves assignments on without announcing it; what it says of the robot then changes too."""
        if before is None or (before.leg, before.reason.code) != (now.leg, now.reason.code):
            self._assignments_due = True

    async def _catch_up(self) -> None:
        """Decodes what has come since somebody looked last, channel by channel: what robots wait for comes between."""
        for channel in _SUBSCRIBED:
            self._newest.catch_up(channel, self._guidance_changed if channel is GUIDANCE else None)
            await self._clock.sleep(0.0)

    async def _follow_documents(self) -> None:
        async for key in changes(self._bus, self._clock):
            try:
                if key is None:
                    for read in self._readers.values():
                        await read()
                elif key in self._readers:
                    await self._readers[key]()
            except _AWAY as error:
                # The feed notices by itself, reconnects, and then all is read again.
                _logger.warning("cannot read %s: %s", key or "the documents", error)
            self._dirty.set()

    async def _read_waypoints(self) -> None:
        self._waypoints = await self._all(WAYPOINTS)

    async def _read_routes(self) -> None:
        self._routes = await self._all(ROUTES)

    async def _read_objects(self) -> None:
        self._objects = await self._all(SIMULATED_OBJECTS)

    async def _read_speed_zones(self) -> None:
        self._speed_zones = {**await self._all(SPEED_ZONES), **speed_zones_of(self._lab)}

    async def _read_faults(self) -> None:
        self._faults = await self._all(CAMERA_FAULTS)

    async def _read_assignments(self) -> None:
        self._fleet.assignments = await self._all(ASSIGNMENTS)

    async def _read_settings(self) -> None:
        self._fleet.settings = await self._all(ROBOT_SETTINGS)

    async def _all(self, documents: Documents[Any]) -> dict[str, Any]:
        return await self._store.all(documents)

    async def _read_events(self) -> None:
        async with self._reading_events:
            await self._read_new_events()

    async def _read_new_events(self) -> None:
        stream = keys.stream(EVENTS.name)
        if self._last_event is None:
            entries = cast("list[Any]", await self._bus.redis.xrevrange(stream, count=50))[::-1]
        else:
            after = "(" + self._last_event.decode()
            entries = cast("list[Any]", await self._bus.redis.xrange(stream, min=after, count=200))
        for entry_id, fields in entries:
            self._last_event = entry_id
            try:
                self._new_events.append(decode(Event, fields[b"m"]))
            except (DecodeError, KeyError):
                _logger.warning("ignored a damaged event")
        if entries:
            self._dirty.set()

    async def _poll(self) -> None:
        again_s = 0.0
        while True:
            await self._read_polled()
            if self._clients and self._clock.monotonic_s() >= again_s:
                await self._catch_up()
                begun_s = self._clock.monotonic_s()
                self._health = (begun_s, self._health_view())
                again_s = begun_s + _HEALTH_PAUSES * (self._clock.monotonic_s() - begun_s)
                self._dirty.set()
            await self._clock.sleep(_POLL_S)

    async def _read_polled(self) -> None:
        """What nobody announces, and whether Redis answers at all."""
        try:
            for channel in _POLLED:
                self._newest.replace(channel, await self._bus.latest_all(channel))
            self._extrinsics = await read_extrinsics(self._bus)
            if await self.latch.look():
                self._dirty.set()
            # Not everybody who writes documents announces it.
            for read in self._readers.values():
                await read()
            self._away_since_ns = None
        except _AWAY:
            self._away_since_ns = self._away_since_ns or self._clock.now_ns()

    async def _rebuild(self) -> None:
        while True:
            try:
                async with asyncio.timeout(_REFRESH_S):
                    await self._dirty.wait()
            except TimeoutError:
                pass
            self._dirty.clear()
            took_s = 0.0
            if self._clients:
                begun_s = self._clock.monotonic_s()
                await self._catch_up()
                if self._assignments_due:
                    self._assignments_due = False
                    with suppress(*_AWAY):
                        await self._read_assignments()
                await self._build()
                took_s = self._clock.monotonic_s() - begun_s
            await self._clock.sleep(max(_PERIOD_S, _PAUSES * took_s))

    async def _build(self) -> None:
        """Brings the sections up to date and wakes the clients when anything changed. Robots come some at a time: others on the
        loop are not to wait for all of a large fleet."""
        async with self._building:
            await self._catch_up()
            self._prepare_fleet()
            for first in range(0, len(self._lab.vehicles), _AT_ONCE):
                now_ns = self._clock.now_ns()
                some = [
                    robot_view(vehicle, self._fleet, now_ns) for vehicle in self._lab.vehicles[first : first + _AT_ONCE]
                ]
                self._sections.put("robots", {view.id: Item(view, view.without_ages()) for view in some})
                await self._clock.sleep(0.0)
            self._build_others()
            if self._sections.commit():
                woken, self._advanced = self._advanced, asyncio.Event()
                woken.set()

    def _prepare_fleet(self) -> None:
        fleet, newest = self._fleet, self._newest
        fleet.poses, fleet.statuses = newest.of(POSES), newest.of(STATUSES)
        fleet.registrations, fleet.commands = newest.of(REGISTRATIONS), newest.of(COMMANDS)
        fleet.guidance, fleet.manual = newest.of(GUIDANCE), newest.of(MANUAL)
        fleet.losses = losses(self._intake(), self._clock.now_ns())
        fleet.emergency_stop = self.feeds.emergency_stop or EmergencyStop(engaged=False)

    def _build_others(self) -> None:
        now_ns, sections = self._clock.now_ns(), self._sections
        states = cast("Mapping[str, CameraState]", self._newest.of(CAMERA_STATES))
        cameras = [
            camera_view(c, states.get(c.id), self._extrinsics.get(c.id), now_ns, self._faults.get(c.id))
            for c in self._lab.cameras
        ]
        sections.replace("cameras", {view.id: Item(view, view.without_ages()) for view in cameras})
        sections.replace("waypoints", {name: Item(waypoint) for name, waypoint in self._waypoints.items()})
        sections.replace("routes", {name: Item(route) for name, route in self._routes.items()})
        sections.replace("objects", {name: Item(item) for name, item in self._objects.items()})
        sections.replace("speed_zones", {name: Item(zone) for name, zone in self._speed_zones.items()})
        sections.replace_single("estop", Item(self._fleet.emergency_stop))
        raster = cast("FloorRaster | None", self._newest.of(OBSTACLES).get(LAB_INSTANCE))
        if raster is not None and raster is not self._raster:
            self._raster = raster
            sections.replace_single("obstacles", _obstacles(raster))
        health = self._health[1] if self._health else self._health_view()
        sections.replace_single("health", Item(health))
        while self._new_events:
            sections.append(self._new_events.popleft())

    def _intake(self) -> IntakeState | None:
        return cast("IntakeState | None", self._newest.of(INTAKE).get(LAB_INSTANCE))

    def _health_view(self) -> HealthView:
        now_ns, intake = self._clock.now_ns(), self._intake()
        return health_view(
            self._lab,
            HealthInputs(
                started_ns=self._started_ns,
                stamps=self._newest.stamps(),
                camera_states=cast("Mapping[str, CameraState]", self._newest.of(CAMERA_STATES)),
                processes=cast("Mapping[str, ProcessState]", self._newest.of(PROCESSES)),
                redis=RedisView(reachable=self._away_since_ns is None, since_ns=self._away_since_ns),
                udp=UdpView.of(intake, now_ns),
                statuses=cast("dict[str, Status]", self._newest.of(STATUSES)),
                losses=losses(intake, now_ns),
            ),
            now_ns,
        )


class LiveClient:
    """One browser: knows which version it has."""

    def __init__(self, hub: LiveHub) -> None:
        self._hub = hub
        self._version = -1

    async def next(self) -> bytes:
        """The next message: a snapshot first, then changes, as soon as there are any."""
        message, self._version = await self._hub.newer_than(self._version)
        return message


def _obstacles(raster: FloorRaster) -> Item:
    key = (
        raster.origin_x,
        raster.origin_y,
        raster.cell_m,
        raster.columns,
        raster.rows,
        raster.occupied,
        raster.observed,
    )
    return Item(obstacles_view(raster), key)
