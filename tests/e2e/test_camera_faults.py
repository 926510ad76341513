"""Four cameras fail in four ways while vehicles are followed: one hangs in the middle of a picture, one sends garbage, one is
unplugged and plugged in again, one is bumped by 2 cm. The others never notice, the console says which and since when, and
all come back by themselves."""

import math
import re
import threading
import time
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pytest
import yaml

from lab.rendering import CameraRenderer
from lab.world import World
from launcher.redis_server import redis_url, socket_path
from protocol.bus import SyncBus
from protocol.channels import DETECTIONS
from protocol.lab import load_lab
from protocol.messages import FrameDetections
from tests.e2e.system import RunningSystem, lab_on_free_ports, running_system, wait_for
from tests.localization.mjpeg_camera import MjpegCamera, jpeg

RATE_HZ = 10
"""Of the light lab's cameras."""
LONGEST_GAP_S = 2.0
"""Between two frames of a camera that is well, on a machine that runs a dozen processes on two cores: what a camera that waits
for another one's faults, which last five seconds and more, would exceed."""
LATENCY_MARGIN_MS = 150.0
CLOCK = r"\d\d:\d\d:\d\d"


class Ear:
    """Hears every camera's detections, and remembers when they came."""

    def __init__(self, url: str) -> None:
        self._bus = SyncBus.connect(url)
        self._ended = threading.Event()
        self.heard: dict[str, list[tuple[float, FrameDetections]]] = {}
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        while not self._ended.wait(0.01):
            for camera, message in self._bus.latest_all(DETECTIONS).items():
                known = self.heard.setdefault(camera, [])
                if not known or known[-1][1].frame != message.frame:
                    known.append((time.monotonic(), message))

    def close(self) -> None:
        self._ended.set()
        self._thread.join(5)
        self._bus.close()

    def shifted_s(self, camera: str, since_s: float) -> float:
        """When the first frame came that shows a standing vehicle at least a centimetre from where it was before that time."""
        heard = list(self.heard[camera])
        before = {d.tag_id: (d.x, d.y) for d in [m for at, m in heard if at <= since_s][-1].detections}
        for at, message in heard:
            moved = (math.dist((d.x, d.y), before[d.tag_id]) for d in message.detections if d.tag_id in before)
            if at > since_s and any(way_m > 0.01 for way_m in moved):
                return at
        raise AssertionError(f"no frame of {camera} shows anything elsewhere")

    def gap_s(self, camera: str, since_s: float) -> float:
        """The longest silence of that camera since then."""
        times = [since_s, *(at for at, _ in list(self.heard[camera]) if at > since_s), time.monotonic()]
        return float(np.diff(times).max())

    def latency_ms(self, camera: str, since_s: float) -> float:
        """Frame to message, median since then."""
        return median((m.sent_ns - m.stamp_ns) * 1e-6 for at, m in list(self.heard[camera]) if at > since_s)

    def tags(self, camera: str, since_s: float) -> list[set[int]]:
        return [{d.tag_id for d in m.detections} for at, m in list(self.heard[camera]) if at > since_s]


def write_lab(folder: Path, address: str) -> Path:
    """The room of the reports at half the resolution; its first camera is a network camera."""
    path = lab_on_free_ports(folder, light=True)
    lab = yaml.safe_load(path.read_text())
    lab["cameras"][0]["source"] = address
    path.write_text(yaml.safe_dump(lab))
    return path


@pytest.fixture
def network_camera(tmp_path: Path) -> Iterator[MjpegCamera]:
    """Shows what cam0 sees of the room while all vehicles stand where the lab file has them."""
    lab = load_lab(write_lab(tmp_path, "http://127.0.0.1:1/"))
    camera = MjpegCamera(jpeg(CameraRenderer(lab, "cam0").render(World(lab).snapshot(), 1), 95), RATE_HZ)
    yield camera
    camera.close()


def camera(system: RunningSystem, name: str) -> dict[str, Any]:
    return {item["id"]: item for item in system.get("/cameras")}[name]


def is_well(system: RunningSystem, name: str) -> bool:
    state = camera(system, name)["state"]
    return bool(state and state["fresh"] and state["connected"] and state["error"] is None and state["reprojection_px"])


def complaint(system: RunningSystem, name: str) -> str | None:
    """What the console's health says of the camera."""
    return next((p["text"] for p in system.get("/health")["problems"] if p["source"] == name), None)


@contextmanager
def unnoticed(ear: Ear, others: list[str], expected: dict[str, set[int]]) -> Generator[None]:
    """While this lasts the other cameras send on, at their rate and delay, and see the same vehicles."""
    start_s = time.monotonic()
    before = {name: ear.latency_ms(name, start_s - 5.0) for name in others}
    yield
    for name in others:
        assert ear.gap_s(name, start_s) < LONGEST_GAP_S, name
        assert ear.latency_ms(name, start_s) < before[name] + LATENCY_MARGIN_MS, name
        seen = ear.tags(name, start_s)
        assert seen, name
        assert sum(expected[name] <= tags for tags in seen) >= 0.97 * len(seen), name


def says(system: RunningSystem, name: str, pattern: str, timeout_s: float) -> str:
    """Waits until the console says that of the camera, with the time since when."""

    def fitting() -> str | None:
        text = complaint(system, name)
        return text if text is not None and re.fullmatch(rf"{name}: {pattern}, since {CLOCK}", text) else None

    return wait_for(f"{name} is said to have: {pattern}", fitting, timeout_s)


def test_each_camera_fails_in_its_own_way_and_the_rest_never_notices(
    tmp_path: Path, network_camera: MjpegCamera
) -> None:
    path = write_lab(tmp_path, network_camera.url)
    with running_system(tmp_path, path) as system:
        system.wait_until_driving_is_possible()
        names = ["cam0", "cam1", "cam2", "cam3"]
        wait_for("all cameras are well", lambda: all(is_well(system, name) for name in names), 60)
        ear = Ear(redis_url(socket_path(system.state)))
        try:
            wait_for("frames of all", lambda: all(len(ear.heard.get(name, [])) > 4 * RATE_HZ for name in names), 30)
            expected = {name: set[int].union(*ear.tags(name, 0.0)[-10:]) for name in names}
            assert set[int].union(*expected.values()) == {14, 15, 16, 17}

            with unnoticed(ear, ["cam1", "cam2", "cam3"], expected):
                network_camera.mood = "hanging"
                says(system, "cam0", r"no frame for \d+\.\d s", 5)
                says(system, "cam0", rf"{re.escape(network_camera.url)} has sent nothing for 3 s", 15)
                network_camera.mood = "well"
                wait_for("cam0 is well again", lambda: is_well(system, "cam0"), 20)
                wait_for("cam0 has found its vehicles", lambda: expected["cam0"] <= ear.tags("cam0", 0.0)[-1], 20)

            with unnoticed(ear, ["cam0", "cam2", "cam3"], expected):
                suffer(system, "cam1", kind="resize")
                error = "a frame is 480 x 270, the lab description says 960 x 540; it is not used"
                says(system, "cam1", re.escape(error), 10)
                assert camera(system, "cam1")["state"]["broken"] > 0
                suffer(system, "cam1", kind="noise")
                says(
                    system,
                    "cam1",
                    re.escape("none of its floor tags is seen any more: is it covered, dark, or disturbed?"),
                    15,
                )
                recover(system, "cam1")

            with unnoticed(ear, ["cam0", "cam1", "cam3"], expected):
                suffer(system, "cam2", kind="unplug")
                says(system, "cam2", "the simulated lab gives no frames( yet)?", 10)
                recover(system, "cam2")

            with unnoticed(ear, ["cam0", "cam1", "cam2"], expected):
                bumped_s = time.monotonic()
                suffer(system, "cam3", kind="bump", shift_x_m=0.02)
                says(system, "cam3", "the camera moved.*", 20)
                said_s = time.monotonic()
                assert said_s - ear.shifted_s("cam3", bumped_s) < 3.0, "2 s, and a second until the console says so"
                wait_for("cam3 has found its new place", lambda: is_well(system, "cam3"), 30)
                wait_for("where it hangs", lambda: moved_m(system) == pytest.approx(0.02, abs=0.004), 20)
            kinds = [event["kind"] for event in system.get("/events?count=50")]
            assert kinds.count("fault_begun") == 4
        finally:
            ear.close()


def moved_m(system: RunningSystem) -> float:
    """How far cam3's calibration is from where the lab file hangs it."""
    return float(camera(system, "cam3")["extrinsics"]["translation"][0]) - 6.99


def suffer(system: RunningSystem, name: str, **fault: object) -> None:
    system.api.put(f"/sim/cameras/{name}/fault", json=fault).raise_for_status()


def recover(system: RunningSystem, name: str) -> None:
    system.api.delete(f"/sim/cameras/{name}/fault").raise_for_status()
    wait_for(f"{name} is well again", lambda: is_well(system, name), 20)
