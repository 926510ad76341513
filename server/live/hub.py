"""The live hub: one subscription to the channels and documents for all browsers and robots of this server.

It keeps the newest of everything, rebuilds the views at most 20 times a second while somebody looks, and tells versions
apart, so that each client gets what it misses at its own pace. Nothing here waits for a client.
"""

import asyncio
import logging
from collections.abc import AsyncGenerator, Awaitable, Callable, Mapping
from contextlib import aclosing, asynccontextmanager, suppress
from typing import Any, cast

from redis.exceptions import RedisError

from protocol.bus import UNAVAILABLE, Bus, ReceivedRaw
from protocol.channels import (
    CAMERA_STATES,
    CHANNELS,
    COMMANDS,
    EMERGENCY_STOP,
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
from protocol.errors import BusUnavailableError
from protocol.lab import Lab
from protocol.messages import (
    CameraExtrinsics,
    CameraState,
    EmergencyStop,
    FloorRaster,
    GuidanceState,
    IntakeState,
    ProcessState,
    Status,
)
from server.health import health_in_steps
from server.live.feeds import CommandFeeds
from server.live.handing_out import HandingOut
from server.live.kept_documents import KeptDocuments
from server.live.latch import EmergencyStopLatch
from server.live.newest import NewestMessages, decoded_or_none, held_stop, orders
from server.live.newest_events import KEY as EVENTS_KEY
from server.live.newest_events import NewestEvents
from server.live.reading import read_extrinsics
from server.live.sections import Item, Sections
from server.problems import HealthInputs
from server.repositories.changes import changes
from server.repositories.documents import Store
from server.repositories.emergency_stop import EmergencyStopRepository
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
        self._handing_out = HandingOut(self.feeds, clock)
        self.latch = EmergencyStopLatch(EmergencyStopRepository(Store(bus.redis), clock), self.feeds, clock)
        self._started_ns = clock.now_ns()
        self._newest = NewestMessages(CHANNELS)
        self._fleet = FleetState()
        self._raster: FloorRaster | None = None
        self._assignments_due = False
        self._documents, self._events = KeptDocuments(bus, lab), NewestEvents(bus)
        self._extrinsics: dict[str, CameraExtrinsics] = {}
        self._away_since_ns: int | None = None
        self._health: tuple[float, HealthView] | None = None
        self._sections = Sections()
        self._sections.replace("zones", {zone.id: Item(zone) for zone in lab.zones})
        self._clients = 0
        self._building = asyncio.Lock()
        self._dirty = asyncio.Event()
        self._advanced = asyncio.Event()

    def parts(self) -> tuple[Callable[[], Awaitable[None]], ...]:
        """What has to run beside each other, each until cancelled; one that fails may be begun again."""
        return (
            self._follow_channels,
            self._handing_out.run,
            self._follow_documents,
            self._poll,
            self._rebuild,
            self.latch.run,
        )

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
            self._health = (now_s, await self._health_view())
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
            self._handing_out.take(received.messages)
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
                    await self._read_documents()
                elif key == EVENTS_KEY:
                    await self._events.read()
                else:
                    await self._documents.read(key)
            except _AWAY as error:
                # The feed notices by itself, reconnects, and then all is read again.
                _logger.warning("cannot read %s: %s", key or "the documents", error)
            self._dirty.set()

    async def _read_documents(self) -> None:
        await self._documents.read_all()
        if await self._events.read():
            self._dirty.set()

    async def _poll(self) -> None:
        again_s = 0.0
        while True:
            await self._read_polled()
            if self._clients and self._clock.monotonic_s() >= again_s:
                await self._catch_up()
                begun_s = self._clock.monotonic_s()
                self._health = (begun_s, await self._health_view())
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
            await self._read_documents()
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
                        await self._documents.read_assignments()
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
            if self._health is None:
                self._health = (self._clock.monotonic_s(), await self._health_view())
            self._build_others()
            if self._sections.commit():
                woken, self._advanced = self._advanced, asyncio.Event()
                woken.set()

    def _prepare_fleet(self) -> None:
        fleet, newest = self._fleet, self._newest
        fleet.poses, fleet.statuses = newest.of(POSES), newest.of(STATUSES)
        fleet.registrations, fleet.commands = newest.of(REGISTRATIONS), newest.of(COMMANDS)
        fleet.guidance, fleet.manual = newest.of(GUIDANCE), newest.of(MANUAL)
        fleet.assignments, fleet.settings = self._documents.assignments, self._documents.settings
        fleet.losses = losses(self._intake(), self._clock.now_ns())
        fleet.emergency_stop = self.feeds.emergency_stop or EmergencyStop(engaged=False)

    def _build_others(self) -> None:
        now_ns, sections, documents = self._clock.now_ns(), self._sections, self._documents
        states = cast("Mapping[str, CameraState]", self._newest.of(CAMERA_STATES))
        cameras = [
            camera_view(c, states.get(c.id), self._extrinsics.get(c.id), now_ns, documents.faults.get(c.id))
            for c in self._lab.cameras
        ]
        sections.replace("cameras", {view.id: Item(view, view.without_ages()) for view in cameras})
        sections.replace("waypoints", {name: Item(waypoint) for name, waypoint in documents.waypoints.items()})
        sections.replace("routes", {name: Item(route) for name, route in documents.routes.items()})
        sections.replace("objects", {name: Item(item) for name, item in documents.objects.items()})
        sections.replace("speed_zones", {name: Item(zone) for name, zone in documents.speed_zones.items()})
        sections.replace_single("estop", Item(self._fleet.emergency_stop))
        raster = cast("FloorRaster | None", self._newest.of(OBSTACLES).get(LAB_INSTANCE))
        if raster is not None and raster is not self._raster:
            self._raster = raster
            sections.replace_single("obstacles", _obstacles(raster))
        if self._health is not None:
            sections.replace_single("health", Item(self._health[1]))
        for event in self._events.taken():
            sections.append(event)

    def _intake(self) -> IntakeState | None:
        return cast("IntakeState | None", self._newest.of(INTAKE).get(LAB_INSTANCE))

    async def _health_view(self) -> HealthView:
        """In steps: others on the loop are not to wait for all of a large fleet."""
        now_ns, intake = self._clock.now_ns(), self._intake()
        steps = health_in_steps(
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
        while True:
            try:
                next(steps)
            except StopIteration as done:
                return cast("HealthView", done.value)
            await self._clock.sleep(0.0)


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
