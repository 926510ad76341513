"""The lab's service with real UDP, a real Redis and real frame rings."""

import asyncio
import logging
import math
import time
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
import redis

from lab.service import LabService, PortTakenError
from protocol import keys
from protocol.channels import GROUND_TRUTH, LAB_INSTANCE
from protocol.clock import SystemClock
from protocol.codec import decode, encode
from protocol.datagram import Datagram, pack
from protocol.frames import Frame, FrameReader
from protocol.lab import load_lab
from protocol.messages import CameraFault, DriveSetpoint, FaultKind, GroundTruth, Odometry, SimulatedObject, TruePose
from protocol.settings import Settings, frame_ring
from tests.lab.laboratory import PATIENCE_S, RobotComputer, robot_computer, settings_for, write_lab
from tests.redis_fixture import RedisServer

WIFIBOT = "wifibot-14"


@asynccontextmanager
async def running(settings: Settings) -> AsyncGenerator[LabService]:
    service = LabService(load_lab(settings.lab), settings, SystemClock())
    task = asyncio.create_task(service.run())
    try:
        yield service
        assert not task.done(), task.exception()
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def until(condition: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, f"not within {PATIENCE_S} s: {what}"
        await asyncio.sleep(0.005)


async def drive_until(computer: RobotComputer, linear_mps: float, condition: Callable[[], object], what: str) -> None:
    """Holds the twist with a set-point every few milliseconds."""

    def step() -> object:
        computer.drive(linear_mps)
        computer.receive()
        return condition()

    await until(step, what)


def truth_in(client: redis.Redis) -> GroundTruth | None:
    raw = client.hget(keys.live(GROUND_TRUTH.name), LAB_INSTANCE)
    return None if raw is None else decode(GroundTruth, bytes(raw))  # pyright: ignore[reportArgumentType]  # typed for both clients


async def ring(settings: Settings, camera_id: str) -> FrameReader:
    path = frame_ring(settings.state, camera_id)
    await until(path.exists, f"ring of {camera_id}")
    return FrameReader(path)


async def frames(reader: FrameReader, count: int) -> list[Frame]:
    taken: list[Frame] = []

    def take() -> bool:
        frame = reader.newest()
        if frame is not None:
            taken.append(frame)
        return len(taken) >= count

    await until(take, f"{count} frames")
    return taken


@pytest.fixture
def settings(tmp_path: Path, redis_url: str) -> Settings:
    return settings_for(write_lab(tmp_path), redis_url)


async def test_cameras_put_stamped_frames_into_their_rings(settings: Settings) -> None:
    async with running(settings):
        for camera_id in ("cam0", "cam1"):
            with await ring(settings, camera_id) as reader:
                taken = await frames(reader, 4)
            assert taken[0].pixels.shape == (270, 480)
            assert taken[0].pixels.std() > 10
            stamps = [frame.stamp_ns for frame in taken]
            assert (np.diff(stamps) >= 0.04e9).all(), "20 frames per second on steps of 10 ms"
            assert abs(time.time_ns() - stamps[-1]) < 1e9
    assert not frame_ring(settings.state, "cam0").parent.exists(), "nothing is left behind"


async def test_set_points_move_the_vehicle_and_odometry_comes_back(settings: Settings) -> None:
    async with running(settings) as service:
        with robot_computer(WIFIBOT, service.world.lab.ports.lab_udp) as computer:
            before = service.world.truth().vehicles[WIFIBOT]

            def moved() -> float:
                now = service.world.truth().vehicles[WIFIBOT]
                return math.dist((now.x, now.y), (before.x, before.y))

            await drive_until(computer, 0.5, lambda: moved() > 0.15, "it drives")
            odometry = computer.receive()
            assert {item.vehicle for item in odometry} == {WIFIBOT}
            assert {item.session for item in odometry} == {service.world.session}
            assert odometry[-1].x == pytest.approx(moved(), abs=0.05)
            assert np.median(np.diff([item.stamp_ns for item in odometry])) == 20_000_000
            await until(lambda: service.world.truth().vehicles[WIFIBOT].linear_mps == 0.0, "the watchdog stops it")


async def test_the_truth_is_published(settings: Settings, redis_url: str) -> None:
    with redis.Redis.from_url(redis_url) as client:
        async with running(settings) as service:
            await until(lambda: truth_in(client), "ground truth")
            truth = truth_in(client)
            assert truth is not None
            assert set(truth.vehicles) == set(service.world.vehicle_ids)
            assert truth.vehicles[WIFIBOT].x == pytest.approx(1.0)
            first = truth.stamp_ns
            await until(lambda: (truth_in(client) or truth).stamp_ns > first + 2e8, "it goes on")


async def test_what_is_not_a_fresh_set_point_has_no_effect(
    settings: Settings, caplog: pytest.LogCaptureFixture
) -> None:
    async with running(settings) as service:
        world, link = service.world, service.base_link
        with robot_computer(WIFIBOT, world.lab.ports.lab_udp) as computer:
            await drive_until(computer, 0.0, lambda: computer.odometry, "odometry")
            await asyncio.sleep(0)
            now = time.time_ns()
            late = Datagram(WIFIBOT, 1, now - 5_000_000_000, DriveSetpoint(WIFIBOT, 1, 0.5, 0.0))
            early = Datagram(WIFIBOT, 1, now + 5_000_000_000, DriveSetpoint(WIFIBOT, 1, 0.5, 0.0))
            other = Datagram("wifibot-15", 1, now, DriveSetpoint(WIFIBOT, 1, 0.5, 0.0))
            wrong_kind = Datagram("odd", 1, now, Odometry(WIFIBOT, "x", 1, 0, 0, 0, 0, 0, 1))
            good = computer.drive(0.0)
            bad = {
                "unreadable": [b"", b"LP", b"\x00" * 80, good[:-3], good + b"x"],
                "of another kind": [pack(wrong_kind)],
                "of another sender": [pack(other)],
                "old": [pack(late)],
                "future": [pack(early)],
                "duplicate": [good],
            }
            for datagrams in bad.values():
                for data in datagrams:
                    computer.send(data)
            computer.drive(0.5, vehicle="nobody")
            expected = {why: len(datagrams) for why, datagrams in bad.items()} | {"for unknown vehicles": 1}
            await until(lambda: link.rejected == expected, f"all are counted: {link.rejected}")
            assert world.truth().vehicles[WIFIBOT].linear_mps == 0.0
        with caplog.at_level(logging.WARNING):
            link.report()
        assert "1 for unknown vehicles" in caplog.text
        assert "5 unreadable" in caplog.text


async def test_with_a_key_only_signed_set_points_count(tmp_path: Path, redis_url: str) -> None:
    settings = settings_for(write_lab(tmp_path), redis_url, b"secret")
    async with running(settings) as service:
        port = service.world.lab.ports.lab_udp
        with robot_computer(WIFIBOT, port) as stranger, robot_computer(WIFIBOT, port, b"secret") as computer:
            await drive_until(stranger, 0.5, lambda: service.base_link.rejected["unreadable"] > 3, "refused")
            assert service.base_link.accepted == 0
            assert service.world.truth().vehicles[WIFIBOT].linear_mps == 0.0
            await drive_until(computer, 0.5, lambda: len(computer.odometry) > 3, "signed odometry")
            assert service.world.truth().vehicles[WIFIBOT].linear_mps > 0.0


async def test_objects_appear_change_and_go_with_their_hash(settings: Settings, redis_url: str) -> None:
    with redis.Redis.from_url(redis_url) as client:
        async with running(settings) as service:
            with await ring(settings, "cam0") as reader:
                empty = (await frames(reader, 1))[0].pixels.astype(int)
                client.hset(
                    keys.SIMULATED_OBJECTS, "box", encode(SimulatedObject(id="box", kind="pallet", x=1.0, y=2.0))
                )
                client.hset(keys.SIMULATED_OBJECTS, "junk", b"{}")
                client.hset(keys.SIMULATED_OBJECTS, "liar", encode(SimulatedObject(id="box", kind="person", x=3, y=2)))
                await until(lambda: service.world.object_ids == ("box",), "the pallet, and nothing that is no object")
                seen: list[Frame] = []
                await until(lambda: _differs(reader, seen, empty), "it is in the picture")
                moved = SimulatedObject(id="box", kind="pallet", x=2.0, y=2.0)
                client.hset(keys.SIMULATED_OBJECTS, "box", encode(moved))
                await until(lambda: service.world.snapshot().objects[0].x == 2.0, "moved")
                client.hdel(keys.SIMULATED_OBJECTS, "box")
                await until(lambda: not service.world.object_ids, "gone")


def _differs(reader: FrameReader, seen: list[Frame], empty: np.ndarray[tuple[int, ...], np.dtype[np.int_]]) -> bool:
    frame = reader.newest()
    if frame is not None:
        seen.append(frame)
    return bool(seen) and int((np.abs(seen[-1].pixels.astype(int) - empty) > 30).sum()) > 300


async def test_a_walking_person_is_not_put_back_by_the_poll(settings: Settings, redis_url: str) -> None:
    item = SimulatedObject(id="ann", kind="person", x=3.0, y=2.0, path=((5.0, 2.0),), speed_mps=1.5)
    with redis.Redis.from_url(redis_url) as client:
        client.hset(keys.SIMULATED_OBJECTS, "ann", encode(item))
    async with running(settings) as service:
        await until(lambda: service.world.object_ids, "Ann")
        await until(lambda: service.world.snapshot().objects[0].x > 4.0, "she walks on")


async def test_it_goes_on_without_redis_and_comes_back_to_it(settings: Settings, redis_server: RedisServer) -> None:
    with redis.Redis.from_url(redis_server.url) as client:
        client.hset(keys.SIMULATED_OBJECTS, "box", encode(SimulatedObject(id="box", kind="pallet", x=3.0, y=2.0)))
        async with running(settings) as service:
            await until(lambda: service.world.object_ids, "the pallet")
            with (
                await ring(settings, "cam0") as reader,
                robot_computer(WIFIBOT, service.world.lab.ports.lab_udp) as robot,
            ):
                redis_server.kill()
                await frames(reader, 5)
                await drive_until(robot, 0.3, lambda: len(robot.odometry) > 20, "odometry")
                assert service.world.object_ids == ("box",), "what stood stays"
                redis_server.start()
                before = service.world.stamp_ns
                await until(lambda: _stamp(client) > before, "the truth again")


def _stamp(client: redis.Redis) -> int:
    try:
        truth = truth_in(client)
    except redis.RedisError:
        return 0
    return 0 if truth is None else truth.stamp_ns


async def test_a_restarted_lab_finds_the_vehicles_where_they_stood(settings: Settings, redis_url: str) -> None:
    async with running(settings) as first:
        with robot_computer(WIFIBOT, first.world.lab.ports.lab_udp) as computer:
            await drive_until(computer, 0.6, lambda: first.world.truth().vehicles[WIFIBOT].x > 1.3, "it drives")
        with redis.Redis.from_url(redis_url) as client:

            def saved() -> bool:
                raw = client.hget(keys.SIMULATED_STATE, WIFIBOT)
                now = first.world.truth().vehicles[WIFIBOT]
                return now.linear_mps == 0.0 and raw is not None and decode(TruePose, bytes(raw)) == now  # pyright: ignore[reportArgumentType]  # typed for both clients

            await until(saved, "it stands still and that is saved")
        stood, session = first.world.truth().vehicles[WIFIBOT], first.world.session
    async with running(settings) as second:
        with robot_computer(WIFIBOT, second.world.lab.ports.lab_udp) as computer:
            await drive_until(computer, 0.0, lambda: computer.odometry, "odometry")
            odometry = computer.odometry[0]
        assert odometry.session != session
        assert (odometry.x, odometry.y, odometry.yaw) == (0.0, 0.0, 0.0)
        assert second.world.truth().vehicles[WIFIBOT] == stood


async def test_a_lab_that_is_earlier_than_redis_waits_for_the_saved_poses(
    settings: Settings, redis_server: RedisServer
) -> None:
    with redis.Redis.from_url(redis_server.url) as client:
        client.hset(keys.SIMULATED_STATE, WIFIBOT, encode(TruePose(5.0, 2.0, 1.0, 0.0, 0.0)))
        client.hset(keys.SIMULATED_STATE, "wifibot-15", encode(TruePose(50.0, 2.0, 1.0, 0.0, 0.0)))
        client.hset(keys.SIMULATED_STATE, "turtlebot-16", b"not a pose")
        client.hset(keys.SIMULATED_STATE, "stranger", encode(TruePose(5.0, 2.0, 1.0, 0.0, 0.0)))
    redis_server.kill()
    async with running(settings) as service:
        redis_server.start()
        await until(lambda: service.world.truth().vehicles[WIFIBOT].x == 5.0, "the saved pose")
        vehicles = service.world.truth().vehicles
        assert (vehicles["wifibot-15"].x, vehicles["turtlebot-16"].x) == (1.0, 7.0), "what cannot be is ignored"


async def test_a_lossy_network_loses_set_points_and_odometry(tmp_path: Path, redis_url: str) -> None:
    network = {"loss": 0.5, "duplication": 0.2, "delay_s": 0.02, "jitter_s": 0.01}
    async with running(settings_for(write_lab(tmp_path, network=network), redis_url)) as service:
        link = service.base_link
        with robot_computer(WIFIBOT, service.world.lab.ports.lab_udp) as computer:
            sent = 0

            def heard_enough() -> bool:
                nonlocal sent
                sent += 1
                computer.drive(0.2)
                computer.receive()
                return link.accepted > 30 and link.rejected["duplicate"] + link.rejected["out of order"] > 0

            await until(heard_enough, "some get through")
            assert sum(link.rejected.values()) + link.accepted < 0.85 * sent
            stamps = [item.stamp_ns for item in computer.odometry]
            assert len(set(stamps)) < len(range(min(stamps), max(stamps), 20_000_000)), "odometry has gaps"


async def test_a_taken_port_is_named(settings: Settings) -> None:
    async with running(settings) as first:
        port = first.world.lab.ports.lab_udp
        await until(lambda: first.feeds, "it runs")
        with pytest.raises(PortTakenError, match=f"127.0.0.1:{port}"):
            await LabService(load_lab(settings.lab), settings, SystemClock()).run()


def shifted(reader: FrameReader, seen: list[Frame], before: np.ndarray[tuple[int, ...], np.dtype[np.int_]]) -> bool:
    """Whether the newest frame shows the room from elsewhere: edges all over the picture differ."""
    frame = reader.newest()
    if frame is not None:
        seen.append(frame)
    return bool(seen) and int((np.abs(seen[-1].pixels.astype(int) - before) > 40).sum()) > 150


async def test_cameras_suffer_what_their_hash_says_until_it_is_taken_back(settings: Settings, redis_url: str) -> None:
    with redis.Redis.from_url(redis_url) as client:

        def suffer(**fault: object) -> None:
            client.hset(keys.SIMULATED_FAULTS, "cam0", encode(CameraFault.model_validate(fault)))

        async with running(settings):
            path = frame_ring(settings.state, "cam0")
            with await ring(settings, "cam0") as reader, await ring(settings, "cam1") as other:
                good = (await frames(reader, 1))[0].pixels.astype(int)
                client.hset(keys.SIMULATED_FAULTS, "cam1", b"junk")

                suffer(kind=FaultKind.STALL)
                while not await _silent(reader, other):
                    pass
                assert not reader.replaced(), "it stays connected"

                suffer(kind=FaultKind.NOISE)
                await until(lambda: (frame := reader.newest()) is not None and frame.pixels.std() > 70, "garbage")

                suffer(kind=FaultKind.COVER, cover_share=0.5)
                await until(lambda: (frame := reader.newest()) and frame.pixels[:, :240].mean() < 15, "a dark half")

                suffer(kind=FaultKind.BUMP, shift_x_m=0.05)
                await until(lambda: shifted(reader, [], good), "it hangs elsewhere")
                client.hdel(keys.SIMULATED_FAULTS, "cam0")
                await until(lambda: (frame := reader.newest()) and _alike(frame, good), "it is back in its place")

                suffer(kind=FaultKind.UNPLUG)
                await until(lambda: not path.exists(), "it is gone")
                assert reader.replaced()
            suffer(kind=FaultKind.RESIZE)
            with await ring(settings, "cam0") as reader:
                assert (await frames(reader, 1))[0].pixels.shape == (135, 240)
                client.hdel(keys.SIMULATED_FAULTS, "cam0")
                await until(reader.replaced, "well again")
            with await ring(settings, "cam0") as reader:
                assert _alike((await frames(reader, 1))[0], good)


async def _silent(reader: FrameReader, other: FrameReader) -> bool:
    """Whether this camera sends nothing while the other one sends ten frames."""
    reader.newest()
    await frames(other, 10)
    return reader.newest() is None


def _alike(frame: Frame, good: np.ndarray[tuple[int, ...], np.dtype[np.int_]]) -> bool:
    return frame.pixels.shape == good.shape and int((np.abs(frame.pixels.astype(int) - good) > 40).sum()) < 50
