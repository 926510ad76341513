"""`./lilliput record`: what is rendered is the lab's own, what runs is taken as it comes."""

import threading
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from launcher.cli import main
from launcher.errors import LauncherError
from launcher.paths import DEFAULT_LAB
from launcher.recorder.folder import RecordingFolder
from launcher.recorder.live import record_live
from localization.offline import open_recording
from protocol.clock import SystemClock
from protocol.frames import FrameWriter
from protocol.lab import load_lab, parse_lab
from protocol.settings import frame_ring
from tests.full_disk import files_no_longer_than

LAB = """
name: tiny
areas: [{id: room, outline: [[0, 0], [4, 0], [4, 4], [0, 4]]}]
cameras:
  - &camera {id: a, area: room, source: sim, width: 64, height: 48, rate_hz: 50,
             intrinsics: {fx: 50, fy: 50, cx: 31.5, cy: 23.5}}
  - {<<: *camera, id: b}
floor_tags: {size_m: 0.16, poses: {0: [0, 0, 0]}}
simulation: {mounts: {a: {position: [1, 1, 3]}, b: {position: [3, 1, 3]}}}
"""


class UntilEnough(SystemClock):
    """Time jumps past the end of the recording once both cameras gave some frames."""

    def __init__(self, folder: RecordingFolder, enough: int) -> None:
        self._folder, self._enough = folder, enough

    def monotonic_s(self) -> float:
        has_enough = all(self._folder.frames[camera] >= self._enough for camera in ("a", "b"))
        return super().monotonic_s() + (1e6 if has_enough else 0.0)


@pytest.fixture
def running(tmp_path: Path) -> Iterator[Path]:
    """The state folder of a system whose simulated cameras give ever lighter frames, stamped by number."""
    state = tmp_path / "state"
    writers = [FrameWriter(frame_ring(state, camera), 64, 48) for camera in ("a", "b")]
    ended = threading.Event()

    def feed() -> None:
        number = 0
        while not ended.wait(0.005):
            number += 1
            for writer in writers:
                writer.write(np.full((48, 64), number % 200, np.uint8), number)

    feeder = threading.Thread(target=feed)
    feeder.start()
    yield state
    ended.set()
    feeder.join()
    for writer in writers:
        writer.close()


def test_running_cameras_are_recorded_with_their_own_capture_times(running: Path, tmp_path: Path) -> None:
    lab = parse_lab(LAB)
    folder = RecordingFolder(tmp_path / "recording", ["a", "b"], "png", 90)
    counts = record_live(lab.cameras, running, folder, UntilEnough(folder, 4), seconds=1000.0)
    assert {camera: count.broken for camera, count in counts.items()} == {"a": 0, "b": 0}
    recording = open_recording(folder.path, lab)
    for camera in recording.cameras:
        assert len(camera.stamps_ns) == folder.frames[camera.spec.id] >= 4
        for stamp_ns in camera.stamps_ns:
            image = cv2.imread(str(folder.path / camera.spec.id / f"{stamp_ns}.png"), cv2.IMREAD_GRAYSCALE)
            assert image is not None and (image == stamp_ns % 200).all()


def test_a_disk_that_is_full_ends_the_recording_at_once(running: Path, tmp_path: Path) -> None:
    """Though the other camera, which is not plugged in, never writes and so never fails."""
    lab = parse_lab(LAB.replace("id: b}", "id: b, source: /dev/video97}"))
    folder = RecordingFolder(tmp_path / "recording", ["a", "b"], "png", 90)
    with (
        files_no_longer_than(10),
        pytest.raises(LauncherError, match=r"recording/a/\d+\.png cannot be written: File too"),
    ):
        record_live(lab.cameras, running, folder, SystemClock(), seconds=3600.0)


def test_an_interrupted_recording_keeps_what_it_has(running: Path, tmp_path: Path) -> None:
    class Interrupted(SystemClock):
        def wait(self, seconds: float) -> None:
            super().wait(seconds)
            if threading.current_thread() is threading.main_thread() and folder.frames["a"] >= 3:
                raise KeyboardInterrupt

    folder = RecordingFolder(tmp_path / "recording", ["a", "b"], "png", 90)
    with pytest.raises(KeyboardInterrupt):
        record_live(parse_lab(LAB).cameras, running, folder, Interrupted(), seconds=3600.0)
    written = len(list((folder.path / "a").iterdir()))
    assert written == folder.frames["a"] >= 3


def test_a_recording_of_which_nothing_could_be_written_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    with files_no_longer_than(100):
        assert main(["record", str(out), "--seconds", "0.1"]) == 1
    message = capsys.readouterr().err
    assert message.startswith(f"lilliput: {out}/lab.yaml cannot be written: File too large")
    assert message.count("\n") == 1
    assert not out.exists()


def test_nothing_running_is_told_and_leaves_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    command = ["record", str(out), "--live", "--seconds", "0.05", "--state", str(tmp_path / "state")]
    assert main([*command, "--lab", str(DEFAULT_LAB)]) == 1
    assert "lilliput: no camera gave a frame; is the system running" in capsys.readouterr().err
    assert not out.exists()


def test_what_is_rendered_can_be_repeated_and_carries_its_lab(tmp_path: Path) -> None:
    for name in ("first", "second"):
        assert (
            main(
                [
                    "record",
                    str(tmp_path / name),
                    "--seconds",
                    "0.2",
                    "--cameras",
                    "cam1",
                    "--seed",
                    "4",
                    "--rate-hz",
                    "10",
                ]
            )
            == 0
        )
    files = sorted(path.relative_to(tmp_path / "first") for path in (tmp_path / "first").rglob("*") if path.is_file())
    assert [str(file) for file in files if file.parts[0] != "cam1"] == ["lab.yaml", "truth.csv"]
    assert len([file for file in files if file.parts[0] == "cam1"]) == 2
    for file in files:
        assert (tmp_path / "first" / file).read_bytes() == (tmp_path / "second" / file).read_bytes()
    assert load_lab(tmp_path / "first/lab.yaml") == load_lab(DEFAULT_LAB)


def test_a_lab_file_without_simulation_describes_the_same_room(tmp_path: Path) -> None:
    lab = load_lab(DEFAULT_LAB)
    folder = RecordingFolder(tmp_path / "recording", ["cam0"], "jpg", 90)
    folder.write_lab_without_simulation(lab)
    told = load_lab(folder.path / "lab.yaml", recorded=True)
    assert told.model_copy(update={"simulation": lab.simulation}) == lab
