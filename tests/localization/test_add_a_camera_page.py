"""docs/add-a-camera.md is true: its YAML adds a camera that runs and calibrates itself, and what its table has the console say
is what the program says."""

import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from os import environ
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import yaml

from lab.rendering import CameraRenderer
from lab.world import World
from localization.calibration import SelfCalibration
from localization.sources import CaptureError, LiveSource, Patience, kind_of, open_source
from localization.sources.device import DeviceCapture
from localization.tags import KnownTags
from protocol.bus import SyncBus
from protocol.channels import CAMERA_STATES
from protocol.clock import SystemClock
from protocol.lab import CameraSpec, Lab, load_lab, parse_lab
from protocol.messages import CameraState
from tests.localization.mjpeg_camera import MjpegCamera, jpeg
from tests.localization.synthetic import mount, small_lab
from tests.localization.test_camera_state import Camera as StatedCamera
from tests.localization.test_self_calibration import MODEL, TRUTH, observations, watch

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/add-a-camera.md").read_text()
MOUNT = {"position": [10.0, 2.13, 3.0], "yaw": 1.5708, "tilt_x": 0.01, "tilt_y": -0.008}
"""Where the page's camera truly hangs, over the page's floor tags."""
WITHIN_S = 30.0
IMPATIENT = Patience(stall_s=0.05, abandon_s=0.3, first_retry_s=0.01, last_retry_s=0.05)


def blocks() -> list[Any]:
    """The page's YAML."""
    return [yaml.safe_load(text) for text in re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)]


def table(header: str) -> list[list[str]]:
    """The rows of the page's table that begins so."""
    rows = PAGE[PAGE.index(header) :].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]


def described(source: str) -> str:
    """The room of the reports with the page's camera and floor tags added to it."""
    lab = yaml.safe_load((ROOT / "labs/gulliver.yaml").read_text())
    (camera,), floor = blocks()
    lab["cameras"].append({**camera, "source": source})
    assert lab["floor_tags"]["size_m"] == floor["floor_tags"]["size_m"]
    lab["floor_tags"]["poses"] |= floor["floor_tags"]["poses"]
    lab["simulation"]["mounts"]["cam4"] = MOUNT
    return yaml.safe_dump(lab)


def eventually(probe: Callable[[], Any], what: str) -> Any:
    deadline = time.monotonic() + WITHIN_S
    while not (value := probe()):
        assert time.monotonic() < deadline, f"not within {WITHIN_S} s: {what}"
        time.sleep(0.01)
    return value


@contextmanager
def serving(picture: bytes, rate_hz: float = 20.0) -> Generator[MjpegCamera]:
    camera = MjpegCamera(picture, rate_hz)
    try:
        yield camera
    finally:
        camera.close()


def test_the_yaml_of_the_page_adds_a_camera_that_calibrates_itself(tmp_path: Path, redis_url: str) -> None:
    lab = parse_lab(described("http://127.0.0.1:1/video"), "lab.yaml")
    picture = jpeg(CameraRenderer(lab, "cam4").render(World(lab).snapshot(), 1))
    with serving(picture, 10.0) as camera:
        path = tmp_path / "lab.yaml"
        path.write_text(described(camera.url))
        assert load_lab(path).camera("cam4").rate_hz == 60
        environment = environ | {
            "LILLIPUT_LAB": str(path),
            "LILLIPUT_STATE": str(tmp_path / "state"),
            "REDIS_URL": redis_url,
            "PYTHONPATH": str(ROOT),
        }
        bus = SyncBus.connect(redis_url)
        process = subprocess.Popen([sys.executable, "-m", "localization.camera", "cam4"], env=environment)
        try:

            def calibrated() -> CameraState | None:
                state = bus.latest_all(CAMERA_STATES).get("cam4")
                return state if state is not None and state.reprojection_px is not None else None

            state = cast("CameraState", eventually(calibrated, "the camera calibrates itself"))
            assert (state.connected, state.error, state.floor_tags_seen) == (True, None, (10, 11))
            assert state.reprojection_px is not None
            assert state.reprojection_px < 0.3, "good, says the page"
        finally:
            process.terminate()
            process.wait(10)
            bus.close()


@pytest.mark.parametrize("row", table("| `source` | is read |"), ids=lambda row: row[0])
def test_every_kind_of_source_of_the_page_is_told_apart(row: list[str]) -> None:
    kinds = {"V4L2": "V4L2 device", "MJPEG over HTTP": "HTTP stream", "FFmpeg": "RTSP or other stream"}
    kinds |= {"a folder": "video file or folder of pictures", "the simulated lab": "simulated camera"}
    expected = next(kind for words, kind in kinds.items() if words in row[1])
    for source in re.findall(r"`([^`]+)`", row[0]):
        assert kind_of(source).name == expected


# What the program says, each sentence brought about.


def spec(source: str | int, width: int = 1920, height: int = 1080) -> CameraSpec:
    return (
        small_lab()
        .camera("left")
        .model_copy(update={"source": source, "width": width, "height": height, "rate_hz": 500})
    )


def said_by(source: LiveSource, fits: str) -> str:
    try:
        return cast("str", eventually(lambda: _fitting(source, fits), fits))
    finally:
        source.close()


def _fitting(source: LiveSource, fits: str) -> str | None:
    source.newest(0.0)
    error = source.state.error
    return error if error is not None and fits in error else None


def network_sentences() -> Iterator[str]:
    small = jpeg(np.full((720, 1280), 90, np.uint8))
    with serving(small) as camera:
        yield said_by(open_source(spec(camera.url), Path("/nowhere"), SystemClock(), IMPATIENT), "it is not used")
        camera.mood = "html"
        yield said_by(open_source(spec(camera.url), Path("/nowhere"), SystemClock(), IMPATIENT), "answers with")
        camera.mood = "absent"
        yield said_by(open_source(spec(camera.url), Path("/nowhere"), SystemClock(), IMPATIENT), "cannot be opened")
        camera.mood = "well"
        patient = Patience(stall_s=0.3, abandon_s=10.0)
        source = open_source(spec(camera.url, 1280, 720), Path("/nowhere"), SystemClock(), patient)
        eventually(lambda: source.newest(0.1), "a frame")
        camera.mood = "hanging"
        yield cast("str", eventually(lambda: _fitting(source, "no frame for"), "a stall"))
        yield said_by(source, "has sent nothing")


class HangingCapture:
    """A driver that does not come back from its read call."""

    def __init__(self, released: threading.Event) -> None:
        self._released = released

    def read(self) -> None:
        self._released.wait(WITHIN_S)

    def close(self) -> None:
        pass


def device_sentences(folder: Path) -> Iterator[str]:
    node = folder / "video2"
    for present in (False, True):
        if present:
            node.write_bytes(b"no camera")
        with pytest.raises(CaptureError) as caught:
            DeviceCapture(str(node), spec(str(node)), SystemClock())
        yield str(caught.value)
    released = threading.Event()
    try:
        yield said_by(LiveSource(spec(0), lambda: HangingCapture(released), SystemClock(), IMPATIENT), "hangs")
    finally:
        released.set()


def calibration_sentences() -> Iterator[str]:
    lab, known = small_lab(), KnownTags.of(small_lab())

    def problem_of(calibration: SelfCalibration) -> str:
        assert calibration.problem is not None
        return calibration.problem

    blind = SelfCalibration("left", MODEL, known)
    for k in range(10):
        blind.observe([], k)
    yield problem_of(blind)
    places = {**lab.floor_tags.poses, 0: (-0.04, 0.0, 0.0), 1: (0.0, 1.04, 1.5708)}
    misplaced = Lab.model_validate({**lab.model_dump(), "floor_tags": {**lab.floor_tags.model_dump(), "poses": places}})
    wrong = SelfCalibration("left", MODEL, KnownTags.of(misplaced))
    watch(TRUTH, wrong, 10)
    yield problem_of(wrong)
    shaking = SelfCalibration("left", MODEL, known)
    for k in range(10):
        shaking.observe(observations(mount(0.75 + 0.02 * (k % 2), 0.5, 2.2), k), k)
    yield problem_of(shaking)
    moved = SelfCalibration("left", MODEL, known)
    watch(TRUTH, moved, 10)
    watch(mount(0.77, 0.5, 2.2, 0.02, 0.015, -0.01), moved, 3)
    yield problem_of(moved)


def state_sentences() -> Iterator[str]:
    camera = StatedCamera()
    camera.pipeline.floor_tags_seen = (1,)
    camera.at(1.0)
    camera.pipeline.floor_tags_seen = ()
    yield cast("str", camera.at(5.0).error)


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Every sentence of the table as the program says it, in other numbers and names."""
    folder = tmp_path_factory.mktemp("dev")
    sources = (network_sentences(), device_sentences(folder), calibration_sentences(), state_sentences())
    return [sentence for some in sources for sentence in some]


EXAMPLES = (
    (r"\(there are .*\)", r"\((there are|this machine has no) .*\)"),
    (r"http://10\.0\.0\.7/video", r"http://[\w.:]+/video"),
    (r"/dev/video2", r"\S*/video2"),
    (r"\d+(\.\d+)?", r"\d+(\.\d+)?"),
)
"""What stands in the page for something else, and what that may be."""


def pattern(sentence: str) -> str:
    """The sentence as a regular expression, its examples (numbers, addresses, devices) replaced by what they stand for."""
    parts: list[str] = []
    at = 0
    for found in re.finditer("|".join(f"(?:{example})" for example, _ in EXAMPLES), sentence):
        general = next(general for example, general in EXAMPLES if re.fullmatch(example, found[0]))
        parts += [re.escape(sentence[at : found.start()]), general]
        at = found.end()
    return "".join(parts) + re.escape(sentence[at:])


@pytest.mark.parametrize("sentence", [row[0] for row in table("| the page says |")])
def test_the_page_quotes_what_the_program_says(sentence: str, said: list[str]) -> None:
    assert any(re.fullmatch(pattern(sentence), other) for other in said), said
