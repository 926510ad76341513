"""The simulated lab and Redis: takes up what should stand on the floor and what cameras should suffer, keeps where the
vehicles stand, publishes the truth.

All of it goes on without Redis and catches up when it is back; only what Redis says is gone is taken away.
"""

import logging
from collections.abc import Callable, Mapping
from typing import Any, cast

import redis

from geometry import SE2
from lab.world import World
from protocol import keys
from protocol.bus import Bus
from protocol.channels import GROUND_TRUTH, LAB_INSTANCE
from protocol.clock import Clock
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages import CameraFault, SimulatedObject, TruePose

_TRUTH_PERIOD_S = 1.0 / GROUND_TRUTH.rate_hz
_OBJECTS_PERIOD_S = 0.2
_SAVE_PERIOD_S = 0.5
_SAVE_ANYWAY_EVERY = 60
"""Saved this often (in periods) although nothing moved: Redis may have lost it."""
_RESTORE_PATIENCE_S = 5.0
_RETRY_S = 0.2
_logger = logging.getLogger(__name__)


class SharedState:
    """The lab's dealings with Redis, each an endless coroutine of its own."""

    def __init__(self, world: World, bus: Bus, clock: Clock) -> None:
        self._world = world
        self._bus = bus
        self._clock = clock
        self._objects: dict[str, bytes] = {}
        self._refused: dict[str, bytes] = {}
        self._away = False

    async def restore_vehicles(self) -> None:
        """Puts the vehicles where they stood when the lab ended; their described starts hold where nothing is known."""
        deadline = self._clock.monotonic_s() + _RESTORE_PATIENCE_S
        while True:
            try:
                saved = await self._hash(keys.SIMULATED_STATE)
            except redis.RedisError as error:
                if self._clock.monotonic_s() >= deadline:
                    _logger.warning("vehicles start where the lab file says, Redis is out of reach: %s", error)
                    return
                await self._clock.sleep(_RETRY_S)
                continue
            for vehicle, data in saved.items():
                self._restore(vehicle, data)
            return

    async def publish_truth(self) -> None:
        """The ground truth, at its channel's rate."""
        while True:
            try:
                await self._bus.publish(GROUND_TRUTH, LAB_INSTANCE, self._world.truth())
            except redis.RedisError as error:
                self._note(error)
            await self._clock.sleep(_TRUTH_PERIOD_S)

    async def mirror_objects(self) -> None:
        """Keeps the floor as the hash of simulated objects says."""
        while True:
            try:
                wanted = await self._hash(keys.SIMULATED_OBJECTS)
            except redis.RedisError as error:
                self._note(error)
            else:
                self._note(None)
                self._take_up(wanted)
            await self._clock.sleep(_OBJECTS_PERIOD_S)

    async def mirror_faults(self, suffer: Callable[[Mapping[str, CameraFault]], None]) -> None:
        """Tells `suffer` what the cameras are to suffer, by camera id, whenever that changes."""
        before: dict[str, bytes] = {}
        while True:
            try:
                wanted = await self._hash(keys.SIMULATED_FAULTS)
            except redis.RedisError as error:
                self._note(error)
            else:
                if wanted != before:
                    suffer(_faults(wanted))
                before = wanted
            await self._clock.sleep(_OBJECTS_PERIOD_S)

    async def save_vehicles(self) -> None:
        """Writes down where the vehicles stand, so that a restarted lab finds them there."""
        before: dict[str, bytes] = {}
        unsaved_periods = 0
        while True:
            await self._clock.sleep(_SAVE_PERIOD_S)
            state = {vehicle: encode(pose) for vehicle, pose in self._world.truth().vehicles.items()}
            unsaved_periods += 1
            if not state or (state == before and unsaved_periods < _SAVE_ANYWAY_EVERY):
                continue
            try:
                await self._bus.redis.hset(keys.SIMULATED_STATE, mapping=cast("dict[Any, Any]", state))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
            except redis.RedisError as error:
                self._note(error)
            else:
                before, unsaved_periods = state, 0

    def _restore(self, vehicle: str, data: bytes) -> None:
        if vehicle not in self._world.vehicle_ids:
            return
        try:
            pose = decode(TruePose, data)
            place = SE2(pose.x, pose.y, pose.yaw)
        except (DecodeError, ValueError) as error:
            _logger.warning("ignored where %s stood: %s", vehicle, error)
            return
        if self._world.lab.area_at(place.x, place.y) is None:
            _logger.warning("ignored where %s stood: no area of this lab at (%.2f, %.2f)", vehicle, place.x, place.y)
            return
        self._world.place(vehicle, place)

    def _take_up(self, wanted: dict[str, bytes]) -> None:
        for object_id in [known for known in self._objects if known not in wanted]:
            self._world.remove(object_id)
            del self._objects[object_id]
        for object_id, data in wanted.items():
            if self._objects.get(object_id) == data or self._refused.get(object_id) == data:
                continue
            try:
                item = decode(SimulatedObject, data)
                if item.id != object_id:
                    raise DecodeError(f"its id is {item.id!r}")
            except DecodeError as error:
                _logger.warning("ignored simulated object %s: %s", object_id, error)
                self._refused[object_id] = data
                continue
            self._world.put(item)
            self._objects[object_id] = data

    async def _hash(self, key: str) -> dict[str, bytes]:
        raw = cast("dict[bytes, bytes]", await self._bus.redis.hgetall(key))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
        return {name.decode(errors="replace"): data for name, data in raw.items()}

    def _note(self, error: redis.RedisError | None) -> None:
        """One line when Redis goes and one when it is back."""
        if error is not None and not self._away:
            _logger.warning("going on without Redis: %s", error)
        elif error is None and self._away:
            _logger.info("Redis is back")
        self._away = error is not None


def _faults(wanted: Mapping[str, bytes]) -> dict[str, CameraFault]:
    faults: dict[str, CameraFault] = {}
    for camera, data in wanted.items():
        try:
            faults[camera] = decode(CameraFault, data)
        except DecodeError as error:
            _logger.warning("ignored the fault of camera %s: %s", camera, error)
    return faults
