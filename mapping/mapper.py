"""The mapper's process, `python -m mapping.mapper`: merges the cameras' rasters into the lab's obstacle map and their pictures
into one of the whole floor (spec mapping, "Ceiling cameras").

The merging itself is in `mapping.fusion` and `mapping.stitching`; here is only what talks to Redis.
"""

import asyncio
import contextlib
import logging
from typing import cast

import msgspec
from redis.exceptions import RedisError

from mapping.fusion import ObstacleMap
from mapping.grid import FloorGrid
from mapping.stitching import stitch
from mapping.tiles import FloorTile
from protocol import keys
from protocol.bus import UNAVAILABLE, Bus
from protocol.channels import LAB_INSTANCE, OBSTACLES, RASTERS
from protocol.clock import Clock, SystemClock
from protocol.codec import decode
from protocol.errors import DecodeError, LabFileError
from protocol.lab import Lab, load_lab
from protocol.lifetime import run_until_signal
from protocol.messages import CameraExtrinsics, FloorRaster
from protocol.settings import Settings

_logger = logging.getLogger(__name__)

_SHORTEST_S = 1.0 / OBSTACLES.rate_hz
_LONGEST_S = 0.4
"""The map is published anew at least so often, also when no camera says anything: silence must not look like a free floor."""
_PICTURE_EVERY_S = 3.0


class Mapper:
    """The process between its two edges; `run` goes on until it is cancelled."""

    def __init__(self, lab: Lab, bus: Bus, clock: Clock) -> None:
        self._lab = lab
        self._bus = bus
        self._clock = clock
        self._map = ObstacleMap(FloorGrid.covering(lab.bounds()), (camera.id for camera in lab.cameras))
        self._news = asyncio.Event()
        self._tiles: dict[bytes, bytes] = {}
        self._refused: set[str] = set()

    async def run(self) -> None:
        async with asyncio.TaskGroup() as group:
            group.create_task(self._listen())
            group.create_task(self._publish())
            group.create_task(self._keep_picture())

    async def _listen(self) -> None:
        async for received in self._bus.subscribe(RASTERS):
            raster: FloorRaster = received.message
            try:
                if self._map.add(raster):
                    self._news.set()
                    self._refused.discard(raster.source)
            except (DecodeError, ValueError) as error:
                if raster.source not in self._refused:  # once per series, not eight times a second
                    self._refused.add(raster.source)
                    _logger.warning("refused: %s", error)

    async def _publish(self) -> None:
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_LONGEST_S):
                    await self._news.wait()
            self._news.clear()
            now_ns = self._clock.now_ns()
            await self._bus.publish(OBSTACLES, LAB_INSTANCE, self._map.merged(now_ns).to_raster(LAB_INSTANCE, now_ns))
            await self._clock.sleep(_SHORTEST_S)

    async def _keep_picture(self) -> None:
        while True:
            try:
                await self._place_cameras()
                await self._stitch()
            except UNAVAILABLE as error:
                _logger.info("the floor picture waits for Redis: %s", error)
            except RedisError as error:
                _logger.warning("the floor picture is not kept: %s", error)
            await self._clock.sleep(_PICTURE_EVERY_S)

    async def _place_cameras(self) -> None:
        for name, data in (await self._hash(keys.EXTRINSICS)).items():
            try:
                extrinsics = decode(CameraExtrinsics, data)
            except DecodeError as error:
                _logger.warning("extrinsics of %s ignored: %s", name, error)
                continue
            self._map.place_camera(name.decode(errors="replace"), *extrinsics.translation[:2])

    async def _stitch(self) -> None:
        """Puts the picture together anew when a tile of a camera of this lab changed."""
        known = {camera.id.encode() for camera in self._lab.cameras}
        found = await self._hash(keys.FLOOR_TILES)
        tiles = {name: data for name, data in sorted(found.items()) if name in known}
        if tiles == self._tiles:
            return
        readable: list[FloorTile] = []
        for name, data in tiles.items():
            try:
                readable.append(FloorTile.unpack(data))
            except DecodeError as error:
                _logger.warning("floor tile of %s ignored: %s", name.decode(), error)
        picture = await asyncio.to_thread(stitch, readable, self._lab.bounds())
        if picture is not None:
            pipeline = self._bus.redis.pipeline(transaction=True)
            pipeline.set(keys.FLOOR_PICTURE, picture.jpeg)
            pipeline.set(keys.FLOOR_PICTURE_BOUNDS, msgspec.json.encode(picture.bounds))
            await pipeline.execute()
        self._tiles = tiles

    async def _hash(self, key: str) -> dict[bytes, bytes]:
        return cast("dict[bytes, bytes]", await self._bus.redis.hgetall(key))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients


async def _run(lab: Lab, settings: Settings, clock: Clock) -> None:
    bus = Bus.connect(settings.redis_url, clock)
    try:
        await run_until_signal(Mapper(lab, bus, clock).run())
    finally:
        await bus.close()


def main() -> None:
    """Runs until SIGTERM or SIGINT."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")
    settings = Settings.from_environment()
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from None
    _logger.info("mapper of %s with %s", lab.name, settings)
    asyncio.run(_run(lab, settings, SystemClock()))


if __name__ == "__main__":
    main()
