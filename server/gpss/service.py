"""The adapter between GPSS robots and the rest: their documents on one side, our channels on the other (docs/connect-a-robot.md).

commands, poses and the emergency stop -> the robots' command and pose documents; their status and response documents -> our
statuses and responses. It decides nothing: guidance and the emergency stop hold for these robots as for all.
"""

import asyncio
import logging
from collections import deque
from collections.abc import Iterable
from typing import Any, cast

from redis.exceptions import RedisError

from protocol.bus import UNAVAILABLE, Bus
from protocol.channels import COMMANDS, EMERGENCY_STOP, POSES, RESPONSES
from protocol.clock import Clock
from protocol.codec import encode
from protocol.errors import BusUnavailableError
from protocol.gpss import LARGEST_DOCUMENT, WRITTEN, GpssCommand, GpssPose, Name, key
from protocol.lab import GPSS_DRIVER, Lab
from protocol.messages import Command, EmergencyStop, Response, TrackedPose
from server.gpss.access import RedisAccess
from server.gpss.orders import RobotOrders
from server.gpss.reports import RobotReports
from server.intake.statuses import StatusIntake
from server.live.feeds import CommandFeeds
from server.repositories.documents import Store
from server.repositories.emergency_stop import read_emergency_stop

_WRITE_EVERY_S = 0.1
"""When nothing is new: `Waiting` has to be repeated."""
_LOOK_EVERY_S = 0.05
_ACCESS_EVERY_S = 1.0
_LATCH_EVERY_S = 0.5
_RETRY_S = 0.1
_POSE_LIFETIME_MS = round(POSES.stale_after_s * 1e3)
_ANSWERS = 256
_NS_PER_MS = 1_000_000
_logger = logging.getLogger(__name__)


class GpssService:
    """`parts` must be running, each until cancelled."""

    def __init__(self, lab: Lab, bus: Bus, clock: Clock) -> None:
        robots = [vehicle.id for vehicle in lab.vehicles if vehicle.driver == GPSS_DRIVER]
        self.intake = StatusIntake(bus, lab, clock, source="gpss", what="gpss")
        self._bus, self._clock = bus, clock
        self._store, self._latch = Store(bus.redis), CommandFeeds()
        self._orders = {robot: RobotOrders(robot, clock.now_ns()) for robot in robots}
        self._reports = {robot: RobotReports(robot, self._orders[robot], self.intake, clock) for robot in robots}
        self._poses: dict[str, TrackedPose] = {}
        self._answers: deque[Response] = deque(maxlen=_ANSWERS)
        self._access = RedisAccess(bus.redis, clock)
        self._news = asyncio.Event()
        self._unwritten = 0

    def parts(self) -> tuple[Any, ...]:
        """What has to run beside each other."""
        return (
            self.follow(),
            self.keep_latch(),
            self.write(),
            self.look(),
            self.listen(),
            self.keep_access(),
            self.intake.run(),
        )

    async def follow(self) -> None:
        """Takes in what the rest of the system says."""
        async for received in self._bus.subscribe(COMMANDS, EMERGENCY_STOP, POSES):
            message = received.message
            if isinstance(message, EmergencyStop):
                self._changed(self._latch.announced(message))
            elif isinstance(message, Command):
                orders = self._orders.get(message.robot)
                if orders is not None and orders.offer(message, self._clock.now_ns()):
                    self._news.set()
            elif isinstance(message, TrackedPose) and message.vehicle in self._orders:
                self._poses[message.vehicle] = message
                self._news.set()

    async def keep_latch(self) -> None:
        """Reads the latch itself now and then: where it never was engaged nobody says anything of it, and what cannot be read
        counts as engaged."""
        while True:
            before = self._latch.emergency_stop
            try:
                latch = await read_emergency_stop(self._store)
                if (
                    self._latch.emergency_stop is before
                ):  # else what was heard meanwhile may be newer than what was read
                    self._changed(self._latch.stop(latch))
            except (RedisError, OSError) as error:
                _logger.debug("cannot read the emergency stop: %s", error)
            await self._clock.sleep(_LATCH_EVERY_S)

    def _changed(self, latch_changed: bool) -> None:
        if latch_changed:
            for orders in self._orders.values():
                orders.hurry()
            self._news.set()

    async def write(self) -> None:
        """Writes the robots' documents as soon as there is something new, all in one round trip."""
        while True:
            try:
                async with asyncio.timeout(_WRITE_EVERY_S):
                    await self._news.wait()
            except TimeoutError:
                pass
            self._news.clear()
            await self._write_due()

    async def _write_due(self) -> None:
        now_ns, now_s = self._clock.now_ns(), self._clock.monotonic_s()
        now_ms = now_ns // _NS_PER_MS
        poses, self._poses = self._poses, {}
        documents: list[tuple[str, GpssCommand | GpssPose, int]] = []  # each with the time at which it ends, ms
        for robot, orders in self._orders.items():
            command = orders.next(self._latch.emergency_stop, now_ns, now_s)
            if command is not None:
                documents.append((key(robot, "command"), command, command.deadline))
        for robot, pose in poses.items():
            stamp_ms = pose.stamp_ns // _NS_PER_MS
            document = GpssPose(x=pose.x, y=pose.y, angle=pose.yaw, timestamp=stamp_ms)
            documents.append((key(robot, "pose"), document, stamp_ms + _POSE_LIFETIME_MS))
        alive = [(name, encode(document), ends_ms) for name, document, ends_ms in documents if ends_ms > now_ms]
        if not alive:
            return
        pipeline = self._bus.redis.pipeline(transaction=True)
        for name, data, ends_ms in alive:
            # Not a lifetime: that would begin when Redis gets to it, and a Redis that stalled gets to it late.
            pipeline.set(name, data, pxat=ends_ms)
            pipeline.publish(name, data)
        try:
            await pipeline.execute()
        except UNAVAILABLE as error:
            self._unwritten += len(alive)
            _logger.warning("%d documents were not written: %s", len(alive), error)

    async def look(self) -> None:
        """Reads what the robots wrote, for those that do not publish it too."""
        wanted: list[tuple[str, Name]] = [(robot, name) for robot in self._reports for name in WRITTEN]
        while wanted:
            pipeline = self._bus.redis.pipeline(transaction=False)
            for robot, name in wanted:
                pipeline.getrange(key(robot, name), 0, LARGEST_DOCUMENT)  # pyright: ignore[reportUnusedCoroutine]  # queued
            try:
                found = cast("list[bytes | Exception]", await pipeline.execute(raise_on_error=False))
                self._take((robot, name, data) for (robot, name), data in zip(wanted, found, strict=True))
                await self._deliver()
            except (*UNAVAILABLE, BusUnavailableError) as error:
                _logger.debug("cannot look at the robots' documents: %s", error)
                await self._clock.sleep(_RETRY_S)
            await self._clock.sleep(_LOOK_EVERY_S)

    async def listen(self) -> None:
        """Hears what the robots publish."""
        topics: dict[bytes, tuple[str, Name]] = {
            key(robot, name).encode(): (robot, name) for robot in self._reports for name in WRITTEN
        }
        while topics:
            try:
                async with self._bus.redis.pubsub() as pubsub:
                    await pubsub.subscribe(*topics)
                    while True:
                        item = cast("dict[str, Any] | None", await pubsub.get_message(timeout=1.0))
                        if item is None:
                            await pubsub.ping()  # pyright: ignore[reportGeneralTypeIssues]  # notices a dead connection
                        elif item["type"] == "message":
                            robot, name = topics[item["channel"]]
                            self._take([(robot, name, item["data"])])
            except UNAVAILABLE as error:
                _logger.debug("cannot hear the robots: %s", error)
                await self._clock.sleep(_RETRY_S)

    async def keep_access(self) -> None:
        """Keeps Redis' users of the robots what they should be."""
        while True:
            try:
                await self._access.keep()
            except (RedisError, OSError) as error:
                _logger.warning("cannot set the robots' Redis users: %s", error)
            await self._clock.sleep(_ACCESS_EVERY_S)

    def _take(self, documents: Iterable[tuple[str, Name, bytes | Exception]]) -> None:
        for robot, name, data in documents:
            if isinstance(data, Exception):  # the key holds something that is no string
                self.intake.refuse("undecodable", f"{key(robot, name)}: {data}")
            elif not data:
                continue
            elif name == "status":
                self._reports[robot].status(data)
            else:
                response = self._reports[robot].response(data)
                if response is not None:
                    self._answers.append(response)

    async def _deliver(self) -> None:
        """Each response must arrive: what Redis does not take is tried again the next time."""
        while self._answers:
            await self._bus.publish(RESPONSES, self._answers[0].robot, self._answers[0])
            self._answers.popleft()

    def describe(self) -> str:
        """What came in and what was refused, for the log."""
        counts = ", ".join(f"{count} {cause.replace('_', ' ')}" for cause, count in sorted(self.intake.counts.items()))
        return f"{', '.join(self._orders) or 'no robot'}: {counts or 'nothing heard'}; {self._unwritten} not written"
