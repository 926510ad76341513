"""`./lilliput record` and `./lilliput localize`: recordings of the simulated room, judged by the truth that lies beside them.

The room is the one of the reports as it ships, with its survey errors; the estimator is given a lab file without simulation.
"""

import csv
import json
import math
from collections import defaultdict
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from geometry import SE2
from launcher.cli import main
from launcher.experiments.visibility import TagVisibility
from launcher.paths import DEFAULT_LAB
from protocol.lab import load_lab

CAMERAS = ("cam0", "cam1", "cam2", "cam3")
RATE_HZ = 6.0
Instant = tuple[int, str]


def figures_of(*command: object) -> dict[str, Any]:
    """Runs a command that must succeed."""
    stdout = StringIO()
    with redirect_stdout(stdout):
        assert main([*map(str, command), "--json"]) == 0
    figures: dict[str, Any] = json.loads(stdout.getvalue())["figures"]
    return figures


@dataclass(frozen=True)
class Run:
    """A recording and what was made of it."""

    recording: Path
    out: Path
    figures: dict[str, Any]
    seed: int

    def truth(self) -> dict[Instant, SE2]:
        with (self.recording / "truth.csv").open() as file:
            return {
                (int(row["stamp_ns"]), row["vehicle"]): SE2(*(float(row[k]) for k in ("x_m", "y_m", "yaw_rad")))
                for row in csv.DictReader(file)
            }

    def poses(self) -> dict[Instant, tuple[SE2, list[float]]]:
        with (self.out / "poses.csv").open() as file:
            rows = list(csv.DictReader(file))
        assert [*rows[0]] == ["stamp_ns", "vehicle", "x_m", "y_m", "yaw_rad", "covariance"]
        poses = {
            (int(row["stamp_ns"]), row["vehicle"]): (
                SE2(float(row["x_m"]), float(row["y_m"]), float(row["yaw_rad"])),
                [float(v) for v in row["covariance"].split()],
            )
            for row in rows
        }
        assert len(poses) == len(rows), "one row per vehicle and capture time"
        assert list(poses) == sorted(poses)
        return poses

    def visible(self) -> set[Instant]:
        """Vehicles whose whole tag a camera shows, by the simulated optics, at the capture times of that camera."""
        lab = load_lab(DEFAULT_LAB)
        cameras = {camera: TagVisibility(lab, camera, self.seed) for camera in CAMERAS}
        truth = self.truth()
        seen: set[Instant] = set()
        for camera, frames in self.stamps().items():
            at = set(frames)
            seen |= {key for key, pose in truth.items() if key[0] in at and cameras[camera].sees(key[1], pose)}
        return seen

    def stamps(self) -> dict[str, list[int]]:
        """Capture times by camera."""
        videos = {
            file.stem: [int(word) for word in file.read_text().split()] for file in self.recording.glob("*.stamps")
        }
        folders = {
            path.name: sorted(int(f.stem) for f in path.iterdir()) for path in self.recording.iterdir() if path.is_dir()
        }
        return folders | videos


def recorded(path: Path, picture_format: str, seed: int) -> Path:
    common = ("--seconds", 3, "--rate-hz", RATE_HZ, "--seed", seed, "--format", picture_format, "--without-simulation")
    figures = figures_of("record", path, *common)
    assert figures["frames"] == len(CAMERAS) * 3 * RATE_HZ
    return path


def as_video(recording: Path, camera: str) -> None:
    """Turns a folder of pictures into a video with stamps."""
    files = sorted((recording / camera).iterdir(), key=lambda file: int(file.stem))
    writer: cv2.VideoWriter | None = None
    for file in files:
        image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
        assert image is not None
        if writer is None:
            size = (image.shape[1], image.shape[0])
            writer = cv2.VideoWriter(
                str(recording / f"{camera}.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 6.0, size, False
            )
        writer.write(image)
        file.unlink()
    assert writer is not None
    writer.release()
    (recording / camera).rmdir()
    (recording / f"{camera}.stamps").write_text("\n".join(file.stem for file in files))


@pytest.fixture(scope="module", params=["jpg", "png"])
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Run]:
    """One recording in JPEG, of which one camera is a video, and one in PNG."""
    folder = tmp_path_factory.mktemp(request.param)
    seed = {"jpg": 7, "png": 8}[request.param]
    recording = recorded(folder / "recording", request.param, seed)
    if request.param == "jpg":
        as_video(recording, "cam2")
    yield Run(recording, folder / "out", figures_of("localize", recording, "--out", folder / "out"), seed)


def test_recorded_vehicles_are_where_they_were(run: Run) -> None:
    truth, poses = run.truth(), run.poses()
    assert "simulation" not in (run.recording / "lab.yaml").read_text()
    position_mm: dict[str, list[float]] = defaultdict(list)
    heading_deg: list[float] = []
    normalised: list[float] = []
    for key, (pose, (xx, xy, xt, yy, yt, tt)) in poses.items():
        off = truth[key].between(pose)
        position_mm[key[1]].append(1e3 * math.hypot(off.x, off.y))
        heading_deg.append(abs(math.degrees(off.yaw)))
        error = np.array([pose.x - truth[key].x, pose.y - truth[key].y, off.yaw])
        normalised.append(float(error @ np.linalg.solve([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]], error)))
    everything = np.concatenate(list(position_mm.values()))
    assert float(np.median(everything)) <= 1.5
    assert float(np.percentile(everything, 99)) <= 5.0
    assert float(np.median(heading_deg)) <= 0.05
    assert set(position_mm) == {vehicle.id for vehicle in load_lab(DEFAULT_LAB).vehicles}
    # Three degrees of freedom; one survey is one draw whose errors all poses share.
    assert 0.2 <= float(np.mean(normalised)) <= 9.0


def test_no_visible_vehicle_is_missed_from_the_first_frame_on(run: Run) -> None:
    visible, poses = run.visible(), set(run.poses())
    assert len(visible) > 60
    assert len(visible & poses) / len(visible) >= 0.99
    first_ns = min(stamp for stamp, _ in visible)
    assert any(stamp == first_ns for stamp, _ in poses)


def test_figures_files_and_trajectories_agree(run: Run) -> None:
    poses, figures = run.poses(), run.figures
    assert figures["poses"] == len(poses) and figures["vehicles"] == 4
    assert figures["frames"] == sum(map(len, run.stamps().values())) and figures["broken_frames"] == 0
    assert figures["warnings"] == []
    for camera in CAMERAS:
        assert figures[f"{camera}_reprojection_px"] < 0.15
        assert len(figures[f"{camera}_floor_tags"]) == 4
    for vehicle in load_lab(DEFAULT_LAB).vehicles:
        rows = np.loadtxt(run.out / f"{vehicle.id}.tum", ndmin=2)
        mine = [pose for (_, name), (pose, _) in poses.items() if name == vehicle.id]
        assert rows.shape == (len(mine), 8)
        assert rows[:, 1:3] == pytest.approx(np.array([(p.x, p.y) for p in mine]), abs=1e-9)
        assert rows[:, 3:6] == pytest.approx(0.0)
        yaw = 2 * np.arctan2(rows[:, 6], rows[:, 7])
        assert np.cos(yaw - [p.yaw for p in mine]) == pytest.approx(1.0)
    assert json.loads((run.out / "report.json").read_text())["figures"] == figures


def test_an_earlier_calibration_gives_the_same_poses(run: Run, tmp_path: Path) -> None:
    again = figures_of(
        "localize", run.recording, "--out", tmp_path / "out", "--calibration", run.out / "calibration.json"
    )
    assert again["poses"] == run.figures["poses"]
    assert (tmp_path / "out/poses.csv").read_text() == (run.out / "poses.csv").read_text()


def refused(capsys: pytest.CaptureFixture[str], *command: object) -> str:
    """What a command says that must end with status 2 and one line."""
    assert main([*map(str, command)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    said = [line for line in captured.err.splitlines() if line.startswith("lilliput: ")]
    assert len(said) == 1
    return said[0]


def test_bad_use_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "nowhere does not exist" in refused(capsys, "localize", tmp_path / "nowhere")
    assert "has no lab.yaml: say with --lab" in refused(capsys, "localize", tmp_path)
    assert "holds no frames of a camera" in refused(capsys, "localize", tmp_path, "--lab", DEFAULT_LAB)
    assert "must be at least 1" in refused(capsys, "localize", tmp_path, "--full-search-every", 0)
    bare = tmp_path / "bare.yaml"
    lab = DEFAULT_LAB.read_text()
    floor = lab[lab.index("  poses:") : lab.index("vehicles:")]
    bare.write_text(lab.replace(floor, "  poses: {}\n\n"))
    assert "describes no floor tags" in refused(capsys, "localize", tmp_path, "--lab", bare)
    (tmp_path / "full/cam0").mkdir(parents=True)
    assert "not empty" in refused(capsys, "record", tmp_path / "full", "--seconds", 1)
    assert "no camera cam9; there are cam0" in refused(capsys, "record", tmp_path / "x", "--cameras", "cam9")
    assert "--rate-hz and --seed are for rendered" in refused(capsys, "record", tmp_path / "x", "--live", "--seed", 1)
    assert not (tmp_path / "x").exists()


def test_a_recording_without_floor_tags_in_view_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "cam0").mkdir()
    cv2.imwrite(str(tmp_path / "cam0/5.png"), np.full((1080, 1920), 90, np.uint8))
    assert main(["localize", str(tmp_path), "--lab", str(DEFAULT_LAB), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert (
        "lilliput: no camera finds its place: cam0 is not calibrated and gives no poses: it sees no floor tag" in said
    )
    assert not (tmp_path / "out").exists()


def test_results_of_others_stay(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "cam0").mkdir()
    cv2.imwrite(str(tmp_path / "cam0/5.png"), np.full((1080, 1920), 90, np.uint8))
    (tmp_path / "poses.csv").write_text("mine")
    said = refused(capsys, "localize", tmp_path, "--lab", DEFAULT_LAB, "--out", tmp_path)
    assert "holds poses.csv from elsewhere" in said
    assert (tmp_path / "poses.csv").read_text() == "mine"
