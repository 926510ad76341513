"""The files that poses leave in: exact in format, whole or not there, nobody else's replaced."""

import json
import math
from pathlib import Path

import pytest

from localization.offline import OutputFolderError, ResultsFolder, TrajectoryWriter
from protocol.messages import TrackedPose
from tests.full_disk import files_no_longer_than

STAMP_NS = 1_700_000_000_012_345_678


def tracked(vehicle: str = "robot-1", stamp_ns: int = STAMP_NS, yaw: float = math.pi / 2) -> TrackedPose:
    covariance = (1.5e-7, -2e-9, 0.0, 2.5e-7, 1e-10, 3e-6)
    return TrackedPose(vehicle, stamp_ns, 1.25, -0.5, yaw, 0.1, 0.2, 0.3, covariance, ("cam0",))


def test_table_and_trajectories(tmp_path: Path) -> None:
    with TrajectoryWriter(tmp_path) as writer:
        writer.write([tracked(), tracked("robot-2", STAMP_NS + 1)])
        writer.write([tracked(stamp_ns=5, yaw=-math.pi / 3)])
    assert (tmp_path / "poses.csv").read_text().splitlines() == [
        "stamp_ns,vehicle,x_m,y_m,yaw_rad,covariance",
        "1700000000012345678,robot-1,1.250000,-0.500000,1.5707963,1.5e-07 -2e-09 0 2.5e-07 1e-10 3e-06",
        "1700000000012345679,robot-2,1.250000,-0.500000,1.5707963,1.5e-07 -2e-09 0 2.5e-07 1e-10 3e-06",
        "5,robot-1,1.250000,-0.500000,-1.0471976,1.5e-07 -2e-09 0 2.5e-07 1e-10 3e-06",
    ]
    assert (tmp_path / "robot-1.tum").read_text().splitlines() == [
        "1700000000.012345678 1.250000 -0.500000 0 0 0 0.707106781 0.707106781",
        "0.000000005 1.250000 -0.500000 0 0 0 -0.500000000 0.866025404",
    ]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["poses.csv", "robot-1.tum", "robot-2.tum"]


def put(path: Path, *names: str) -> None:
    with ResultsFolder(path, names) as folder:
        for name in names:
            (folder.draft / name).write_text(name)
        folder.commit({"figures": {"n": len(names)}})


def test_a_run_replaces_what_an_earlier_one_left_and_nothing_else(tmp_path: Path) -> None:
    out = tmp_path / "deep/out"
    put(out, "poses.csv", "robot-1.tum")
    (out / "notes.txt").write_text("mine")
    put(out, "poses.csv", "robot-2.tum")
    assert sorted(file.name for file in out.iterdir()) == ["notes.txt", "poses.csv", "report.json", "robot-2.tum"]
    report = json.loads((out / "report.json").read_text())
    assert report["files"] == ["poses.csv", "report.json", "robot-2.tum"]
    assert report["figures"] == {"n": 2}


def test_files_from_elsewhere_are_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text("years of work")
    with pytest.raises(OutputFolderError, match=r"holds poses\.csv from elsewhere"):
        ResultsFolder(tmp_path, ["poses.csv"])
    (tmp_path / "report.json").write_text('{"files": ["poses.csv"]}')
    with pytest.raises(OutputFolderError, match=r"holds poses\.csv, report\.json from elsewhere"):
        ResultsFolder(tmp_path, ["poses.csv"])
    assert (tmp_path / "poses.csv").read_text() == "years of work"
    with pytest.raises(OutputFolderError, match="is not a folder"):
        ResultsFolder(tmp_path / "poses.csv", [])


def test_a_run_that_fails_leaves_everything_as_it_was(tmp_path: Path) -> None:
    new, old = tmp_path / "new", tmp_path / "old"
    put(old, "poses.csv")
    for path in (new, old):
        with pytest.raises(RuntimeError), ResultsFolder(path, ["poses.csv"]) as folder:
            (folder.draft / "poses.csv").write_text("half")
            raise RuntimeError
    assert not new.exists()
    assert sorted(file.name for file in old.iterdir()) == ["poses.csv", "report.json"]
    assert (old / "poses.csv").read_text() == "poses.csv"


@pytest.mark.parametrize("size", [100, 20_000])
def test_a_full_disk_is_one_sentence_and_leaves_everything_as_it_was(tmp_path: Path, size: int) -> None:
    """Whether the disk refuses a pose as it comes, or what is still to be written at the end."""
    out = tmp_path / "out"
    put(out, "poses.csv")
    with (
        files_no_longer_than(size),
        pytest.raises(OutputFolderError, match="out cannot be written to: File too large"),
        ResultsFolder(out, ["poses.csv"]) as folder,
        TrajectoryWriter(folder.draft) as writer,
    ):
        for number in range(400):
            writer.write([tracked(stamp_ns=number), tracked("robot-2", number)])
        writer.close()
        folder.commit({})
    assert sorted(file.name for file in out.iterdir()) == ["poses.csv", "report.json"]
    assert (out / "poses.csv").read_text() == "poses.csv"


def test_a_report_cannot_name_files_outside(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    outside = tmp_path / "outside.txt"
    outside.write_text("stays")
    (out / "report.json").write_text('{"made_by": "lilliput localize", "files": ["../outside.txt", "report.json"]}')
    put(out, "poses.csv")
    assert outside.read_text() == "stays"
