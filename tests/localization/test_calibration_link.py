"""A camera's side of calibration at run time, with rendered frames and a real Redis."""

from collections.abc import Iterator
from typing import cast

import numpy as np
import pytest
import redis
from numpy.typing import NDArray

from geometry import SE2, SE3
from localization.calibration_link import CalibrationLink, received_sighting
from localization.pipeline import CameraPipeline, PipelineOptions
from localization.projection import extrinsics_pose
from protocol import keys
from protocol.bus import SyncBus
from protocol.channels import CALIBRATION_RUNS, EVENTS, LAB_INSTANCE, SIGHTINGS
from protocol.clock import SimulatedClock
from protocol.codec import decode, encode
from protocol.frames import Frame
from protocol.lab import camera_basis, floor_basis
from protocol.messages import (
    CalibratedCamera,
    CalibratedFloorTag,
    Calibration,
    CalibrationRun,
    CameraExtrinsics,
    Event,
    RunState,
)
from protocol.messages.calibration import CURRENT
from tests.localization.synthetic import MOUNTS, PlacedTag, floor_tags, render, small_lab
from tests.redis_fixture import RedisServer

LAB = small_lab()
MODEL = LAB.camera("left").model()
BUMPED = SE3.from_rotvec([0, 0, 0], [0.02, 0.0, 0.0]) @ MOUNTS["left"]
PERIOD_S = 1 / 15
START_NS = SimulatedClock().now_ns()


def picture(mount: SE3, tags: list[PlacedTag] | None = None) -> NDArray[np.uint8]:
    return render(MODEL, mount, tags or floor_tags(LAB))


@pytest.fixture(scope="module")
def still() -> NDArray[np.uint8]:
    return picture(MOUNTS["left"])


@pytest.fixture(scope="module")
def pushed() -> NDArray[np.uint8]:
    return picture(BUMPED)


class Camera:
    """A camera's process without the process: frames in, `note` after each, `exchange` after each seventh."""

    def __init__(self, bus: SyncBus, extrinsics: CameraExtrinsics | None = None) -> None:
        self.bus, self.clock = bus, SimulatedClock()
        options = PipelineOptions(full_search_every=5, calibration_frames=4)
        self.pipeline = CameraPipeline(LAB, "left", clock=self.clock, options=options, extrinsics=extrinsics)
        self.link = CalibrationLink(LAB, self.pipeline, bus, self.clock)
        self.number = 0
        self.alarms: list[str | None] = []

    def show(self, pixels: NDArray[np.uint8], frames: int = 1) -> None:
        for _ in range(frames):
            self.clock.wait(PERIOD_S)
            self.number += 1
            self.pipeline.process(Frame(self.number, self.clock.now_ns(), pixels))
            if self.link.note():
                self.alarms.append(self.pipeline.problem)
            if self.number % 7 == 0:
                self.link.exchange()
        self.link.exchange()

    def calibrated(self, pixels: NDArray[np.uint8]) -> CameraExtrinsics:
        self.show(pixels, 12)
        assert self.pipeline.extrinsics is not None
        return self.pipeline.extrinsics

    def ask(self, run_id: int) -> None:
        now_ns = self.clock.now_ns()
        state = RunState.COLLECTING
        run = CalibrationRun(id=run_id, state=state, stamp_ns=now_ns, started_ns=now_ns, by="olga", cameras=("left",))
        self.bus.publish(CALIBRATION_RUNS, LAB_INSTANCE, run)

    def put_in_force(self, calibration: Calibration) -> None:
        self.bus.redis.hset(keys.CALIBRATIONS, CURRENT, encode(calibration))  # pyright: ignore[reportArgumentType]

    def events(self) -> list[tuple[str, str]]:
        entries = cast("list[tuple[bytes, dict[bytes, bytes]]]", self.bus.redis.xrange(keys.stream(EVENTS.name)))
        events = [decode(Event, fields[b"m"]) for _, fields in entries]
        return [(str(event.level), event.kind) for event in events]


@pytest.fixture
def bus(redis_url: str) -> Iterator[SyncBus]:
    made = SyncBus.connect(redis_url)
    yield made
    made.close()


@pytest.fixture
def camera(bus: SyncBus) -> Camera:
    return Camera(bus)


def joint(extrinsics: CameraExtrinsics, stamp_ns: int, x_m: float = 0.0, *, basis: str | None = None) -> Calibration:
    """A joint result that has the camera `x_m` aside, and with it all floor tags."""
    x, y, z = extrinsics.translation
    moved = CameraExtrinsics("left", 1, extrinsics.rotvec, (x + x_m, y, z), 0.1, (0, 1, 2, 3), extrinsics.covariance)
    places = {tag: SE2(pose[0] + x_m, *pose[1:]) for tag, pose in LAB.floor_tags.poses.items()}
    return Calibration(
        id=9,
        stamp_ns=stamp_ns,
        by="olga",
        floor_basis=floor_basis(LAB.floor_tags),
        cameras={"left": CalibratedCamera.of(moved, (), basis or camera_basis(LAB.camera("left")))},
        floor_tags={t: CalibratedFloorTag(x=p.x, y=p.y, yaw=p.yaw, shift_m=abs(x_m)) for t, p in places.items()},
    )


def test_a_camera_that_found_its_place_tells_what_it_saw(camera: Camera, still: NDArray[np.uint8]) -> None:
    found = camera.calibrated(still)
    sent = camera.bus.latest_all(SIGHTINGS)["left"]
    assert set(sent.corners) == {0, 1, 2, 3}
    assert (sent.extrinsics_ns, sent.request) == (found.stamp_ns, 0)
    assert sent.basis == camera_basis(LAB.camera("left"))
    assert camera.pipeline.sighting is not None
    for tag, corners in received_sighting(sent).corners.items():
        np.testing.assert_array_equal(corners, camera.pipeline.sighting.corners[tag])
    assert camera.events() == [("info", "camera_calibrated")]


def test_what_comes_into_force_is_taken_at_once_and_only_once(camera: Camera, still: NDArray[np.uint8]) -> None:
    own = camera.calibrated(still)
    camera.put_in_force(joint(own, camera.clock.now_ns(), 0.3))
    camera.link.exchange()
    assert camera.pipeline.extrinsics is not None
    assert camera.pipeline.extrinsics.translation[0] == pytest.approx(own.translation[0] + 0.3)
    camera.show(still, 30)
    assert camera.pipeline.problem is None, "the floor tags are expected where the result has them"
    assert camera.pipeline.extrinsics.translation[0] == pytest.approx(own.translation[0] + 0.3)


def test_a_place_that_the_camera_found_later_by_itself_outranks_what_is_in_force(
    camera: Camera, still: NDArray[np.uint8]
) -> None:
    own = camera.calibrated(still)
    camera.put_in_force(joint(own, own.stamp_ns - 1, 0.3))
    camera.link.exchange()
    assert camera.pipeline.extrinsics == own


def test_a_restart_takes_the_newer_of_its_own_and_what_is_in_force(
    bus: SyncBus, camera: Camera, still: NDArray[np.uint8]
) -> None:
    own = camera.calibrated(still)
    camera.put_in_force(joint(own, own.stamp_ns + 1, 0.3))
    again = Camera(bus, own)
    again.link.exchange()
    assert again.pipeline.extrinsics is not None
    assert again.pipeline.extrinsics.translation[0] == pytest.approx(own.translation[0] + 0.3)
    assert again.pipeline.extrinsics.stamp_ns == own.stamp_ns + 1


@pytest.mark.parametrize("what", ["garbage", "other intrinsics", "other floor tags"])
def test_a_result_that_does_not_fit_is_not_taken(camera: Camera, still: NDArray[np.uint8], what: str) -> None:
    own = camera.calibrated(still)
    result = joint(own, camera.clock.now_ns(), 0.3)
    match what:
        case "garbage":
            camera.bus.redis.hset(keys.CALIBRATIONS, CURRENT, "{")
        case "other intrinsics":
            camera.put_in_force(joint(own, camera.clock.now_ns(), 0.3, basis="another"))
        case _:
            camera.put_in_force(result.model_copy(update={"floor_basis": "another"}))
    camera.link.exchange()
    assert camera.pipeline.extrinsics == own


def test_who_asks_gets_a_new_look_while_poses_go_on(camera: Camera, still: NDArray[np.uint8]) -> None:
    camera.calibrated(still)
    before = camera.bus.latest_all(SIGHTINGS)["left"]
    camera.ask(7)
    camera.link.exchange()
    for _ in range(12):
        camera.show(still)
        assert camera.pipeline.extrinsics is not None
    answer = camera.bus.latest_all(SIGHTINGS)["left"]
    assert answer.request == 7
    assert answer.stamp_ns > before.stamp_ns
    camera.show(still, 30)
    assert camera.bus.latest_all(SIGHTINGS)["left"] == answer, "asked once, answered once"


def test_a_bumped_camera_raises_an_alarm_within_two_seconds_and_finds_its_place(
    camera: Camera, still: NDArray[np.uint8], pushed: NDArray[np.uint8]
) -> None:
    camera.calibrated(still)
    camera.alarms.clear()
    bumped_s = camera.clock.monotonic_s()
    while not camera.alarms:
        camera.show(pushed)
    assert camera.clock.monotonic_s() - bumped_s < 2.0
    assert camera.alarms[0] is not None
    assert "the camera moved" in camera.alarms[0]
    while camera.pipeline.extrinsics is None:
        camera.show(pushed)
    assert camera.clock.monotonic_s() - bumped_s < 4.0
    assert camera.pipeline.problem is None
    off = extrinsics_pose(camera.pipeline.extrinsics).translation - BUMPED.translation
    assert float(np.abs(off).max()) < 0.004
    camera.show(pushed)
    assert [e for e in camera.events() if e[1] != "camera_calibrated"] == [("error", "camera_not_calibrated")]
    assert camera.bus.latest_all(SIGHTINGS)["left"].extrinsics_ns == camera.pipeline.extrinsics.stamp_ns


def test_a_floor_tag_that_was_kicked_is_named_and_poses_go_on(camera: Camera, still: NDArray[np.uint8]) -> None:
    camera.calibrated(still)
    kicked = [
        PlacedTag(t.tag_id, SE2(t.pose.x + 0.03, t.pose.y, t.pose.yaw), 0.0, t.size_m) if t.tag_id == 2 else t
        for t in floor_tags(LAB)
    ]
    camera.show(picture(MOUNTS["left"], kicked), 60)
    assert camera.pipeline.extrinsics is not None
    assert set(camera.pipeline.displaced_floor_tags) == {2}
    assert camera.events().count(("warning", "floor_tag_displaced")) == 1


def test_without_redis_nothing_is_lost_but_time(
    redis_server: RedisServer, camera: Camera, still: NDArray[np.uint8]
) -> None:
    redis_server.kill()
    camera.calibrated(still)
    redis_server.start()
    with redis.Redis.from_url(redis_server.url) as client:
        client.ping()
    camera.link.exchange()
    assert camera.events() == [("info", "camera_calibrated")]
    assert "left" in camera.bus.latest_all(SIGHTINGS)


def test_what_redis_lost_is_told_again(camera: Camera, still: NDArray[np.uint8]) -> None:
    camera.calibrated(still)
    sent = camera.bus.latest_all(SIGHTINGS)
    assert not camera.link.exchange()
    camera.bus.redis.flushall()
    assert camera.link.exchange(), "so that the camera writes its extrinsics again"
    assert camera.bus.latest_all(SIGHTINGS) == sent
