"""The timing log of a process: capped, safe against crashes and disks, never in a frame's way."""

import logging
import os
import threading
from collections.abc import Sequence
from pathlib import Path

import msgspec
import pytest

from localization.timings import SegmentWriter, TimingLog, open_timing_log, prune
from localization.timings.writer import Timing
from protocol.clock import SimulatedClock
from protocol.settings import Settings
from protocol.timings import Header, list_runs, read_run, read_segment, timings_folder
from tests.full_disk import files_no_longer_than

HEADER = Header(
    run="r",
    run_start_ns=1,
    start_ns=1,
    process="tracker",
    kind="tracker",
    lab="small",
    machine="m",
    version="0",
    stages=("track", "send"),
)
NEEDED = {"LILLIPUT_LAB": "lab.yaml", "REDIS_URL": "unix:///nowhere"}


def writer(folder: Path, cap_bytes: int = 100_000, clock: SimulatedClock | None = None) -> SegmentWriter:
    return SegmentWriter(folder, HEADER, cap_bytes, (clock or SimulatedClock()).now_ns)


def timings(first: int, count: int, **stages_ms: float) -> list[Timing]:
    return [Timing(stamp, stages_ms or {"track": 1.0, "send": 2.0}) for stamp in range(first, first + count)]


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    kept = writer(tmp_path)
    kept.write(timings(0, 3))
    kept.write(timings(3, 2, track=5.0))
    (process,) = read_run(tmp_path).processes
    assert process.stamps_ns.tolist() == [0, 1, 2, 3, 4]
    assert process.ms[0].tolist() == [1.0, 2.0]
    assert str(process.ms[4].tolist()) == "[5.0, nan]"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_stage_that_is_new_begins_another_segment(tmp_path: Path) -> None:
    kept = writer(tmp_path)
    kept.write(timings(0, 1))
    kept.write(timings(1, 1, track=1.0, predict=0.5))
    kept.write(timings(2, 1))
    headers = [read_segment(path).header for path in sorted(tmp_path.iterdir())]
    assert [header.stages for header in headers] == [("track", "send"), ("track", "send", "predict")]
    assert read_run(tmp_path).values("tracker", "predict")[1].tolist() == [0.5]


def test_the_newest_are_kept_within_the_cap(tmp_path: Path) -> None:
    kept = writer(tmp_path, cap_bytes=40_000)
    for first in range(0, 10_000, 60):
        kept.write(timings(first, 60))
        assert sum(path.stat().st_size for path in tmp_path.iterdir()) <= 40_000
    (process,) = read_run(tmp_path).processes
    newest = process.stamps_ns
    assert newest[-1] == 10_019
    assert newest.size > 0.7 * 40_000 / 16
    assert newest.tolist() == list(range(newest[0], 10_020)), "no gap"


def test_a_process_that_begins_again_goes_on_behind_what_is_there(tmp_path: Path) -> None:
    writer(tmp_path).write(timings(0, 1))
    writer(tmp_path).write(timings(1, 1))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tracker.000001.timings", "tracker.000002.timings"]
    for first in range(2, 300):
        writer(tmp_path).write(timings(first, 1))
    assert len(list(tmp_path.iterdir())) <= 100


def test_old_runs_are_removed_and_the_present_one_never(tmp_path: Path) -> None:
    for age, name in enumerate(("newest", "middle", "oldest")):
        writer(tmp_path / name).write(timings(0, 100))
        for path in (tmp_path / name).iterdir():
            os.utime(path, (1000 - age, 1000 - age))
    size = sum(path.stat().st_size for path in (tmp_path / "newest").iterdir())
    prune(tmp_path, keep="oldest", most_runs=2, most_bytes=10**9)
    assert len(list(tmp_path.iterdir())) == 3
    prune(tmp_path, keep="newest", most_runs=2, most_bytes=10**9)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["middle", "newest"]
    prune(tmp_path, keep="other", most_runs=9, most_bytes=round(1.5 * size))
    assert [path.name for path in tmp_path.iterdir()] == ["newest"]
    prune(tmp_path / "absent", keep="x", most_runs=1, most_bytes=1)


class StuckWriter(SegmentWriter):
    """A disk that does not answer."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, HEADER, 10**8, SimulatedClock().now_ns)
        self.reached, self.go_on = threading.Event(), threading.Event()

    def write(self, timings: Sequence[Timing]) -> None:
        self.reached.set()
        self.go_on.wait(20)
        super().write(timings)


def test_frames_do_not_wait_for_the_disk(tmp_path: Path) -> None:
    disk = StuckWriter(tmp_path)
    with TimingLog(disk) as log:
        log.add(1, {"track": 1.0})
        assert disk.reached.wait(10)
        for stamp in range(2, 70_000):  # more than it remembers, while the writing thread is stuck
            log.add(stamp, {"track": 1.0})
        disk.go_on.set()
    stamps = read_run(tmp_path).processes[0].stamps_ns
    assert stamps.tolist() == list(range(1, 60_002))


def test_a_disk_that_refuses_is_told_once_and_used_again(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    folder = tmp_path / "run"
    folder.write_text("a file where the folder should be")
    log = TimingLog(writer(folder))
    for stamp in range(3):
        log.add(stamp, {"track": 1.0})
        log.write()
    assert caplog.text.count("stage timings are not kept") == 1
    folder.unlink()
    log.add(3, {"track": 1.0})
    log.write()
    assert read_run(folder).processes[0].stamps_ns.tolist() == [3]


def test_a_full_disk_costs_what_it_cannot_take_and_nothing_older(tmp_path: Path) -> None:
    log = writer(tmp_path)
    log.write(timings(1, 1))
    (kept,) = tmp_path.iterdir()
    with files_no_longer_than(kept.stat().st_size + 10):
        for stamp in range(2, 200):
            with pytest.raises(OSError, match="too large"):
                log.write(timings(stamp, 1))
    assert list(tmp_path.iterdir()) == [kept]
    log.write(timings(200, 1))
    assert read_run(tmp_path).processes[0].stamps_ns.tolist() == [1, 200]
    with files_no_longer_than(100):  # not even a header
        again = writer(tmp_path)
        for stamp in range(201, 400):
            with pytest.raises(OSError, match="too large"):
                again.write(timings(stamp, 1))
    assert list(tmp_path.iterdir()) == [kept], "no empty file is left, and none was pushed out by one"


def test_a_process_keeps_its_timings_under_its_run(tmp_path: Path) -> None:
    clock = SimulatedClock()
    settings = Settings.from_environment(NEEDED | {"LILLIPUT_STATE": str(tmp_path), "LILLIPUT_RUN": "test-1"})
    with open_timing_log(settings, clock, "small", "camera", ("wait", "total"), "left", {"rate_hz": 15.0}) as log:
        log.add(clock.now_ns(), {"wait": 1.0, "total": 2.0})
    (summary,) = list_runs(timings_folder(tmp_path))
    assert (summary.name, summary.processes) == ("test-1", ("camera-left",))
    assert (summary.header.lab, summary.header.settings) == ("small", {"rate_hz": 15.0})
    assert summary.header.stages == ("wait", "total")
    assert msgspec.json.encode(summary.header.machine) != b'""'


def test_an_allowance_of_zero_keeps_nothing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    settings = Settings.from_environment(NEEDED | {"LILLIPUT_STATE": str(tmp_path), "LILLIPUT_TIMINGS_MB": "0"})
    with open_timing_log(settings, SimulatedClock(), "small", "tracker", ()) as log:
        log.add(1, {"track": 1.0})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "value"), [("LILLIPUT_RUN", "../up"), ("LILLIPUT_TIMINGS_MB", "much"), ("LILLIPUT_TIMINGS_MB", "-1")]
)
def test_settings_that_cannot_be_are_refused_by_name(name: str, value: str) -> None:
    with pytest.raises(SystemExit, match=name):
        Settings.from_environment(NEEDED | {name: value})
