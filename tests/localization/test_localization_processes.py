"""The processes as they run: frames through a ring, a real Redis, UDP to a robot; Redis dies and comes back."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar, cast

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import SE2
from localization.projection import extrinsics_pose
from protocol import keys
from protocol.bus import SyncBus
from protocol.channels import CAMERA_STATES, DETECTIONS, POSES, REGISTRATIONS
from protocol.codec import decode
from protocol.datagram import unpack
from protocol.frames import FrameWriter
from protocol.messages import CameraExtrinsics, CameraState, Registration, TrackedPose
from protocol.settings import frame_ring, frames_folder
from tests.localization.synthetic import MOUNTS, SMALL_LAB, floor_tags, render, small_lab, vehicle_tag
from tests.redis_fixture import RedisServer

ROOT = Path(__file__).resolve().parents[2]
KEY = b"\x01\x02\x03"
POSE = SE2(0.9, 0.6, 0.4)
WITHIN_S = 30.0


T = TypeVar("T")


def eventually(probe: Callable[[], T | None], what: str) -> T:
    """What `probe` gives as soon as it gives something."""
    deadline = time.monotonic() + WITHIN_S
    while (value := probe()) is None:
        assert time.monotonic() < deadline, f"not within {WITHIN_S} s: {what}"
        time.sleep(0.02)
    return value


class Ring:
    """A simulated camera that shows one picture again and again."""

    def __init__(self, state: Path, pixels: NDArray[np.uint8]) -> None:
        self._state, self._pixels = state, pixels
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._write)
        self._thread.start()

    def _write(self) -> None:
        height, width = self._pixels.shape
        writer = FrameWriter(frame_ring(self._state, "left"), width, height)
        while not self._ended.wait(1 / 15):
            writer.write(self._pixels, time.time_ns())
        writer.close()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()


class House:
    """Processes of one small lab with their Redis and state folder."""

    def __init__(self, folder: Path, redis: RedisServer) -> None:
        self.state, self.redis = folder / "state", redis
        (folder / "lab.yaml").write_text(SMALL_LAB)
        self.environment = os.environ | {
            "LILLIPUT_LAB": str(folder / "lab.yaml"),
            "LILLIPUT_STATE": str(self.state),
            "REDIS_URL": redis.url,
            "LILLIPUT_UDP_KEY": KEY.hex(),
            "PYTHONPATH": str(ROOT),
        }
        self.bus = SyncBus.connect(redis.url)
        self.running: list[subprocess.Popen[bytes]] = []
        self.rings: list[Ring] = []

    def start(self, *arguments: str) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [sys.executable, "-m", *arguments], cwd=ROOT, env=self.environment, stderr=subprocess.PIPE
        )
        self.running.append(process)
        return process

    def show(self, pixels: NDArray[np.uint8]) -> Ring:
        self.rings.append(Ring(self.state, pixels))
        return self.rings[-1]

    def camera_state(self, fits: Callable[[CameraState], bool]) -> CameraState:
        """The first state that fits."""

        def fitting() -> CameraState | None:
            state = self.bus.latest_all(CAMERA_STATES).get("left")
            return state if state is not None and fits(state) else None

        return eventually(fitting, "such a state of the camera")

    def pose(self, since_ns: int = 0) -> TrackedPose | None:
        pose = self.bus.latest_all(POSES).get("robot-10")
        return pose if pose is not None and pose.stamp_ns > since_ns else None

    def extrinsics(self) -> CameraExtrinsics | None:
        raw = cast("bytes | None", self.bus.redis.hget(keys.EXTRINSICS, "left"))
        return None if raw is None else decode(CameraExtrinsics, raw)

    def close(self) -> None:
        for process in self.running:
            if process.poll() is None:
                process.kill()
            process.wait(10)
            if process.stderr is not None:
                process.stderr.close()
        for ring in self.rings:
            ring.close()
        if frames_folder(self.state).is_dir():
            frames_folder(self.state).rmdir()
        self.bus.close()


@pytest.fixture
def house(tmp_path: Path, redis_server: RedisServer) -> Iterator[House]:
    made = House(tmp_path, redis_server)
    yield made
    made.close()


@pytest.fixture(scope="module")
def picture() -> NDArray[np.uint8]:
    lab = small_lab()
    tags = [*floor_tags(lab), vehicle_tag(lab, "robot-10", POSE)]
    return render(lab.camera("left").model(), MOUNTS["left"], tags)


@pytest.fixture
def robot() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind(("127.0.0.1", 0))
        made.settimeout(WITHIN_S)
        yield made


def ended_within(process: subprocess.Popen[bytes], seconds: float) -> bool:
    process.send_signal(signal.SIGTERM)
    start = time.monotonic()
    process.wait(WITHIN_S)
    return process.returncode == 0 and time.monotonic() - start < seconds


def test_from_the_ring_to_the_robot_and_through_a_death_of_redis(
    house: House, picture: NDArray[np.uint8], robot: socket.socket
) -> None:
    registration = Registration(robot="robot-10", host="127.0.0.1", udp_port=robot.getsockname()[1])
    house.bus.publish(REGISTRATIONS, "robot-10", registration)
    tracker, camera = house.start("localization.tracker"), house.start("localization.camera", "left")
    house.camera_state(lambda state: state.error is not None and "no frames yet" in state.error and not state.connected)
    house.show(picture)
    pose = eventually(house.pose, "a pose")
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((POSE.x, POSE.y, POSE.yaw), abs=0.003)
    assert abs(time.time_ns() - pose.stamp_ns) < 2e9

    received = unpack(robot.recv(2048), KEY)
    assert received.sender == "tracker"
    assert isinstance(received.message, TrackedPose)
    assert received.message.vehicle == "robot-10"

    state = house.camera_state(lambda state: state.reprojection_px is not None and state.rate_hz > 5)
    assert state.connected
    assert state.error is None
    assert state.floor_tags_seen == (0, 1, 2, 3)
    assert state.reprojection_px is not None
    assert state.reprojection_px < 0.5
    assert {"wait", "window", "full", "undistort", "pose"} <= set(state.timings_ms)
    found = eventually(house.extrinsics, "extrinsics")
    off = extrinsics_pose(found).translation - MOUNTS["left"].translation
    assert float(np.abs(off).max()) < 0.003
    jpeg = eventually(lambda: cast("bytes | None", house.bus.redis.hget(keys.PREVIEWS, "left")), "a preview")
    decoded = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert decoded is not None
    assert decoded.shape == (270, 480, 3)

    house.redis.kill()
    house.redis.start()
    back_ns = time.time_ns()
    eventually(lambda: house.pose(since_ns=back_ns), "poses after Redis came back")
    assert tracker.poll() is None
    assert camera.poll() is None
    assert house.extrinsics() == found, "durable"

    assert ended_within(camera, 2.0)
    assert ended_within(tracker, 2.0)

    # A restart uses what is stored at once: the first frame already has a pose.
    house.bus.redis.delete(keys.live(DETECTIONS.name))
    house.start("localization.camera", "left")
    first = eventually(lambda: house.bus.latest_all(DETECTIONS).get("left"), "detections")
    assert len(first.detections) == 1
    house.camera_state(lambda state: state.stamp_ns > first.stamp_ns + 2_000_000_000)
    assert house.extrinsics() == found, "checked and kept"


def test_frames_of_another_size_are_reported_and_not_used(house: House, picture: NDArray[np.uint8]) -> None:
    house.start("localization.camera", "left")
    small = house.show(np.ascontiguousarray(picture[::2, ::2]))
    error = "a frame is 480 x 270, the lab description says 960 x 540; it is not used"
    house.camera_state(lambda state: state.error == error and state.broken > 2)
    assert house.bus.latest_all(DETECTIONS) == {}
    small.close()
    house.show(picture)
    house.camera_state(lambda state: state.error is None and state.reprojection_px is not None)
    assert house.bus.latest_all(DETECTIONS) != {}


def test_an_unknown_camera_is_refused_with_the_known_ones(house: House) -> None:
    process = house.start("localization.camera", "middle")
    assert process.wait(WITHIN_S) == 1
    assert process.stderr is not None
    assert b"has no camera 'middle', it has left, right" in process.stderr.read()


@pytest.mark.parametrize(
    "arguments", [("localization.camera", "left"), ("localization.tracker",), ("localization.calibrator",)]
)
def test_a_lab_file_of_no_use_is_named_in_a_line_per_problem(house: House, arguments: tuple[str, ...]) -> None:
    file = Path(house.environment["LILLIPUT_LAB"])
    file.write_text(SMALL_LAB + "bogus: 1\nodd: 2\n")
    process = house.start(*arguments)
    _, said = process.communicate(timeout=WITHIN_S)
    assert process.returncode == 1
    lines = [line for line in said.decode().splitlines() if line.startswith(f"{file}:")]
    assert [line.rsplit(": ", 2)[1:] for line in lines] == [["bogus", "unknown key"], ["odd", "unknown key"]]
    assert "Traceback" not in said.decode()
