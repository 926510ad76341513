"""The mapper's process against a real Redis: rasters in, obstacle map and floor picture out."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest

from mapping.grid import FloorGrid
from mapping.tiles import FloorTile
from protocol import keys
from protocol.bus import Bus
from protocol.channels import LAB_INSTANCE, OBSTACLES, RASTERS
from protocol.lab import load_lab
from protocol.messages import FloorRaster
from tests.redis_fixture import RedisServer

ROOT = Path(__file__).parents[2]
LAB = ROOT / "labs" / "gulliver.yaml"
AREA = FloorGrid.covering(load_lab(LAB).bounds())


@pytest.fixture
def mapper(redis_server: RedisServer) -> Iterator[subprocess.Popen[bytes]]:
    environment = {**os.environ, "LILLIPUT_LAB": str(LAB), "REDIS_URL": redis_server.url, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen([sys.executable, "-m", "mapping.mapper"], env=environment, cwd=ROOT)
    try:
        yield process
    finally:
        process.kill()
        process.wait(10)


@pytest.fixture
async def bus(redis_server: RedisServer) -> AsyncIterator[Bus]:
    bus = Bus.connect(redis_server.url)
    yield bus
    await bus.close()


async def until(condition: Callable[[], Awaitable[bool]], what: str) -> None:
    deadline = time.monotonic() + 15
    while not await condition():
        assert time.monotonic() < deadline, what
        await asyncio.sleep(0.01)


def raster(x: float, y: float) -> FloorRaster:
    """All of the floor observed, one block of 0.2 m occupied at x, y."""
    occupied = np.zeros_like(AREA.occupied)
    row, column = round((y - AREA.origin_y) / AREA.cell_m), round((x - AREA.origin_x) / AREA.cell_m)
    occupied[row : row + 4, column : column + 4] = True
    return AREA.with_cells(occupied, np.ones_like(occupied)).to_raster("cam0", time.time_ns())


async def shows(bus: Bus, x: float, y: float) -> bool:
    message = await bus.latest(OBSTACLES, LAB_INSTANCE)
    if message is None or time.time_ns() - message.stamp_ns > OBSTACLES.stale_after_s * 1e9:
        return False
    box = [(x, y), (x + 0.2, y), (x + 0.2, y + 0.2), (x, y + 0.2)]
    return len(FloorGrid.from_raster(message).look(box).occupied) == 16


async def test_obstacles_come_out_also_after_redis_was_killed(
    mapper: subprocess.Popen[bytes], bus: Bus, redis_server: RedisServer
) -> None:
    async def seen_at_1() -> bool:
        await bus.publish(RASTERS, "cam0", raster(1.0, 1.0))
        return await shows(bus, 1.0, 1.0)

    await until(seen_at_1, "the obstacle is not in the map")
    redis_server.kill()
    redis_server.start()

    async def seen_at_2() -> bool:
        await bus.publish(RASTERS, "cam0", raster(2.0, 1.0))
        return await shows(bus, 2.0, 1.0)

    await until(seen_at_2, "the mapper does not go on after Redis came back")
    assert mapper.poll() is None


async def test_silence_shows_as_a_floor_that_nobody_observes(mapper: subprocess.Popen[bytes], bus: Bus) -> None:
    async def said_so() -> bool:
        message = await bus.latest(OBSTACLES, LAB_INSTANCE)
        return message is not None and not FloorGrid.from_raster(message).observed.any()

    await until(said_so, "no map without cameras")
    await bus.publish(RASTERS, "cam0", raster(1.0, 1.0))

    async def fresh_and_unobserved() -> bool:
        message = await bus.latest(OBSTACLES, LAB_INSTANCE)
        assert message is not None
        grid = FloorGrid.from_raster(message)
        fresh = time.time_ns() - message.stamp_ns < 500_000_000
        return fresh and bool(grid.occupied.any()) and not grid.observed.any()

    await until(fresh_and_unobserved, "a silent camera still counts as observing, or its obstacle is forgotten")


async def test_bad_rasters_do_not_stop_the_mapper(mapper: subprocess.Popen[bytes], bus: Bus) -> None:
    bad = msgspec.structs.replace(raster(1.0, 1.0), occupied=b"\xff")
    stranger = msgspec.structs.replace(raster(1.0, 1.0), source="cam9")

    async def seen() -> bool:
        await bus.publish(RASTERS, "cam1", msgspec.structs.replace(bad, source="cam1"))
        await bus.publish(RASTERS, "cam9", stranger)
        await bus.redis.publish(keys.topic(RASTERS.name, "cam2"), b"garbage")
        await bus.publish(RASTERS, "cam0", raster(3.0, 1.0))
        return await shows(bus, 3.0, 1.0)

    await until(seen, "the good raster did not get through")
    assert mapper.poll() is None


async def test_tiles_become_one_picture(mapper: subprocess.Popen[bytes], bus: Bus) -> None:
    _, jpeg = cv2.imencode(".jpg", np.full((490, 435), 90, np.uint8))
    left = FloorTile((-0.35, -0.3, 4.0, 4.6), ((-0.35, -0.3), (4.0, -0.3), (4.0, 4.6), (-0.35, 4.6)), jpeg.tobytes())
    await bus.redis.hset(keys.FLOOR_TILES, "cam0", left.pack())  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
    await bus.redis.hset(keys.FLOOR_TILES, "cam1", b"broken")  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients

    async def stitched() -> bool:
        return bool(await bus.redis.exists(keys.FLOOR_PICTURE, keys.FLOOR_PICTURE_BOUNDS) == 2)

    await until(stitched, "no floor picture")
    bounds, jpeg_bytes = await bus.redis.mget(keys.FLOOR_PICTURE_BOUNDS, keys.FLOOR_PICTURE)
    assert isinstance(bounds, bytes)
    assert isinstance(jpeg_bytes, bytes)
    assert msgspec.json.decode(bounds) == pytest.approx((-0.35, -0.3, 8.35, 4.6), abs=0.01)
    picture = cv2.imdecode(np.frombuffer(jpeg_bytes, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    assert picture.shape == (490, 870)
    assert picture[245, 200] == pytest.approx(90, abs=3)
    assert picture[245, 800] == pytest.approx(40, abs=3)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
async def test_it_ends_when_told(
    mapper: subprocess.Popen[bytes], bus: Bus, redis_server: RedisServer, number: signal.Signals
) -> None:
    async def up() -> bool:
        return await bus.latest(OBSTACLES, LAB_INSTANCE) is not None

    await until(up, "the mapper does not come up")
    if number == signal.SIGINT:
        redis_server.kill()  # also while it waits for Redis
    began = time.monotonic()
    mapper.send_signal(number)
    assert mapper.wait(10) == 0
    assert time.monotonic() - began < 1.0


def test_a_lab_file_that_cannot_be_used_is_one_clear_line(tmp_path: Path) -> None:
    environment = {**os.environ, "LILLIPUT_LAB": str(tmp_path / "none.yaml"), "REDIS_URL": "unix:///nowhere"}
    ended = subprocess.run(
        [sys.executable, "-m", "mapping.mapper"],
        env={**environment, "PYTHONPATH": str(ROOT)},
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=30,
    )
    assert ended.returncode == 1
    assert ended.stderr.startswith(f"{tmp_path / 'none.yaml'}:0: cannot read the lab file")
