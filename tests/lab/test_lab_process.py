"""`python -m lab` as a process: it ends when told, survives being killed, and says what is wrong with its settings."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import pytest
import yaml

from protocol.frames import FrameReader
from protocol.lab import load_lab
from protocol.settings import Settings, frame_ring
from tests.lab.laboratory import robot_computer, settings_for, wait_until, write_lab

ROOT = Path(__file__).parents[2]
WIFIBOT = "wifibot-14"


def environment(settings: Settings) -> dict[str, str]:
    return os.environ | {
        "PYTHONPATH": str(ROOT),
        "LILLIPUT_LAB": str(settings.lab),
        "LILLIPUT_STATE": str(settings.state),
        "REDIS_URL": settings.redis_url,
    }


@contextmanager
def lab_process(settings: Settings) -> Generator[subprocess.Popen[str]]:
    """Running when entered: its first camera has a ring."""
    ring = frame_ring(settings.state, "cam0")
    before = ring.stat().st_ino if ring.exists() else None
    process = subprocess.Popen(
        [sys.executable, "-m", "lab"], env=environment(settings), stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    try:
        wait_until(lambda: ring.exists() and ring.stat().st_ino != before, "the first camera")
        yield process
    finally:
        process.kill()
        process.wait()
        process.stderr.close()


def test_killed_it_leaves_vehicles_where_they_stood_and_ends_when_told(tmp_path: Path, redis_url: str) -> None:
    settings = settings_for(write_lab(tmp_path), redis_url)
    ring = frame_ring(settings.state, "cam0")
    with robot_computer(WIFIBOT, load_lab(settings.lab).ports.lab_udp) as computer:

        def driven(linear_mps: float, way_m: float) -> bool:
            computer.drive(linear_mps)
            odometry = computer.receive()
            return bool(odometry) and odometry[-1].x >= way_m

        with lab_process(settings) as first:
            wait_until(lambda: driven(0.6, 0.3), "it drives")
            wait_until(lambda: driven(0.0, 0.3) and computer.odometry[-1].linear_mps == 0.0, "it stops")
            stood_s = time.monotonic()
            wait_until(lambda: time.monotonic() > stood_s + 0.7, "its pose is saved")
            with FrameReader(ring) as reader:
                first.kill()
                first.wait()
                session = computer.odometry[-1].session
                with lab_process(settings) as second:
                    assert reader.replaced()
                    computer.odometry.clear()
                    wait_until(lambda: driven(0.0, 0.0) and computer.odometry[-1].session != session, "a new session")
                    assert computer.odometry[-1].x == 0.0
                    with FrameReader(ring) as again:
                        wait_until(again.newest, "a frame")
                    second.send_signal(signal.SIGTERM)
                    assert second.wait(5) == 0
    assert not ring.exists()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("bogus: 1\n", "bogus"),
        ("", "nothing to simulate"),
    ],
)
def test_a_lab_file_of_no_use_is_named(tmp_path: Path, change: str, said: str) -> None:
    file = write_lab(tmp_path)
    text = file.read_text()
    if not change:
        text = text.replace("source: sim", "source: 0").replace("driver: sim", "driver: http")
        lab = yaml.safe_load(text)
        del lab["simulation"]["tours"]  # nothing is simulated, so there is nobody to drive one
        text = yaml.safe_dump(lab)
    file.write_text(text + change)
    settings = settings_for(file, "unix:///nowhere.sock")
    ended = subprocess.run(
        [sys.executable, "-m", "lab"],
        env=environment(settings),
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert ended.returncode == 1
    assert said in ended.stderr
    assert "Traceback" not in ended.stderr
