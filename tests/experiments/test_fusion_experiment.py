"""The fusion experiment: its cameras, its runs, its figures, and a short round of it."""

import gzip
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from agents.estimation import Localization
from geometry import SE2
from launcher.cli import main
from launcher.errors import UsageError
from launcher.experiments.fusion import CAMERAS, RECORDED, recorded_trials, simulated_trials
from launcher.experiments.fusion_camera import deliveries
from launcher.experiments.fusion_figures import figures
from launcher.experiments.fusion_methods import CameraOnly, Reported
from launcher.experiments.fusion_runs import Run, recordings, simulated
from launcher.experiments.fusion_trials import Trial, conduct_one
from protocol.lab import load_lab

GULLIVER = load_lab(Path("labs/gulliver.yaml"))
MRCLAM = Path(__file__).resolve().parents[3] / "shared/data/mrclam"


@pytest.fixture(scope="module")
def drive() -> Run:
    return simulated(GULLIVER, 1.0, 3, 40.0)


def test_a_simulated_drive_has_its_speed_and_its_wheels_lie(drive: Run) -> None:
    seconds = np.arange(5.0, 35.0, 0.1)
    way = np.diff(drive.truth(seconds)[:, :2], axis=0)
    assert np.median(np.hypot(way[:, 0], way[:, 1])) / 0.1 == pytest.approx(1.0, abs=0.05)
    said = np.unwrap([reading.pose.yaw for reading in drive.odometry])
    assert abs((said[-1] - said[0]) - (drive.poses[-1, 2] - drive.poses[0, 2])) > math.radians(20)


def test_a_camera_has_the_noise_the_delay_and_the_outliers_that_it_says(drive: Run) -> None:
    camera = replace(CAMERAS[1], rate_hz=100.0)
    found = deliveries(drive, camera, 1)
    arrivals = [delivery.arrival_ns for delivery in found]
    assert arrivals == sorted(arrivals)
    stamps = [delivery.pose.stamp_ns for delivery in found]
    assert stamps != sorted(stamps), "quick ones overtake"
    ages_s = (np.array(arrivals) - np.array(stamps)) / 1e9
    assert ages_s.min() == pytest.approx(0.12, abs=0.002) and ages_s.max() == pytest.approx(0.18, abs=0.002)
    true = drive.truth((np.array(stamps) - drive.start_ns) / 1e9)
    off = np.array([delivery.pose.x for delivery in found]) - true[:, 0]
    right = np.abs(off) < 0.06
    assert 0.005 < 1.0 - right.mean() < 0.04
    assert off[right].std() == pytest.approx(camera.sigma_m, rel=0.1)
    assert np.diff(np.sort(stamps)).max() > 5e8, "there are gaps"
    assert [d.pose for d in deliveries(drive, camera, 1)] == [d.pose for d in found]
    assert [d.pose for d in deliveries(drive, camera, 2)] != [d.pose for d in found]


def test_nothing_is_captured_in_blindness(drive: Run) -> None:
    found = deliveries(drive, replace(CAMERAS[0], seen_s=math.inf), 1, ((10.0, 18.0),))
    seconds = (np.array([delivery.pose.stamp_ns for delivery in found]) - drive.start_ns) / 1e9
    assert not ((seconds >= 10.0) & (seconds < 18.0)).any()
    assert ((seconds > 9.9) & (seconds < 10.0)).any() and ((seconds >= 18.0) & (seconds < 18.1)).any()


def test_the_reports_filter_moves_the_camera_on_by_velocity_times_age(drive: Run) -> None:
    reading = drive.odometry[500]
    delivery = deliveries(drive, CAMERAS[1], 1)[0]
    method, plain = Reported(), CameraOnly()
    pose = delivery.pose
    for each in (method, plain):
        each.odometry(reading)
        each.camera(pose, pose.stamp_ns + 200_000_000)
    seen, moved = plain.estimate(0).pose, method.estimate(0).pose
    assert seen is not None and moved is not None
    assert seen.distance_to(moved) == pytest.approx(0.2 * reading.twist.linear_mps, rel=0.01)
    assert CameraOnly().estimate(0).localization is Localization.NEVER


@pytest.mark.parametrize("quick", [False, True])
def test_no_two_simulated_drives_share_their_chance(*, quick: bool) -> None:
    """The band of the consistency takes each for an independent sample."""
    seeds = [trial.seed for trial in simulated_trials(range(1, 9), quick=quick)]
    assert len(set(seeds)) == len(seeds)
    assert simulated_trials(range(2, 3), quick=quick)[0].seed in seeds, "the same seed is the same drive"


def test_a_short_round_on_simulated_drives() -> None:
    trials = [
        replace(trial, longest_s=min(trial.longest_s, 62.0))
        for trial in simulated_trials(range(1, 3), quick=True)
        if trial.source in (0.3, 0.5)
    ]
    found = figures([conduct_one(trial, GULLIVER) for trial in trials])
    assert found["sim_ekf_rmse_mm"] < 20.0
    assert found["sim_ekf_rmse_mm"] < 0.5 * found["sim_exponential_rmse_mm"]
    assert found["sim_ekf_rmse_mm"] < 0.1 * found["sim_camera_rmse_mm"]
    assert found["delay_compensation_gain"] >= 2.0
    assert found["blind_8s_max_mm"] <= 250.0
    assert found["late_stamps_ekf_rmse_mm"] < 0.5 * found["late_stamps_exponential_rmse_mm"]
    assert found["ekf_delay_error_max_ms"] < 30.0
    assert found["ekf_linear_error_max"] < 0.02
    assert 1.5 < found["sim_ekf_nees_mean"] < 5.0
    assert not any(key.startswith("mrclam") for key in found)
    json.dumps(found, allow_nan=False)


@pytest.mark.skipif(not MRCLAM.is_dir(), reason=f"the recorded runs are not here ({MRCLAM})")
def test_a_recorded_run() -> None:
    trial = recorded_trials(recordings(MRCLAM)[:1], 1, quick=True)[0]
    outcome = conduct_one(trial, GULLIVER)
    ekf, exponential = outcome.traces["ekf_camera_time"], outcome.traces["exponential"]
    assert len(ekf.seconds) > 2000
    assert math.sqrt(np.mean(ekf.distances_m**2)) < 0.02
    assert math.degrees(math.sqrt(np.mean(ekf.errors[:, 2] ** 2))) < 1.5
    assert np.mean(ekf.distances_m**2) < 0.25 * np.mean(exponential.distances_m**2)
    assert np.mean(ekf.nees) < 7.0  # 6.2; these are this run's worst two minutes, the whole of both runs has 3.1


def test_recordings_are_found_compressed_or_not(tmp_path: Path) -> None:
    seconds = np.arange(1000.0, 1030.0, 0.02)
    odometry = "# a comment\n" + "".join(f"{s:.3f} \t 0.500 \t 0.000\n" for s in seconds[10:])
    truth = "# another\n" + "".join(f"{s:.3f} \t {0.5 * (s - 1000.0):.5f} \t 2.0 \t 0.0\n" for s in seconds)
    (tmp_path / "set").mkdir()
    (tmp_path / "set" / "Robot7_Odometry.dat").write_text(odometry)
    (tmp_path / "set" / "Robot7_Groundtruth.dat.gz").write_bytes(gzip.compress(truth.encode()))
    (found,) = recordings(tmp_path)
    assert found.name == "set/Robot7"
    run = found.load()
    assert run.duration_s == pytest.approx(29.78)
    assert run.odometry[-1].pose.x == pytest.approx(0.5 * 29.78, abs=1e-6)
    assert run.odometry[-1].twist.linear_mps == 0.5
    np.testing.assert_allclose(run.truth(np.array([1.0])), [[0.6, 2.0, 0.0]], atol=1e-6)
    outcome = conduct_one(Trial("mrclam", found, RECORDED, 1, ("ekf",), math.inf), GULLIVER)
    assert len(outcome.traces["ekf"].seconds) > 300


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({}, "no RobotN_Odometry.dat"),
        ({"Robot1_Odometry.dat": "1 2 3\n"}, "Robot1_Groundtruth.dat is missing"),
        ({"Robot1_Odometry.dat": "1 2 x\n", "Robot1_Groundtruth.dat": "1 2 3 4\n"}, "cannot read"),
        ({"Robot1_Odometry.dat": "1 2\n2 3\n", "Robot1_Groundtruth.dat": "1 2 3 4\n"}, "lines of 3 numbers"),
        ({"Robot1_Odometry.dat": "1 0 0\n2 0 nan\n", "Robot1_Groundtruth.dat": "1 2 3 4\n"}, "lines of 3 numbers"),
        (
            {"Robot1_Odometry.dat": "1 0 0\n2 0 0\n", "Robot1_Groundtruth.dat": "8 2 3 4\n9 2 3 4\n"},
            "of different times",
        ),
    ],
)
def test_recordings_that_cannot_be_used_are_said(tmp_path: Path, files: dict[str, str], said: str) -> None:
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(UsageError, match=said):
        recordings(tmp_path)[0].load()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [(["--data", "/nowhere/at/all"], "no folder"), (["--seeds", "0"], "--seeds"), (["--workers", "0"], "--workers")],
)
def test_bad_use_is_one_line(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["experiment", "fusion", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_poses_are_unwrapped_for_interpolation() -> None:
    run = Run("r", 0, (), np.array([0.0, 0.05]), np.array([[0.0, 0.0, 3.1], [0.0, 0.0, 3.2]]))
    assert SE2(*run.truth(np.array([0.025]))[0]).yaw == pytest.approx(3.15 - math.tau)
