"""Pose fusion on the robot: odometry, cameras, the report's filter and the Kalman filter, simulated and on recorded runs."""

import argparse
import itertools
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from launcher.errors import UsageError
from launcher.experiments.fusion_camera import Camera
from launcher.experiments.fusion_figures import BLIND_SPEED_MPS, figures
from launcher.experiments.fusion_plot import plot_fusion
from launcher.experiments.fusion_runs import Recording, recordings
from launcher.experiments.fusion_score import SETTLED_S
from launcher.experiments.fusion_trials import PLAIN, Trial, conduct
from launcher.lab_file import add_lab_file_argument, read_lab
from launcher.output import Result, progress
from launcher.paths import ROOT

SPEEDS_MPS = (0.3, 0.5, 1.0, 1.5)
CAMERAS = (
    Camera(30.0, 0.02, 0.01, math.radians(1.0), outliers=0.03, seen_s=20.0),
    Camera(10.0, 0.15, 0.01, math.radians(1.0), outliers=0.03, seen_s=20.0),
    Camera(5.0, 0.40, 0.01, math.radians(1.0), outliers=0.03, seen_s=20.0),
)
"""For the simulated drives."""
LATE = Camera(15.0, 0.15, 0.01, math.radians(1.0), outliers=0.03, seen_s=20.0, stamps_late_s=0.06)
"""Its stamps are late: what the filter has to find out."""
RECORDED = Camera(10.0, 0.15, 0.02, math.radians(2.0), outliers=0.03, seen_s=20.0)
"""For the recorded runs."""
_DRIVES_A_SEED = 100
"""More than there are, so that drives of different seeds never share theirs."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_file_argument(parser)
    parser.add_argument(
        "--data",
        type=Path,
        metavar="DIR",
        help="recorded runs, RobotN_Odometry.dat and RobotN_Groundtruth.dat (default: ../shared/data/mrclam, if there)",
    )
    parser.add_argument("--quick", action="store_true", help="fewer and shorter runs")
    parser.add_argument("--seeds", type=int, metavar="N", help="of each simulated drive (default: 4, quick: 2)")
    parser.add_argument("--seed", type=int, default=1, help="the first (default: 1)")
    parser.add_argument("--workers", type=int, default=2, help="trials at the same time (default: 2)")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="write a picture there (PNG)")


def run(arguments: argparse.Namespace) -> Result:
    _, lab = read_lab(arguments.lab)
    seeds = arguments.seeds if arguments.seeds is not None else 2 if arguments.quick else 4
    if seeds < 1:
        raise UsageError(f"--seeds must be at least 1, not {seeds}")
    if arguments.workers < 1:
        raise UsageError(f"--workers must be at least 1, not {arguments.workers}")
    found = _recordings(arguments.data)
    numbers = range(arguments.seed, arguments.seed + seeds)
    trials = simulated_trials(numbers, quick=arguments.quick) + recorded_trials(
        found, arguments.seed, quick=arguments.quick
    )
    outcomes = conduct(trials, lab, arguments.workers)
    if arguments.plot is not None:
        plot_fusion(outcomes, arguments.plot)
    settings = {
        "lab": lab.name,
        "quick": arguments.quick,
        "seeds": list(numbers),
        "recordings": [str(recording.odometry) for recording in found],
        "settled_s": SETTLED_S,
        "blind_speed_mps": BLIND_SPEED_MPS,
        "cameras": [_described(camera) for camera in CAMERAS],
        "camera_late": _described(LATE),
        "camera_recorded": _described(RECORDED),
        "drive": lab.simulation.drive.model_dump(),
    }
    return Result("fusion", figures(outcomes), settings=settings)


def simulated_trials(seeds: Sequence[int], *, quick: bool) -> list[Trial]:
    """Drives at all speeds under all cameras, with 8 s of blindness, and under late stamps. Each has a seed of its own: drives
    that shared noise of cameras and wheels would be fewer independent samples than the band of the consistency takes them for."""
    longest_s = 40.0 if quick else 70.0
    speeds = (0.3, 0.5, 1.5) if quick else SPEEDS_MPS
    trials: list[Trial] = []
    for seed in seeds:
        own = itertools.count(_DRIVES_A_SEED * seed)
        for speed in speeds:
            for camera in CAMERAS[1:2] if quick else CAMERAS:
                methods = (*PLAIN, "ekf", "ekf_uncompensated")
                trials.append(Trial("sim", speed, camera, next(own), methods, longest_s))
            blind_s = 70.0 if quick else 190.0
            trials.append(Trial("sim_blind", speed, CAMERAS[1], next(own), (*PLAIN, "ekf"), blind_s, blind=True))
        trials.append(Trial("sim_late", 0.5, LATE, next(own), ("exponential", "ekf"), longest_s))
    return trials


def recorded_trials(found: Sequence[Recording], seed: int, *, quick: bool) -> list[Trial]:
    """Each recording twice with gaps by chance and twice with 8 s of blindness; when quick, two minutes of it and once each. The
    velocities of this data set are commands, ahead of what the robot does: the camera's clock is the right one."""
    longest_s = 130.0 if quick else math.inf
    methods = (*PLAIN, "ekf_camera_time")
    trials: list[Trial] = []
    for recording in found:
        for number in range(seed, seed + (1 if quick else 2)):
            extra = ("ekf",) if number == seed else ()
            trials.append(Trial("mrclam", recording, RECORDED, number, (*methods, *extra), longest_s))
            trials.append(Trial("mrclam_blind", recording, RECORDED, number, methods, longest_s, blind=True))
    return trials


def _recordings(folder: Path | None) -> list[Recording]:
    """Those of the folder that was given, or of the usual one; none where that is absent."""
    if folder is not None:
        if not folder.is_dir():
            raise UsageError(f"--data: there is no folder {folder}")
        return recordings(folder)
    usual = ROOT.parent / "shared/data/mrclam"
    if not usual.is_dir():
        progress(f"fusion: no recorded runs in {usual}, the figures mrclam_* are left out")
        return []
    return recordings(usual)


def _described(camera: Camera) -> dict[str, float | None]:
    return {key: value if math.isfinite(value) else None for key, value in asdict(camera).items()}
