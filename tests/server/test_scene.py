"""The 3D scene: what is drawn for which state, that nothing is sent twice, and the process around it."""

import asyncio
import dataclasses
import io
import json
import math
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import suppress
from pathlib import Path

import msgspec
import numpy as np
import pytest
import viser
import yaml
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from shapely.geometry import Polygon

from geometry import SE3
from protocol import keys
from protocol.bus import Bus
from protocol.channels import OBSTACLES, POSES, STATUSES
from protocol.clock import SimulatedClock, SystemClock
from protocol.codec import encode
from protocol.messages import CameraExtrinsics, CameraState, GuidanceState, Reason, ReasonCode
from server.scene import colors, shapes
from server.scene.feed import Feed
from server.scene.layer_floor import decoded
from server.scene.service import PortTakenError, Scene, open_server
from server.scene.world import FloorPicture, World
from tests.redis_fixture import RedisServer
from tests.server.guidance_scenario import LAB, OTHER, ROBOT, START_NS, Course, raster, square, status, tracked

ROOT = Path(__file__).parents[2]
SECOND = 1_000_000_000


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = open_server(free_port())
    yield server
    server.stop()


class Stage:
    """A scene with a clock to move and a world to fill."""

    def __init__(self, server: viser.ViserServer) -> None:
        self.server = server
        self.world = World()
        self.clock = SimulatedClock(START_NS)
        self.scene = Scene(LAB, server, self.world, self.clock)
        self.update()

    def update(self, seconds: float = 1.0) -> int:
        """What was sent after `seconds`."""
        self.clock.wait(seconds)
        before = self.scene.canvas.sent
        self.scene.update()
        return self.scene.canvas.sent - before

    def seen(self, robot: str, x: float, y: float, yaw: float = 0.0) -> None:
        self.world.poses[robot] = tracked(robot, x, y, yaw, stamp_ns=self.clock.now_ns())

    def told(self, robot: str, code: ReasonCode, blocked: bool = False) -> None:
        self.world.guidance[robot] = GuidanceState(
            robot=robot,
            stamp_ns=self.clock.now_ns(),
            reason=Reason(code=code),
            blocked=blocked,
            box=((1.2, 0.8), (1.8, 0.8), (1.8, 1.2), (1.2, 1.2)),
            carrot=(1.8, 1.0),
            path=((1.0, 1.0), (4.0, 1.0)),
            leg=0,
        )

    def handle(self, name: str) -> viser.SceneNodeHandle:
        handle = self.server.scene.get_handle_by_name(name)
        assert handle is not None, f"{name} is not in the scene"
        return handle

    def text(self, name: str) -> str:
        handle = self.handle(name)
        assert isinstance(handle, viser.LabelHandle)
        return handle.text

    def names(self, prefix: str = "/") -> set[str]:
        return {name for name in self.scene.canvas.names if name.startswith(prefix)}


@pytest.fixture
def stage(server: viser.ViserServer) -> Iterator[Stage]:
    server.scene.reset()
    yield Stage(server)
    server.scene.reset()


def test_the_lab_is_drawn_once(stage: Stage) -> None:
    assert {
        "/floor/ground",
        "/floor/grid",
        "/areas/camp",
        "/tags/outlines",
        "/tags/0",
        "/zones/crossing",
    } <= stage.names()
    assert stage.text("/zones/crossing/name") == "crossing"
    assert [stage.update() for _ in range(5)] == [0] * 5


def test_a_robot_appears_moves_and_fades_when_it_is_lost(stage: Stage) -> None:
    assert stage.names("/robots") == set()
    stage.seen(ROBOT, 1.0, 2.0, math.pi / 2)
    stage.told(ROBOT, ReasonCode.ROUTE)
    stage.update(0.0)
    assert f"/robots/{ROBOT}" in stage.names()
    assert f"/robots/{OTHER}" not in stage.names()
    frame = stage.handle(f"/robots/{ROBOT}")
    assert frame.position == pytest.approx((1.0, 2.0, 0.0))
    assert frame.wxyz == pytest.approx((math.sqrt(0.5), 0, 0, math.sqrt(0.5)))
    assert stage.text(f"/robots/{ROBOT}/label") == f"{ROBOT} · driving"
    deck = stage.handle(f"/robots/{ROBOT}/deck")
    assert isinstance(deck, viser.MeshHandle)
    assert tuple(deck.color) == colors.DRIVING
    assert deck.opacity is None

    stage.seen(ROBOT, 1.5, 2.0, math.pi / 2)
    assert stage.update(0.0) == 0
    assert stage.handle(f"/robots/{ROBOT}").position == pytest.approx((1.5, 2.0, 0.0))

    stage.update(12.0)
    assert stage.text(f"/robots/{ROBOT}/label") == f"{ROBOT} · not seen for 12 s"
    deck = stage.handle(f"/robots/{ROBOT}/deck")
    assert isinstance(deck, viser.MeshHandle)
    assert deck.opacity is not None
    assert deck.opacity < 0.5

    stage.world.poses.clear()
    stage.update()
    assert stage.names("/robots") == set()
    assert stage.server.scene.get_handle_by_name(f"/robots/{ROBOT}/deck") is None


@pytest.mark.parametrize(
    ("code", "color"),
    [
        (ReasonCode.OBSTACLE, colors.WAITING),
        (ReasonCode.EMERGENCY_STOP, colors.STOPPED),
        (ReasonCode.MANUAL, colors.MANUAL),
        (ReasonCode.IDLE, colors.IDLE),
    ],
)
def test_a_robot_has_the_colour_of_its_state(stage: Stage, code: ReasonCode, color: tuple[int, int, int]) -> None:
    stage.seen(ROBOT, 1.0, 2.0)
    stage.told(ROBOT, code)
    stage.update(0.0)
    deck = stage.handle(f"/robots/{ROBOT}/deck")
    assert isinstance(deck, viser.MeshHandle)
    assert tuple(deck.color) == color


def test_the_obstacle_box_is_blue_then_red_then_gone(stage: Stage) -> None:
    stage.seen(ROBOT, 1.0, 1.0)
    stage.told(ROBOT, ReasonCode.ROUTE)
    stage.update(0.0)
    assert {"/plan/boxes-clear", "/plan/box-borders-clear", "/plan/paths", "/plan/carrots"} <= stage.names("/plan")
    stage.told(ROBOT, ReasonCode.OBSTACLE, blocked=True)
    stage.update(0.0)
    assert "/plan/boxes-taken" in stage.names()
    assert "/plan/boxes-clear" not in stage.names()
    stage.update(1.0)
    assert stage.names("/plan") == set()


def test_obstacles_are_one_mesh_that_is_sent_when_they_change(stage: Stage) -> None:
    def put(*pallets: list[tuple[float, float]]) -> None:
        stage.world.obstacles = raster(pallets, stage.clock.now_ns() + SECOND)

    put(square(3.0, 1.0))
    assert stage.update() == 1
    mesh = stage.handle("/obstacles")
    assert isinstance(mesh, viser.BatchedMeshHandle)
    cells = np.asarray(mesh.batched_positions)
    assert len(cells) >= 64
    assert np.abs(cells[:, :2] - (3.0, 1.0)).max() <= 0.25
    put(square(3.0, 1.0))
    assert stage.update() == 0
    put(square(3.0, 1.1))
    assert stage.update(0.05) + stage.update(0.05) + stage.update(0.15) == 1
    put()
    stage.update()
    assert "/obstacles" not in stage.names()
    put(square(3.0, 1.0))
    stage.update()
    assert "/obstacles" in stage.names()
    stage.update(3.0)
    assert "/obstacles" not in stage.names()
    broken = msgspec.structs.replace(raster(), occupied=b"", stamp_ns=stage.clock.now_ns() + SECOND)
    stage.world.obstacles = broken
    assert stage.update() == 0


def test_waypoints_and_routes_come_change_and_go(stage: Stage) -> None:
    course = Course([(1.0, 1.0), (2.0, 1.0), (2.0, 2.0)], loop=True, yaws={1: 0.5})
    stage.world.waypoints, stage.world.routes = course.waypoints(), course.routes()
    stage.update()
    assert {"/waypoints/discs", "/waypoints/name-w0", "/waypoints/headings", "/plan/routes"} <= stage.names()
    route = stage.handle("/plan/routes")
    assert isinstance(route, viser.LineSegmentsHandle)
    assert np.asarray(route.points).shape == (3, 2, 3)
    assert stage.update() == 0
    moved = dataclasses.replace(course, points=[(1.0, 1.0), (2.5, 1.0), (2.0, 2.0)])
    stage.world.waypoints = moved.waypoints()
    assert 0 < stage.update() <= 5
    stage.world.waypoints = {"w0": course.waypoints()["w0"]}
    stage.update()
    assert stage.names("/waypoints") == {"/waypoints/discs", "/waypoints/rims", "/waypoints/name-w0"}
    assert stage.server.scene.get_handle_by_name("/waypoints/name-w1") is None
    stage.world.waypoints, stage.world.routes = {}, {}
    stage.update()
    assert stage.names("/waypoints") | stage.names("/plan") == set()


def test_cameras_hang_where_calibration_put_them_and_turn_red_without_a_picture(stage: Stage) -> None:
    pose = SE3.from_rotvec((math.pi, 0, 0), (1.0, 2.0, 3.0))
    rotvec = (float(pose.rotvec()[0]), float(pose.rotvec()[1]), float(pose.rotvec()[2]))
    stage.world.extrinsics["cam0"] = CameraExtrinsics("cam0", 0, rotvec, (1.0, 2.0, 3.0), 0.3, (0,))
    live = CameraState("cam0", stage.clock.now_ns() + SECOND, True, None, 1920, 1080, 15.0, 20.0, 1, 0, 0, (), 0.3, {})
    stage.world.cameras["cam0"] = live
    stage.update()
    frustum = stage.handle("/cameras/cam0")
    assert isinstance(frustum, viser.CameraFrustumHandle)
    assert frustum.position == pytest.approx((1.0, 2.0, 3.0))
    assert abs(frustum.wxyz[1]) == pytest.approx(1.0)
    assert frustum.aspect == pytest.approx(1920 / 1080)
    assert stage.text("/cameras/cam0/label") == "cam0"
    assert "/cameras/cam1" not in stage.names()
    stage.update(5.0)
    assert stage.text("/cameras/cam0/label") == "cam0 · no picture"
    stage.world.extrinsics.clear()
    stage.update()
    assert stage.names("/cameras") == set()


def jpeg(shade: int, size: tuple[int, int] = (40, 30)) -> bytes:
    buffer = io.BytesIO()
    Image.new("RGB", size, (shade, shade, shade)).save(buffer, "JPEG")
    return buffer.getvalue()


async def test_the_floor_picture_is_sent_when_it_changes_at_most_once_a_second(stage: Stage) -> None:
    bounds = (0.0, 0.0, 8.0, 4.0)

    async def sent(seconds: float, picture: FloorPicture | None) -> int:
        stage.clock.wait(seconds)
        stage.world.picture = picture
        before = stage.scene.pictures_sent
        await stage.scene.update_picture()
        return stage.scene.pictures_sent - before

    assert await sent(1.0, None) == 0
    assert await sent(0.0, FloorPicture(jpeg(10), bounds)) == 1
    image = stage.handle("/floor/picture")
    assert isinstance(image, viser.ImageHandle)
    assert (image.render_width, image.render_height) == (8.0, 4.0)
    assert image.position == pytest.approx((4.0, 2.0, 0.002))
    assert await sent(5.0, FloorPicture(jpeg(10), bounds)) == 0
    assert await sent(0.0, FloorPicture(jpeg(90), bounds)) == 1
    assert await sent(0.4, FloorPicture(jpeg(200), bounds)) == 0
    assert await sent(0.7, FloorPicture(jpeg(200), bounds)) == 1
    assert await sent(2.0, FloorPicture(b"no jpeg", bounds)) == 0


def test_large_pictures_are_made_smaller() -> None:
    pixels = decoded(FloorPicture(jpeg(10, (4000, 1000)), (0.0, 0.0, 8.0, 2.0)))
    assert pixels is not None
    assert pixels.shape == (400, 1600, 3)


class TestShapes:
    @given(st.integers(3, 9), st.floats(0.1, 3.0), st.booleans())
    def test_a_flat_area_covers_its_outline_and_faces_up(self, corners: int, radius: float, clockwise: bool) -> None:
        angles = [index * math.tau / corners for index in range(corners)]
        outline = [(radius * (1 + 0.5 * (i % 2)) * math.cos(a), radius * math.sin(a)) for i, a in enumerate(angles)]
        vertices, faces = shapes.flat(outline[::-1] if clockwise else outline, 0.5)
        a, b, c = (vertices[faces[:, index], :2].astype(float) for index in range(3))
        areas = ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])) / 2
        assert (areas > 0).all()
        assert areas.sum() == pytest.approx(Polygon(outline).area, rel=1e-4)
        assert (vertices[:, 2] == 0.5).all()

    def test_a_prism_has_its_walls_outside(self) -> None:
        vertices, faces = shapes.prism([(0, 0), (2, 0), (2, 1), (0, 1)], 0.0, 3.0)
        a, b, c = (vertices[faces[:, index]].astype(float) for index in range(3))
        normals = np.cross(b - a, c - a)
        outward = ((a + b + c) / 3 - (1.0, 0.5, 1.5)) * normals
        assert (outward.sum(axis=1) > 0).all()
        assert np.linalg.norm(normals, axis=1).sum() / 2 == pytest.approx(2 + 2 * 6 + 2 * 3)

    def test_dashes_cover_half_of_a_border(self) -> None:
        segments = shapes.dashed([(0, 0), (4, 0), (4, 4), (0, 4)], 0.1, dash_m=0.1)
        lengths = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
        assert lengths.sum() == pytest.approx(8.0, rel=0.02)


def test_a_port_in_use_is_said_and_no_other_one_taken() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(PortTakenError, match=f"port {port} on 127.0.0.1 is in use"):
            open_server(port)


def test_nobody_can_have_the_scene_published(server: viser.ViserServer) -> None:
    assert server.request_share_url() is None


async def until(condition: Callable[[], bool], limit_s: float = 5.0) -> None:
    deadline = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < deadline, "it did not come true"
        await asyncio.sleep(0.01)


async def put(write: Awaitable[object] | object) -> None:
    assert isinstance(write, Awaitable)
    await write


class TestFeed:
    @pytest.fixture
    async def world(self, redis_url: str) -> AsyncIterator[World]:
        """Fed while the test runs."""
        world, bus = World(), Bus.connect(redis_url)
        feed = Feed(world, bus, SystemClock())
        tasks = [asyncio.ensure_future(work) for work in (feed.follow(), feed.poll())]
        yield world
        for task in tasks:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task
        await bus.close()

    @pytest.fixture
    async def bus(self, redis_url: str) -> AsyncIterator[Bus]:
        bus = Bus.connect(redis_url)
        yield bus
        await bus.close()

    async def test_live_and_durable_things_arrive(self, world: World, bus: Bus) -> None:
        await put(bus.redis.hset(keys.WAYPOINTS, "w0", encode(Course([(1.0, 1.0)]).waypoints()["w0"])))
        await put(bus.redis.hset(keys.WAYPOINTS, "bad", b"{}"))
        await put(bus.redis.set(keys.FLOOR_PICTURE, jpeg(9)))
        await put(bus.redis.set(keys.FLOOR_PICTURE_BOUNDS, json.dumps([0, 0, 8, 4])))
        await bus.publish(POSES, ROBOT, tracked(ROBOT, 1.0, 1.0))
        await bus.publish(STATUSES, ROBOT, status(ROBOT))
        await bus.publish(OBSTACLES, "lab", raster())
        await until(
            lambda: bool(world.poses and world.statuses and world.waypoints and world.picture and world.obstacles)
        )
        assert set(world.waypoints) == {"w0"}
        await put(bus.redis.hdel(keys.WAYPOINTS, "w0"))
        await until(lambda: not world.waypoints)

    @pytest.mark.parametrize("bounds", [b"nonsense", b"[0, 0, 0, 4]", b"[0, 0, NaN, 4]", b"[1]"])
    async def test_a_picture_of_no_place_is_not_shown(self, bus: Bus, bounds: bytes) -> None:
        await put(bus.redis.set(keys.FLOOR_PICTURE, jpeg(9)))
        await put(bus.redis.set(keys.FLOOR_PICTURE_BOUNDS, bounds))
        world = World()
        await Feed(world, bus, SystemClock()).read_durable()
        assert world.picture is None

    async def test_it_goes_on_after_redis_was_killed(self, world: World, bus: Bus, redis_server: RedisServer) -> None:
        await bus.publish(POSES, ROBOT, tracked(ROBOT, 1.0, 1.0))
        await until(lambda: ROBOT in world.poses)
        redis_server.kill()
        redis_server.start()

        async def moved() -> bool:
            await bus.publish(POSES, ROBOT, tracked(ROBOT, 2.0, 1.0))
            return world.poses[ROBOT].x == 2.0

        deadline = time.monotonic() + 5.0
        while not await moved():
            assert time.monotonic() < deadline
            await asyncio.sleep(0.05)


class TestProcess:
    @pytest.fixture
    def start(self, redis_url: str, tmp_path: Path) -> Iterator[Callable[[int], "subprocess.Popen[bytes]"]]:
        started: list[subprocess.Popen[bytes]] = []

        def start(port: int) -> "subprocess.Popen[bytes]":
            lab = yaml.safe_load((ROOT / "labs/gulliver.yaml").read_text())
            lab["ports"] = {"http": 1, "scene": port}
            file = tmp_path / "lab.yaml"
            file.write_text(yaml.safe_dump(lab))
            environment = {
                **os.environ,
                "PYTHONPATH": str(ROOT),
                "LILLIPUT_LAB": str(file),
                "LILLIPUT_STATE": str(tmp_path),
                "REDIS_URL": redis_url,
            }
            process = subprocess.Popen(
                [sys.executable, "-m", "server.scene"],
                env=environment,
                stderr=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
            )
            started.append(process)
            return process

        yield start
        for process in started:
            process.kill()
            process.communicate(timeout=10)

    async def test_it_serves_on_loopback_and_ends_within_two_seconds(
        self, start: Callable[[int], "subprocess.Popen[bytes]"]
    ) -> None:
        port = free_port()
        process = start(port)

        def answers() -> bool:
            try:
                with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=2) as answer:
                    return bool(answer.status == 200)
            except OSError:
                return False

        deadline = time.monotonic() + 20
        while not await asyncio.to_thread(answers):
            assert time.monotonic() < deadline
        stderr = process.stderr
        assert stderr is not None
        while b"the scene of gulliver" not in await asyncio.to_thread(stderr.readline):
            assert process.poll() is None
        began = time.monotonic()
        process.send_signal(signal.SIGTERM)
        assert await asyncio.to_thread(process.wait, 10) in (0, -signal.SIGTERM)
        assert time.monotonic() - began < 2.0

    async def test_a_port_in_use_ends_it_with_a_sentence(
        self, start: Callable[[int], "subprocess.Popen[bytes]"]
    ) -> None:
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            process = start(taken.getsockname()[1])
            _, said = await asyncio.to_thread(process.communicate, None, 30)
        assert process.returncode != 0

        assert b"is in use" in said
        assert b"Traceback" not in said
