"""Path following: every controller on every kind of vehicle over the same courses, beside the report's controller."""

import argparse
import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from functools import partial
from math import degrees, radians
from pathlib import Path

import numpy as np

from agents.control import CONTROLLERS
from launcher.errors import UsageError
from launcher.experiments.fusion_camera import Camera
from launcher.experiments.route_courses import courses
from launcher.experiments.route_drive import COMMAND_DELAY_S, COMMAND_LOSS, Track, Trial, drive
from launcher.experiments.route_plot import plot_route
from launcher.experiments.route_score import Score, pooled_mm, scored
from launcher.lab_file import read_lab
from launcher.output import Result, progress
from launcher.paths import ROOT
from protocol.lab import Lab, VehicleSpec

LAB = ROOT / "labs/kinds.yaml"
CAMERA = Camera(15.0, 0.08, 0.005, radians(0.5))
SPEED_MPS = 0.5
_SPEED_SHARE = 0.8
"""Slower where a vehicle cannot do that easily."""
REPORT, OURS = "gpss", "frenet"
MIN_GAIN, MAX_STOP_ERROR_MM = 3.0, 20.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--lab",
        type=Path,
        metavar="FILE",
        help="lab description (default: labs/kinds.yaml); its simulated vehicles drive",
    )
    parser.add_argument("--controllers", nargs="+", choices=sorted(CONTROLLERS), help="(default: all)")
    parser.add_argument("--kinds", nargs="+", metavar="ID", help="vehicles of the lab file (default: one of each kind)")
    parser.add_argument("--courses", nargs="+", choices=[course.name for course in courses()], help="(default: all)")
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="of each drive (default: 3)")
    parser.add_argument("--seed", type=int, default=1, help="the first (default: 1)")
    parser.add_argument("--workers", type=int, default=2, help="drives at the same time (default: 2)")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="write a picture there (PNG)")


def run(arguments: argparse.Namespace) -> Result:
    _, lab = read_lab(arguments.lab or LAB)
    for name in ("seeds", "workers"):
        if getattr(arguments, name) < 1:
            raise UsageError(f"--{name} must be at least 1, not {getattr(arguments, name)}")
    vehicles = chosen_vehicles(lab, arguments.kinds)
    trials = trials_of(
        vehicles,
        arguments.controllers or tuple(CONTROLLERS),
        arguments.courses,
        range(arguments.seed, arguments.seed + arguments.seeds),
    )
    tracks = conduct(trials, lab, arguments.workers)
    if arguments.plot is not None:
        plot_route(tracks, arguments.plot)
    settings = {
        "lab": lab.name,
        "seeds": list(range(arguments.seed, arguments.seed + arguments.seeds)),
        "speeds_mps": {vehicle.id: speed_of(vehicle) for vehicle in vehicles},
        "courses_m": {course.name: round(course.length_m, 2) for course in courses()},
        "camera": {key: value for key, value in asdict(CAMERA).items() if np.isfinite(value) and key != "gap_s"},
        "command_delay_s": COMMAND_DELAY_S,
        "command_loss": COMMAND_LOSS,
        "drive": lab.simulation.drive.model_dump(),
    }
    return Result("route", figures(tracks), settings=settings)


def chosen_vehicles(lab: Lab, ids: Sequence[str] | None) -> tuple[VehicleSpec, ...]:
    """Those of the ids, or the first simulated vehicle of each kind. UsageError when there is none."""
    simulated = {vehicle.id: vehicle for vehicle in lab.vehicles if vehicle.driver == "sim"}
    for name in ids or ():
        if name not in simulated:
            raise UsageError(
                f"no simulated vehicle {name} in lab {lab.name}; its own: {', '.join(simulated) or 'none'}"
            )
    if ids:
        return tuple(simulated[name] for name in dict.fromkeys(ids))
    first = {vehicle.kind: vehicle for vehicle in reversed(simulated.values())}
    if not first:
        raise UsageError(f"lab {lab.name} has no simulated vehicle")
    return tuple(vehicle for vehicle in simulated.values() if first[vehicle.kind] is vehicle)


def speed_of(vehicle: VehicleSpec) -> float:
    """The set-point of its routes, m/s."""
    return round(min(SPEED_MPS, _SPEED_SHARE * vehicle.limits.speed_mps), 3)


def trials_of(
    vehicles: Sequence[VehicleSpec], controllers: Sequence[str], names: Sequence[str] | None, seeds: Sequence[int]
) -> list[Trial]:
    """All of them; the same seed is the same camera, the same wheels and the same start for each controller."""
    return [
        Trial(vehicle, controller, course, CAMERA, speed_of(vehicle), seed)
        for vehicle in vehicles
        for controller in controllers
        for course in courses()
        if names is None or course.name in names
        for seed in seeds
    ]


def conduct(trials: Sequence[Trial], lab: Lab, workers: int) -> list[Track]:
    """All drives, in their order."""
    tracks: list[Track] = []
    # Spawned, not forked: the parent may have threads.
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        for track in pool.map(partial(drive, lab), trials):
            tracks.append(track)
            if len(tracks) % 20 == 0 or len(tracks) == len(trials):
                progress(f"route: {len(tracks)} of {len(trials)} drives")
    return tracks


def figures(tracks: Sequence[Track]) -> dict[str, float | int]:
    """By vehicle and controller, over all courses; by course; and how ours compares with the report's."""
    scores = [(track.trial, scored(track)) for track in tracks]
    found: dict[str, float | int] = {}
    kinds = dict.fromkeys(trial.vehicle.id for trial, _ in scores)
    controllers = dict.fromkeys(trial.controller for trial, _ in scores)
    for kind in kinds:
        for controller in controllers:
            own = [s for t, s in scores if t.vehicle.id == kind and t.controller == controller]
            found |= _summary(f"{_key(kind)}_{controller}", own)
        if REPORT in controllers and OURS in controllers:
            found |= _comparison(_key(kind), found)
    for kind in kinds:
        for controller in controllers:
            for course in dict.fromkeys(trial.course.name for trial, _ in scores):
                own = [
                    s
                    for t, s in scores
                    if t.vehicle.id == kind and t.controller == controller and t.course.name == course
                ]
                key = f"{_key(kind)}_{controller}_{course}"
                found[f"{key}_cross_track_p95_mm"] = pooled_mm(own, 95.0)
                found[f"{key}_stop_error_mm"] = max(s.stop_error_m for s in own) * 1e3
                found[f"{key}_time_ratio"] = _time_ratio(own)
    return found


def _summary(key: str, scores: Sequence[Score]) -> dict[str, float | int]:
    stops = np.array([score.stop_error_m for score in scores]) * 1e3
    found: dict[str, float | int] = {
        f"{key}_cross_track_median_mm": pooled_mm(scores, 50.0),
        f"{key}_cross_track_p95_mm": pooled_mm(scores, 95.0),
        f"{key}_cross_track_max_mm": pooled_mm(scores, 100.0),
        f"{key}_stop_error_mm": float(stops.max()),
        f"{key}_stop_error_median_mm": float(np.median(stops)),
        f"{key}_time_ratio": _time_ratio(scores),
        f"{key}_jerk_rms": float(np.sqrt(np.mean([score.jerk_rms_mps3**2 for score in scores]))),
        f"{key}_not_arrived": sum(not score.arrived for score in scores),
    }
    headings = [score.heading_error_rad for score in scores if score.heading_error_rad is not None]
    if headings:
        found[f"{key}_heading_error_deg"] = degrees(max(headings))
    return found


def _comparison(kind: str, found: dict[str, float | int]) -> dict[str, float | int]:
    """How many times smaller our 95th percentile is, and our time by the report's; whether all three demands are met."""
    gain = found[f"{kind}_{REPORT}_cross_track_p95_mm"] / found[f"{kind}_{OURS}_cross_track_p95_mm"]
    time = found[f"{kind}_{OURS}_time_ratio"] / found[f"{kind}_{REPORT}_time_ratio"]
    met = gain >= MIN_GAIN and time <= 1.0 and found[f"{kind}_{OURS}_stop_error_mm"] <= MAX_STOP_ERROR_MM
    return {f"{kind}_cross_track_gain": gain, f"{kind}_time_gain": 1.0 / time, f"{kind}_met": int(met)}


def _time_ratio(scores: Sequence[Score]) -> float:
    return sum(score.duration_s for score in scores) / sum(score.ideal_s for score in scores)


def _key(name: str) -> str:
    return "".join(letter if letter.isalnum() else "_" for letter in name.lower())
