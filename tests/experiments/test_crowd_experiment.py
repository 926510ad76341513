"""The crowd experiment, here with half the room and for a moment."""

import math
from itertools import combinations
from pathlib import Path

import pytest

from launcher.cli import main
from launcher.experiments.crowd_drive import CrowdDrive, drive_crowd
from launcher.experiments.crowd_rate import measure_rate
from launcher.experiments.rooms import surveyed_as_described
from protocol.lab import load_lab

GULLIVER = Path(__file__).resolve().parents[2] / "labs/gulliver.yaml"


@pytest.fixture(scope="module")
def drive() -> CrowdDrive:
    lab = load_lab(GULLIVER)
    return drive_crowd(surveyed_as_described(lab.model_copy(update={"cameras": lab.cameras[1:3]})), 3, 30, seconds=1.0)


def test_tags_in_view_give_their_poses_and_nobody_is_lost(drive: CrowdDrive) -> None:
    """With two cameras of four some drive in from where nobody looks, and are found a moment later."""
    assert drive.visible_tags > 150
    assert drive.found_tags / drive.visible_tags >= 0.98
    assert drive.lost == 0
    assert drive.error_median_mm <= 1.5
    assert drive.error_max_mm <= 6.0


def test_thirty_vehicles_drive_without_touching(drive: CrowdDrive) -> None:
    for look in drive.looks:
        assert len(look.vehicles) == 30
        assert min(math.dist((a.x, a.y), (b.x, b.y)) for a, b in combinations(look.vehicles, 2)) > 0.4
    first, last = drive.looks[0].vehicles[0], drive.looks[-1].vehicles[0]
    seconds = (drive.looks[-1].stamp_ns - drive.looks[0].stamp_ns) * 1e-9
    assert math.dist((first.x, first.y), (last.x, last.y)) == pytest.approx(0.4 * seconds, rel=0.1)


def test_the_stopwatch_measures_every_process(drive: CrowdDrive) -> None:
    rate = measure_rate(drive, frames=5)
    assert rate.camera_rate_hz > 0
    assert 0 < rate.frame_median_ms <= rate.frame_p99_ms
    assert rate.camera_rate_hz <= 1000 / rate.track_median_ms


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--vehicles", "0"], "--vehicles must be from 1 to 60"),
        (["--seconds", "0"], "--seconds must be more than 0"),
        (["--frames", "1"], "--frames must be from 5 to 200"),
    ],
)
def test_bad_use_is_a_sentence(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["experiment", "crowd", "--lab", str(GULLIVER), *arguments]) == 2
    assert said in capsys.readouterr().err
