"""Pose fusion on the robot: odometry, cameras, the report's filter and the Kalman filter, simulated and on recorded runs."""

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from launcher.errors import UsageError
from launcher.experiments.fusion_camera import Camera
from launcher.experiments.fusion_plot import plot_fusion
from launcher.experiments.fusion_runs import Recording, recordings
from launcher.experiments.fusion_score import SETTLED_S, Trace, heading_rmse_deg, rmse_mm
from launcher.experiments.fusion_trials import PLAIN, Outcome, Trial, conduct
from launcher.experiments.nees import Consistency, consistency
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
BLIND_SPEED_MPS = 0.3
"""The simulated speed that counts for `blind_8s_max_mm`: at higher ones the wheels' slip alone leads further away."""
_COMPENSATED_FROM_MPS = 0.5
_BLOCK_S = 60.0
"""A recorded run is cut into such blocks for the consistency."""


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
    """Drives at all speeds under all cameras, with 8 s of blindness, and under late stamps."""
    longest_s = 40.0 if quick else 70.0
    speeds = (0.3, 0.5, 1.5) if quick else SPEEDS_MPS
    trials: list[Trial] = []
    for seed in seeds:
        for speed in speeds:
            for camera in CAMERAS[1:2] if quick else CAMERAS:
                methods = (*PLAIN, "ekf", "ekf_uncompensated")
                trials.append(Trial("sim", speed, camera, seed, methods, longest_s))
            blind_s = 70.0 if quick else 190.0
            trials.append(Trial("sim_blind", speed, CAMERAS[1], seed, (*PLAIN, "ekf"), blind_s, blind=True))
        trials.append(Trial("sim_late", 0.5, LATE, seed, ("exponential", "ekf"), longest_s))
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


def figures(outcomes: Sequence[Outcome]) -> dict[str, float | int]:
    """Everything that was measured."""
    groups = {
        name: [outcome for outcome in outcomes if outcome.trial.group == name]
        for name in ("mrclam", "mrclam_blind", "sim", "sim_blind", "sim_late")
    }
    found: dict[str, float | int] = {}
    if groups["mrclam"]:
        found |= _recorded_figures(groups["mrclam"])
    found |= _simulated_figures(groups["sim"])
    found |= _blind_figures(groups["sim_blind"], groups["mrclam_blind"])
    found |= _late_figures(groups["sim_late"])
    found |= _consistency_figures(groups["sim"], groups["mrclam"])
    return found


def _recorded_figures(outcomes: Sequence[Outcome]) -> dict[str, float | int]:
    found: dict[str, float | int] = {"mrclam_runs": len({_name(outcome) for outcome in outcomes})}
    for key, method in (*((name, name) for name in PLAIN), ("ekf", "ekf_camera_time"), ("ekf_odometry_time", "ekf")):
        traces = [outcome.traces[method] for outcome in outcomes if method in outcome.traces]
        found[f"mrclam_{key}_rmse_mm"] = rmse_mm(traces)
        found[f"mrclam_{key}_heading_rmse_deg"] = heading_rmse_deg(traces)
    for name in sorted({_name(outcome) for outcome in outcomes}):
        own = [outcome for outcome in outcomes if _name(outcome) == name]
        key = "".join(letter if letter.isalnum() else "_" for letter in name.lower())
        found[f"mrclam_{key}_ekf_rmse_mm"] = rmse_mm([outcome.traces["ekf_camera_time"] for outcome in own])
        found[f"mrclam_{key}_ekf_delay_ms"] = own[0].constants["delay_s"] * 1e3
    return found


def _simulated_figures(outcomes: Sequence[Outcome]) -> dict[str, float | int]:
    found: dict[str, float | int] = {"sim_runs": len(outcomes)}
    speeds = sorted({_speed(outcome) for outcome in outcomes})
    for method in (*PLAIN, "ekf", "ekf_uncompensated"):
        traces = [outcome.traces[method] for outcome in outcomes]
        found[f"sim_{method}_rmse_mm"] = rmse_mm(traces)
        found[f"sim_{method}_heading_rmse_deg"] = heading_rmse_deg(traces)
        for speed in speeds:
            own = [outcome.traces[method] for outcome in outcomes if _speed(outcome) == speed]
            found[f"sim_{_cmps(speed)}_{method}_rmse_mm"] = rmse_mm(own)
    gains = [
        found[f"sim_{_cmps(speed)}_ekf_uncompensated_rmse_mm"] / found[f"sim_{_cmps(speed)}_ekf_rmse_mm"]
        for speed in speeds
        if speed >= _COMPENSATED_FROM_MPS
    ]
    found["delay_compensation_gain"] = min(gains)
    for delay_s in sorted({outcome.trial.camera.delay_s for outcome in outcomes}):
        own = [o for o in outcomes if o.trial.camera.delay_s == delay_s and _speed(o) >= _COMPENSATED_FROM_MPS]
        without, with_it = (rmse_mm([o.traces[name] for o in own]) for name in ("ekf_uncompensated", "ekf"))
        found[f"delay_compensation_gain_{round(delay_s * 1e3)}_ms"] = without / with_it
    found["ekf_linear_error_max"] = max(abs(o.constants["linear"] - o.linear) for o in outcomes)
    return found


def _blind_figures(simulated: Sequence[Outcome], recorded: Sequence[Outcome]) -> dict[str, float | int]:
    """The largest errors until the first pose after the blindness arrives."""
    found: dict[str, float | int] = {}
    counting = [outcome for outcome in simulated if _speed(outcome) == BLIND_SPEED_MPS]
    for method in (*PLAIN, "ekf"):
        of_recorded = "ekf_camera_time" if method == "ekf" else method
        worst = [_blind_max_mm(counting, method)]
        if recorded:
            worst.append(_blind_max_mm(recorded, of_recorded))
            found[f"mrclam_{method}_blind_8s_max_mm"] = worst[-1]
        found["blind_8s_max_mm" if method == "ekf" else f"{method}_blind_8s_max_mm"] = max(worst)
    found["blind_8s_windows"] = sum(len(outcome.blind) for outcome in (*counting, *recorded))
    for speed in sorted({_speed(outcome) for outcome in simulated}):
        own = [outcome for outcome in simulated if _speed(outcome) == speed]
        found[f"sim_{_cmps(speed)}_blind_8s_max_mm"] = _blind_max_mm(own, "ekf")
        found[f"sim_{_cmps(speed)}_blind_8s_rmse_mm"] = _blind_end_rmse_mm(own, "ekf")
    for group, outcomes, method in (("sim", simulated, "ekf"), ("mrclam", recorded, "ekf_camera_time")):
        if outcomes:
            inside = np.concatenate([part.nees for outcome in outcomes for part in _blind_parts(outcome, method)])
            found[f"{group}_blind_8s_nees_median"] = float(np.median(inside))
    return found


def _late_figures(outcomes: Sequence[Outcome]) -> dict[str, float | int]:
    late_s = LATE.stamps_late_s
    found: dict[str, float | int] = {
        f"late_stamps_{method}_rmse_mm": rmse_mm([outcome.traces[method] for outcome in outcomes])
        for method in ("exponential", "ekf")
    }
    found["ekf_delay_error_max_ms"] = max(abs(o.constants["delay_s"] - late_s) for o in outcomes) * 1e3
    return found


def _consistency_figures(simulated: Sequence[Outcome], recorded: Sequence[Outcome]) -> dict[str, float | int]:
    """NEES over x, y and yaw; 3 is right. A simulated run counts as one sample of a band's width, a minute of a recording as
    another: how much these scatter says how many independent errors each is worth."""
    drives = [outcome.traces["ekf"].nees for outcome in simulated]
    minutes = [block.nees for outcome in recorded for block in _blocks(outcome.traces["ekf_camera_time"])]
    found: dict[str, float | int] = {}
    for key, blocks in (("ekf_nees", drives + minutes), ("sim_ekf_nees", drives), ("mrclam_ekf_nees", minutes)):
        if len(blocks) >= 2:
            found |= _band(key, consistency(blocks, 3))
    return found


def _band(key: str, honest: Consistency) -> Mapping[str, float]:
    return {
        f"{key}_mean": honest.mean,
        f"{key}_low": honest.low,
        f"{key}_high": honest.high,
        f"{key}_independent": honest.independent,
    }


def _blocks(trace: Trace) -> list[Trace]:
    starts = np.arange(SETTLED_S, float(trace.seconds[-1]) - 0.5 * _BLOCK_S, _BLOCK_S)
    blocks = [trace.within(float(start), float(start) + _BLOCK_S) for start in starts]
    return [block for block in blocks if len(block.seconds)]


def _blind_parts(outcome: Outcome, method: str) -> list[Trace]:
    delay_s = outcome.trial.camera.delay_s
    parts = [outcome.traces[method].within(since, until + delay_s) for since, until in outcome.blind]
    return [part for part in parts if len(part.seconds)]


def _blind_max_mm(outcomes: Sequence[Outcome], method: str) -> float:
    parts = [part for outcome in outcomes for part in _blind_parts(outcome, method)]
    if not parts:
        raise UsageError("the runs are too short for 8 s of blindness")
    return max(float(part.distances_m.max()) for part in parts) * 1e3


def _blind_end_rmse_mm(outcomes: Sequence[Outcome], method: str) -> float:
    ends = [part.distances_m[-1] for outcome in outcomes for part in _blind_parts(outcome, method)]
    return float(np.sqrt(np.mean(np.square(ends)))) * 1e3


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


def _name(outcome: Outcome) -> str:
    assert isinstance(outcome.trial.source, Recording)
    return outcome.trial.source.name


def _speed(outcome: Outcome) -> float:
    assert isinstance(outcome.trial.source, float)
    return outcome.trial.source


def _cmps(speed_mps: float) -> str:
    return f"{round(speed_mps * 100)}_cmps"
