"""Fills the world from Redis: a subscription for what lives, a poll each second for what is durable. Goes on by itself after
Redis was away; meanwhile the world keeps what it knew, and its stamps grow old."""

import logging
import math
from typing import Any, TypeVar

import msgspec
import redis
from msgspec import Struct
from pydantic import BaseModel

from protocol import keys
from protocol.bus import Bus
from protocol.channels import CAMERA_STATES, EMERGENCY_STOP, GUIDANCE, OBSTACLES, POSES, STATUSES, Channel
from protocol.clock import Clock
from protocol.codec import decode
from protocol.errors import DecodeError
from protocol.messages import CameraExtrinsics, Route, Waypoint
from server.scene.world import FloorPicture, World

M = TypeVar("M", bound=BaseModel | Struct)
_logger = logging.getLogger(__name__)
_POLL_S = 1.0


class Feed:
    """Runs two endless tasks, `follow` and `poll`."""

    def __init__(self, world: World, bus: Bus, clock: Clock) -> None:
        self._world, self._bus, self._clock = world, bus, clock
        self._down = False

    async def follow(self) -> None:
        """Takes live messages as they come."""
        world = self._world
        by_instance: dict[str, dict[str, Any]] = {
            POSES.name: world.poses,
            STATUSES.name: world.statuses,
            GUIDANCE.name: world.guidance,
            CAMERA_STATES.name: world.cameras,
        }
        channels: tuple[Channel[Any], ...] = (POSES, STATUSES, GUIDANCE, CAMERA_STATES, OBSTACLES, EMERGENCY_STOP)
        async for item in self._bus.subscribe(*channels):
            if item.channel is OBSTACLES:
                world.obstacles = item.message
            elif item.channel is EMERGENCY_STOP:
                world.emergency_stop = item.message
            else:
                by_instance[item.channel.name][item.instance] = item.message

    async def poll(self) -> None:
        """Reads what is durable, once a second."""
        while True:
            try:
                await self.read_durable()
                self._down = False
            except (redis.RedisError, OSError) as error:
                if not self._down:
                    _logger.warning("Redis is out of reach: %s", error)
                self._down = True
            await self._clock.sleep(_POLL_S)

    async def read_durable(self) -> None:
        """One round trip. redis-py's errors while Redis is out of reach."""
        pipeline = self._bus.redis.pipeline(transaction=False)
        for key in (keys.WAYPOINTS, keys.ROUTES, keys.EXTRINSICS):
            pipeline.hgetall(key)  # pyright: ignore[reportUnusedCoroutine]  # queued
        pipeline.mget(keys.FLOOR_PICTURE, keys.FLOOR_PICTURE_BOUNDS)  # pyright: ignore[reportUnusedCoroutine]  # queued
        waypoints, routes, extrinsics, picture = await pipeline.execute()
        world = self._world
        world.waypoints = _decoded(Waypoint, waypoints)
        world.routes = _decoded(Route, routes)
        world.extrinsics = _decoded(CameraExtrinsics, extrinsics)
        world.picture = _picture(*picture)


def _decoded(kind: type[M], raw: dict[bytes, bytes]) -> dict[str, M]:
    """What does not decode is not shown: whoever wrote it has been told."""
    found: dict[str, M] = {}
    for name, data in raw.items():
        try:
            found[name.decode(errors="replace")] = decode(kind, data)
        except DecodeError as error:
            _logger.debug("not shown: %s", error)
    return found


def _picture(jpeg: bytes | None, bounds: bytes | None) -> FloorPicture | None:
    if jpeg is None or bounds is None:
        return None
    try:
        corners = msgspec.json.decode(bounds, type=tuple[float, float, float, float])
    except (msgspec.MsgspecError, UnicodeDecodeError):
        return None
    sound = all(map(math.isfinite, corners)) and corners[0] < corners[2] and corners[1] < corners[3]
    return FloorPicture(jpeg, corners) if sound else None
