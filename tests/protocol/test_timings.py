"""Files of stage timings read back, and the statistics against numpy's and matplotlib's."""

import os
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from matplotlib.cbook import boxplot_stats

from protocol.errors import DecodeError
from protocol.timings import (
    Header,
    box,
    change_percent,
    downsample,
    encode_header,
    list_runs,
    outliers,
    read_files,
    read_run,
    read_segment,
    record_struct,
    run_name,
    segment_name,
)

START_NS = 1_763_972_505_000_000_000
HEADER = Header(
    run="20251124T082145Z",
    run_start_ns=START_NS,
    start_ns=START_NS,
    process="camera-cam0",
    kind="camera",
    lab="gulliver",
    machine="nuc",
    version="0.1.0",
    stages=("wait", "full"),
    settings={"rate_hz": 60.0},
)
values = arrays(np.float64, st.integers(1, 80), elements=st.floats(0, 1e4, width=32) | st.just(float("nan")))


def segment(folder: Path, number: int = 1, rows: int = 3, header: Header = HEADER) -> Path:
    """A segment whose row i is stamped i seconds after its start and has i, i + 1, ... ms."""
    folder.mkdir(parents=True, exist_ok=True)
    pack = record_struct(len(header.stages)).pack
    path = folder / segment_name(header.process, number)
    records = (
        pack(header.start_ns + row * 10**9, *(float(row + column) for column in range(len(header.stages))))
        for row in range(rows)
    )
    path.write_bytes(encode_header(header) + b"".join(records))
    return path


def later(seconds: int, **changes: object) -> Header:
    return msgspec.structs.replace(HEADER, start_ns=START_NS + seconds * 10**9, **changes)


def test_a_segment_describes_itself(tmp_path: Path) -> None:
    read = read_segment(segment(tmp_path))
    assert read.header == HEADER
    assert read.stamps_ns.tolist() == [START_NS, START_NS + 10**9, START_NS + 2 * 10**9]
    assert read.ms.tolist() == [[0, 1], [1, 2], [2, 3]]


@pytest.mark.parametrize("cut", [1, 7, 15])
def test_an_unfinished_record_is_ignored(tmp_path: Path, cut: int) -> None:
    path = segment(tmp_path)
    os.truncate(path, path.stat().st_size - cut)
    assert read_segment(path).ms.tolist() == [[0, 1], [1, 2]]


@pytest.mark.parametrize(
    ("content", "named"),
    [
        (b"", "0 bytes are no timing log"),
        (b"\x89PNG\r\n\x1a\n" + bytes(20), r"begins with b'.x89PNG"),
        (encode_header(HEADER)[:40], "its header of .* bytes is not whole"),
        (b"LPTIMES1\x02\0\0\0{}", "damaged header: .*missing required field"),
        (b"LPTIMES1\xff\xff\xff\xff" + bytes(50), "is not whole"),
    ],
)
def test_what_is_no_timing_log_is_named_with_its_file(tmp_path: Path, content: bytes, named: str) -> None:
    path = tmp_path / "odd.timings"
    path.write_bytes(content)
    with pytest.raises(DecodeError, match=rf"odd\.timings: .*{named}"):
        read_segment(path)


@given(st.binary(max_size=300), st.booleans())
def test_garbage_raises_nothing_but_decode_error(
    tmp_path_factory: pytest.TempPathFactory, data: bytes, cut: bool
) -> None:
    path = tmp_path_factory.getbasetemp() / "garbage.timings"
    whole = encode_header(HEADER) + data
    path.write_bytes(whole[: len(data)] if cut else whole)
    try:
        read = read_segment(path)
    except DecodeError:
        return
    assert read.ms.shape == (len(data) // 16, 2)


def test_a_run_joins_segments_and_processes(tmp_path: Path) -> None:
    folder = tmp_path / HEADER.run
    segment(folder, 1)
    segment(folder, 2, header=later(3, stages=("full", "wait", "send")))
    segment(folder, 1, header=later(0, process="camera-cam1"))
    segment(folder, 1, rows=2, header=later(0, process="tracker", kind="tracker", stages=("track",)))
    (folder / "camera-cam1.000002.timings").write_bytes(b"cut by a crash")
    run = read_run(folder)
    assert run.kinds == ("camera", "tracker")
    assert run.stages("camera") == ("wait", "full", "send")
    first = run.processes[0]
    assert (first.process, first.ms.shape) == ("camera-cam0", (6, 3))
    assert first.ms[3].tolist() == [1, 0, 2]  # columns by name, whatever their order in the file
    assert np.isnan(first.ms[0, 2])
    stamps, sent = run.values("camera", "send")
    assert (stamps[0], sent.tolist()) == (START_NS + 3 * 10**9, [2, 3, 4])
    assert run.values("camera", "wait")[1].size == 9
    assert run.values("camera", "unknown")[1].size == 0
    recent = read_run(folder, last_s=1.5)
    assert recent.values("camera", "wait")[1].tolist() == [2, 3]


def test_a_folder_without_logs_says_so(tmp_path: Path) -> None:
    with pytest.raises(DecodeError, match=f"{tmp_path}: no timing log in it"):
        read_run(tmp_path)
    (tmp_path / "a.000001.timings").write_bytes(b"x")
    with pytest.raises(DecodeError, match=r"a\.000001\.timings: 1 bytes are no timing log"):
        read_run(tmp_path)
    with pytest.raises(DecodeError, match="1 bytes"):
        read_files([tmp_path / "a.000001.timings"])


def test_runs_are_listed_oldest_first(tmp_path: Path) -> None:
    for number, name in ((3, "zebra"), (2, "a-later"), (1, "b")):
        segment(tmp_path / name, header=later(number, run=name, run_start_ns=START_NS + number))
    (tmp_path / "empty").mkdir()
    (tmp_path / "not a run").mkdir()
    runs = list_runs(tmp_path)
    assert [run.name for run in runs] == ["b", "a-later", "zebra"]
    assert runs[0].processes == ("camera-cam0",)
    assert runs[0].size_bytes == sum(path.stat().st_size for path in (tmp_path / "b").iterdir())
    assert list_runs(tmp_path / "absent") == []


def test_runs_are_named_by_their_start_in_utc() -> None:
    assert run_name(START_NS) == "20251124T082145Z"


@given(values)
def test_the_box_is_matplotlibs_and_the_quartiles_numpys(given_values: np.ndarray) -> None:
    found = box(given_values)
    known = given_values[~np.isnan(given_values)]
    if known.size == 0:
        assert found is None
        return
    assert found is not None
    (expected,) = boxplot_stats(known)
    assert (found.q1, found.median, found.q3) == pytest.approx(tuple(np.quantile(known, [0.25, 0.5, 0.75])))
    assert (found.low, found.high) == pytest.approx((expected["whislo"], expected["whishi"]))
    assert found.outliers == len(expected["fliers"])
    assert sorted(outliers(given_values, found, 100)) == pytest.approx(sorted(expected["fliers"]))
    assert found.count == known.size
    assert found.p99 == pytest.approx(np.quantile(known, 0.99))


def test_a_box_by_hand() -> None:
    found = box(np.array([1.0, 2.0, 3.0, 4.0, 100.0]))
    assert found is not None
    assert (found.low, found.q1, found.median, found.q3, found.high, found.outliers) == (1, 2, 3, 4, 4, 1)
    assert found.mean == 22.0


def test_many_outliers_are_thinned_with_their_extremes_kept() -> None:
    given_values = np.concatenate([np.full(1000, 5.0), np.arange(10.0, 110.0)])
    found = box(given_values)
    assert found is not None
    assert found.outliers == 100
    few = outliers(given_values, found, 10)
    assert (few.size, few[0], few[-1]) == (10, 10.0, 109.0)


def test_a_time_graph_keeps_peaks() -> None:
    stamps = START_NS + np.arange(1000, dtype=np.int64) * 10**8
    given_values = np.ones(1000, np.float32)
    given_values[555], given_values[3] = 80.0, np.nan
    shuffled = np.random.default_rng(1).permutation(1000)
    series = downsample(stamps[shuffled], given_values[shuffled], START_NS, 50)
    assert series.seconds.size == 50
    assert series.seconds[0] == pytest.approx(1.0, abs=0.05)
    assert series.seconds[-1] == pytest.approx(98.9, abs=0.05)
    assert series.median.tolist() == [1.0] * 50
    assert series.highest[27] == 80.0
    assert sorted(series.highest)[-2] == 1.0
    one = downsample(stamps[:1], given_values[:1], START_NS, 50)
    assert (one.seconds.tolist(), one.median.tolist()) == ([0.0], [1.0])
    assert downsample(stamps[:0], given_values[:0], START_NS, 50).seconds.size == 0


def test_change_is_relative_to_the_first() -> None:
    assert change_percent(14.0, 102.0) == pytest.approx(-86.27, abs=0.01)
    assert change_percent(1.0, 0.0) is None
