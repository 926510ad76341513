"""`./lilliput calibrate`: the shell's way to the running calibration, and calibration from a recording."""

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import cv2
import pytest

from launcher.cli import main
from localization.calibrator import Calibrator
from localization.offline import read_calibration
from protocol import keys
from protocol.bus import Bus, SyncBus
from protocol.channels import CALIBRATION_RUNS, LAB_INSTANCE, SIGHTINGS
from protocol.clock import SystemClock
from protocol.codec import decode
from protocol.messages import Calibration, RunState
from protocol.messages.calibration import CURRENT
from tests.localization.sightings import LAB, message, sighting
from tests.localization.synthetic import MOUNTS, SMALL_LAB, floor_tags, render


class Cameras:
    """A calibrator at work in a thread, and cameras that answer it when they are asked."""

    def __init__(self, redis_url: str) -> None:
        self._url, self._ended = redis_url, threading.Event()
        self._threads = [threading.Thread(target=work) for work in (self._calibrate, self._answer)]
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        self._ended.set()
        for thread in self._threads:
            thread.join()

    def _calibrate(self) -> None:
        async def work() -> None:
            bus = Bus.connect(self._url)
            task = asyncio.create_task(Calibrator(LAB, bus, SystemClock()).run())
            await asyncio.to_thread(self._ended.wait)
            while not task.done():  # redis-py may lose a cancellation
                task.cancel()
                await asyncio.wait({task}, timeout=0.1)
            with suppress(asyncio.CancelledError):
                await task
            await bus.close()

        asyncio.run(work())

    def _answer(self) -> None:
        bus, clock = SyncBus.connect(self._url), SystemClock()
        answered = 0
        while not self._ended.wait(0.02):
            run = bus.latest_all(CALIBRATION_RUNS).get(LAB_INSTANCE)
            if run is not None and run.state is RunState.COLLECTING and run.id != answered:
                answered = run.id
                for camera in run.cameras:
                    now_ns = clock.now_ns()
                    bus.publish(SIGHTINGS, camera, message(sighting(camera, now_ns), now_ns, run.id))
        bus.close()


@pytest.fixture
def lab(tmp_path: Path, redis_url: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """The small lab's file; commands find its Redis."""
    (tmp_path / "lab.yaml").write_text(SMALL_LAB)
    monkeypatch.setenv("REDIS_URL", redis_url)
    return str(tmp_path / "lab.yaml")


@pytest.fixture
def cameras(redis_url: str) -> Iterator[Cameras]:
    made = Cameras(redis_url)
    yield made
    made.close()


def figures(capsys: pytest.CaptureFixture[str], *argv: str) -> dict[str, Any]:
    capsys.readouterr()
    assert main(["calibrate", *argv, "--json"]) == 0
    return json.loads(capsys.readouterr().out)["figures"]


def in_force(redis_url: str) -> Calibration | None:
    bus = SyncBus.connect(redis_url)
    try:
        raw = bus.redis.hget(keys.CALIBRATIONS, CURRENT)
        return None if raw is None else decode(Calibration, raw)  # type: ignore[arg-type]  # bytes
    finally:
        bus.close()


@pytest.mark.usefixtures("cameras")
def test_the_shell_calibrates_decides_and_undoes(
    lab: str, redis_url: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert figures(capsys, "status", "--lab", lab)["calibrated"] is False
    proposed = figures(capsys, "run", "--lab", lab, "--cameras", "left, right")
    assert 0 < proposed["left_reprojection_after_px"] < 0.3
    assert proposed["right_floor_tags"] == [2, 3, 4, 5]
    assert proposed["accepted"] is False
    assert figures(capsys, "status", "--lab", lab)["proposal"] == proposed["id"]
    assert figures(capsys, "accept", "--lab", lab)["by"] == "shell"
    first = in_force(redis_url)
    assert first is not None
    assert first.id == proposed["id"]

    again = figures(capsys, "run", "--lab", lab, "--accept")
    assert again["left_reprojection_before_px"] is None, "no camera has taken anything here"
    now = in_force(redis_url)
    assert now is not None
    assert now.id == again["id"]
    assert figures(capsys, "restore", "--lab", lab)["id"] == first.id

    figures(capsys, "run", "--lab", lab, "--cameras", "left")
    assert "discarded" in figures(capsys, "discard", "--lab", lab)
    file = tmp_path / "calibration.json"
    figures(capsys, "export", str(file), "--lab", lab)
    assert read_calibration(file, LAB) == in_force(redis_url)


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (["accept"], "no calibration is proposed; start one with `./lilliput calibrate run`"),
        (["restore"], "there is no previous calibration to restore"),
        (["run", "--cameras", "middle"], "there is no camera 'middle'; there are left, right"),
        (["export", "x.json"], "there is no calibration yet"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_line(
    lab: str, argv: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["calibrate", *argv, "--lab", lab]) != 0
    said = capsys.readouterr().err
    assert says in said
    assert said.count("\n") == 1


def test_a_recording_of_the_floor_gives_a_calibration(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording, out = tmp_path / "recording", tmp_path / "calibration.json"
    for camera in ("left", "right"):
        (recording / camera).mkdir(parents=True)
        for number in range(3):
            picture = render(LAB.camera(camera).model(), MOUNTS[camera], floor_tags(LAB), seed=number)
            cv2.imwrite(str(recording / camera / f"{1_700_000_000_000_000_000 + number * 66_000_000}.png"), picture)
    (recording / "lab.yaml").write_text(SMALL_LAB)
    found = figures(capsys, "extrinsics", str(recording), "--out", str(out))
    assert found["left_floor_tags"] == [0, 1, 2, 3]
    assert found["right_reprojection_px"] < 0.5
    calibration = read_calibration(out, LAB)
    for camera, mount in MOUNTS.items():
        assert calibration.cameras[camera].translation == pytest.approx(tuple(mount.translation), abs=0.006)


def test_a_recording_without_a_lab_file_says_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["calibrate", "extrinsics", str(tmp_path)]) == 2
    assert "say with --lab FILE which lab was recorded" in capsys.readouterr().err
