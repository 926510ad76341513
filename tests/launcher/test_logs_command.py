"""`./lilliput logs` over runs written as the processes write them: the table, its percent changes, pictures, and what it
refuses."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from launcher.cli import main
from localization.timings import SegmentWriter
from localization.timings.writer import Timing
from protocol.timings import Header, run_name

START_NS = 1_763_972_505_000_000_000
FRAMES = 2000


def write_run(state: Path, number: int, scale: float) -> str:
    """A run of two cameras and the tracker, whose totals are around `10 * scale` ms with a few outliers."""
    start_ns = START_NS + number * 3600 * 10**9
    name = run_name(start_ns)
    rng = np.random.default_rng(number)
    for process, kind in (("camera-cam0", "camera"), ("camera-cam1", "camera"), ("tracker", "tracker")):
        header = Header(name, start_ns, start_ns, process, kind, "gulliver", "nuc", "0.1.0", ())
        totals = scale * rng.normal(10.0, 1.0, FRAMES)
        totals[::100] += 50.0
        writer = SegmentWriter(state / "timings" / name, header, 10**7, lambda start_ns=start_ns: start_ns)
        stages: list[dict[str, float]] = [{"wait": 1.0, "total": float(total)} for total in totals]
        if kind == "camera":
            for frame in stages[::15]:
                frame["full"] = 8.0 * scale
        writer.write([Timing(start_ns + n * 16_000_000, each) for n, each in enumerate(stages)])
    return name


@pytest.fixture
def state(tmp_path: Path) -> Path:
    write_run(tmp_path, 1, 1.0)
    write_run(tmp_path, 2, 0.5)
    return tmp_path


def told(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["logs", *arguments]) == 0
    return capsys.readouterr().out


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["logs", *arguments]) != 0
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


def test_the_newest_two_are_compared(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = told(capsys, "--state", str(state))
    head, first, second, change = said[said.index("camera total") :].splitlines()[:4]
    assert head.split() == ["camera", "total,", "ms", "min", "Q1", "median", "Q3", "max", "p99", "outliers", "frames"]
    assert first.split()[0] == "20251124T092145Z"
    assert float(first.split()[3]) == pytest.approx(10.0, abs=0.1)
    assert int(first.split()[-1]) == 2 * FRAMES
    assert second.split()[0] == "20251124T102145Z"
    median_change = re.findall(r"([+-][\d.]+) %", change)[2]
    assert float(median_change) == pytest.approx(-50.0, abs=1.0)
    assert "tracker total" in said


def test_figures_are_flat_and_published_has_the_same_keys(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = json.loads(told(capsys, "--state", str(state), "--json"))
    figures = result["figures"]
    assert figures["run1_camera_total_median_ms"] == pytest.approx(10.0, abs=0.1)
    assert figures["run2_camera_total_median_change_percent"] == pytest.approx(-50.0, abs=1.0)
    assert "run1_camera_total_median_change_percent" not in figures
    assert figures["run1_camera_full_frames"] == 2 * -(-FRAMES // 15)
    assert figures["run1_camera_total_outliers"] >= 2 * FRAMES // 100
    assert figures["run1_camera_total_max_ms"] < 14.0, "max is without outliers"
    assert result["published"]["run1_camera_total_median_ms"] == 14.0
    assert result["published"]["run2_camera_total_max_ms"] == 24.4
    assert set(result["published"]) <= set(figures)
    assert result["settings"]["run2"]["label"] == "20251124T102145Z"
    assert result["settings"]["run1"]["processes"] == ["camera-cam0", "camera-cam1", "tracker"]


def test_runs_are_named_by_name_folder_or_file(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = state / "timings" / "20251124T102145Z"
    by_name = json.loads(told(capsys, "20251124T102145Z", "--state", str(state), "--json"))["figures"]
    by_folder = json.loads(told(capsys, str(folder), "--json"))["figures"]
    assert by_name == by_folder
    file = json.loads(told(capsys, str(folder / "camera-cam1.000001.timings"), "--json"))
    assert file["figures"]["run1_camera_total_frames"] == FRAMES
    assert file["settings"]["run1"]["label"] == "camera-cam1.000001"


def test_processes_and_times_are_chosen(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = json.loads(told(capsys, "--state", str(state), "--process", "camera-cam0", "--last", "1.6", "--json"))[
        "figures"
    ]
    assert one["run1_camera_total_frames"] == 101
    assert not any("tracker" in key for key in one)
    assert "it has camera-cam0, camera-cam1, tracker" in refused(capsys, "--state", str(state), "--process", "lab")


def test_pictures_are_drawn(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    boxes, graph = state / "boxes.png", state / "graph.png"
    said = told(capsys, "--state", str(state), "--plot", str(boxes), "--graph", str(graph), "--published")
    assert "GulliView 2025 (published)" in said
    for picture in (boxes, graph):
        pixels = np.asarray(Image.open(picture).convert("RGB")).reshape(-1, 3)
        assert len(np.unique(pixels, axis=0)) > 50
    without = state / "without.png"
    told(capsys, "--state", str(state), "--plot", str(without))
    assert boxes.read_bytes() != without.read_bytes()
    assert "should end with .png" in refused(capsys, "--state", str(state), "--plot", "boxes.pdf")
    assert "cannot write" in refused(capsys, "--state", str(state), "--plot", str(state / "no" / "a.png"))


def test_runs_are_listed(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = told(capsys, "--state", str(state), "--list").splitlines()
    assert [line.split()[0] for line in lines] == ["20251124T092145Z", "20251124T102145Z"]
    assert "gulliver" in lines[0]
    listed = json.loads(told(capsys, "--state", str(state), "--list", "--json"))["figures"]["runs"]
    assert [run["name"] for run in listed] == ["20251124T092145Z", "20251124T102145Z"]


def test_what_cannot_be_compared_is_refused_in_one_line(
    state: Path, tmp_path_factory: pytest.TempPathFactory, capsys: pytest.CaptureFixture[str]
) -> None:
    empty = tmp_path_factory.mktemp("empty")
    assert f"no stage timings in {empty}/timings; start the system" in refused(capsys, "--state", str(empty))
    unknown = refused(capsys, "yesterday", "--state", str(state))
    assert "there is no run 'yesterday'" in unknown
    assert "there are 20251124T092145Z, 20251124T102145Z" in unknown
    odd = state / "odd.timings"
    odd.write_bytes(b"something else entirely")
    assert f"{odd}: begins with b'somethin'" in refused(capsys, str(odd))
    assert "no timing log in it" in refused(capsys, str(empty))
    assert "seconds above 0" in refused(capsys, "--state", str(state), "--last", "-3")
