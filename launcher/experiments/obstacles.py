"""People step into a robot's way and pallets are left there: how soon it stands, by cameras, by its scanner, as deployed, and
whether it then gets to its goal around what is left there."""

import argparse
import multiprocessing
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from launcher.errors import UsageError
from launcher.experiments.detour_scenes import CLEARANCE_M
from launcher.experiments.detour_trials import DetourTrial, conduct_detour
from launcher.experiments.obstacle_scenes import FASTEST_MPS, SLOWEST_MPS, draw_scene
from launcher.experiments.obstacle_trials import Trial, Watcher, conduct, false_stops
from launcher.experiments.obstacles_plot import plot_obstacles
from launcher.lab_file import add_lab_file_argument, read_lab
from launcher.output import Result, progress
from protocol.lab import Lab

SCENES = 200
DROPS = 40
EMPTY_S = 600.0
_SPREAD = 10_000
"""Between the seeds of scenes and of drops."""
J = TypeVar("J")
R = TypeVar("R")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_file_argument(parser)
    parser.add_argument("--scenes", type=int, default=SCENES, help=f"how many scenes (default: {SCENES})")
    parser.add_argument(
        "--drops",
        type=int,
        default=DROPS,
        help=f"scenes in which a thing drops into the protective field (default: {DROPS})",
    )
    parser.add_argument(
        "--empty",
        type=float,
        default=EMPTY_S,
        metavar="S",
        help=f"simulated seconds on an empty floor (default: {EMPTY_S:g})",
    )
    parser.add_argument("--seed", type=int, default=1, help="of the first scene; the others follow (default: 1)")
    parser.add_argument(
        "--workers", type=int, default=min(2, os.cpu_count() or 1), help="processes at work (default: 2)"
    )
    parser.add_argument(
        "--plot", type=Path, default=Path("obstacles.png"), metavar="FILE", help="PNG (default: obstacles.png)"
    )


def run(arguments: argparse.Namespace) -> Result:
    path, lab = read_lab(arguments.lab)
    if arguments.scenes < 1 or arguments.drops < 0 or arguments.workers < 1 or not 0 <= arguments.empty <= 36_000:
        raise UsageError("--scenes and --workers are at least 1, --drops at least 0, --empty from 0 to 36000 s")
    guarded = _guarded(lab)
    if not guarded:
        raise UsageError(f"{path} has no simulated vehicle with a scanner")
    try:
        draw_scene(lab, arguments.seed)
    except ValueError as error:
        raise UsageError(f"{path}: {error}") from error
    seeds = [arguments.seed + number for number in range(arguments.scenes)]
    drops = [arguments.seed + _SPREAD + number for number in range(arguments.drops)]
    jobs = [(seed, watcher, False) for seed in seeds for watcher in Watcher]
    jobs += [(seed, Watcher.SCANNER, True) for seed in drops]
    trials = _spread(partial(_trial, lab), jobs, arguments.workers, "scenes")
    left = [seed for seed in seeds if draw_scene(lab, seed).kind == "pallet"]
    detours = _spread(partial(_detour, lab), left, arguments.workers, "detours") if left else []
    empty = _spread(partial(_empty, lab, arguments.empty, arguments.seed), guarded, arguments.workers, "empty floors")
    plot_obstacles(lab, trials, detours, arguments.plot)
    settings = {
        "lab": lab.name,
        "seed": arguments.seed,
        "speed_mps": [SLOWEST_MPS, FASTEST_MPS],
        "detour_clearance_m": CLEARANCE_M,
        "empty_s": arguments.empty,
        "empty_vehicles": guarded,
        "plot": str(arguments.plot),
    }
    return Result("obstacles", figures(trials, detours) | _empty_figures(empty), settings=settings)


def figures(trials: Sequence[Trial], detours: Sequence[DetourTrial] = ()) -> dict[str, float | int]:
    """Flat figures of the trials. `collisions` are contacts as deployed, those on detours included; reactions are those of robots
    that moved when the thing came into the field."""
    scenes = [trial for trial in trials if trial.kind != "drop"]
    found: dict[str, float | int] = {
        "scenes": len({trial.seed for trial in scenes}),
        "people": sum(trial.kind == "person" for trial in scenes if trial.watcher is Watcher.BOTH),
        "pallets": sum(trial.kind == "pallet" for trial in scenes if trial.watcher is Watcher.BOTH),
    }
    for watcher in Watcher:
        own = [trial for trial in scenes if trial.watcher is watcher]
        behind = "" if watcher is Watcher.BOTH else f"_{watcher}"
        found[f"collisions{behind}"] = sum(trial.contacts for trial in own)
        # A scanner's field comes to a pallet, a person comes into the field: only that is a moment to react to.
        came = [trial for trial in own if trial.kind == "person"] if watcher is Watcher.SCANNER else own
        found |= _reactions(f"reaction{behind}", came)
        found[f"gap{behind}_min_m"] = min(trial.gap_m for trial in own)
    tried = [trial.resumed for trial in scenes if trial.resumed is not None]
    if tried:
        found["resumed_share"] = sum(tried) / len(tried)
    drops = [trial for trial in trials if trial.kind == "drop"]
    if drops:
        found["drops"] = len(drops)
        found["collisions_drop"] = sum(trial.contacts for trial in drops)
        found |= _reactions("reaction_scanner_drop", drops)
    if detours:
        found["collisions"] += sum(trial.contacts for trial in detours)
        found |= _detour_figures(detours)
    return found


def _detour_figures(detours: Sequence[DetourTrial]) -> dict[str, float | int]:
    """What became of robots before pallets left behind: of those that had a way to their goal, and of those that had none."""
    with_way = [trial for trial in detours if trial.way]
    without = [trial for trial in detours if not trial.way]
    found: dict[str, float | int] = {
        "detour_scenes": len(detours),
        "detour_ways": len(with_way),
        "detour_no_way_arrived": sum(trial.arrived for trial in without),
        "detour_no_way_told": sum(trial.told for trial in without),
        "detour_gap_min_m": min(trial.gap_m for trial in detours),
        "collisions_detour": sum(trial.contacts for trial in detours),
    }
    arrived = [trial for trial in with_way if trial.arrived and trial.diverted]
    if with_way:
        found["detour_share"] = len(arrived) / len(with_way)
    if arrived:
        found["detour_median_s"] = float(np.median([trial.seconds for trial in arrived]))
    clearances = [trial.clearance_m for trial in detours if trial.clearance_m is not None]
    if clearances:
        found["detour_clearance_median_m"] = float(np.median(clearances))
        found["detour_clearance_min_m"] = min(clearances)
    return found


def _reactions(name: str, trials: Sequence[Trial]) -> dict[str, float | int]:
    reactions = np.array([trial.reaction_s for trial in trials if trial.reaction_s is not None])
    found: dict[str, float | int] = {f"{name}_stops": len(reactions)}
    if len(reactions):
        found[f"{name}_median_s"] = float(np.median(reactions))
        found[f"{name}_p95_s"] = float(np.percentile(reactions, 95))
        found[f"{name}_max_s"] = float(reactions.max())
    return found


def _empty_figures(empty: Sequence[dict[str, int]]) -> dict[str, int]:
    total: dict[str, int] = {}
    for each in empty:
        for name, count in each.items():
            total[name] = total.get(name, 0) + count
    metres = total.pop("metres", 0)
    by_reason = {f"false_stops_{code}": count for code, count in sorted(total.items())}
    return {"false_stops": sum(total.values()), "empty_floor_m": metres, **by_reason}


def _guarded(lab: Lab) -> list[str]:
    """The first simulated vehicle of each kind that has a scanner."""
    kinds: dict[str, str] = {}
    for vehicle in lab.vehicles:
        if vehicle.driver == "sim" and vehicle.scanner is not None:
            kinds.setdefault(vehicle.kind, vehicle.id)
    return list(kinds.values())


def _trial(lab: Lab, job: tuple[int, Watcher, bool]) -> Trial:
    seed, watcher, drop = job
    return conduct(lab, draw_scene(lab, seed, drop=drop), watcher)


def _detour(lab: Lab, seed: int) -> DetourTrial:
    return conduct_detour(lab, draw_scene(lab, seed))


def _empty(lab: Lab, seconds: float, seed: int, vehicle: str) -> dict[str, int]:
    return false_stops(lab, vehicle, seed, seconds)


def _spread(work: Callable[[J], R], jobs: Sequence[J], workers: int, what: str) -> list[R]:
    """The results in the order of the jobs, the same whatever the number of processes."""
    if workers == 1:
        return _told(map(work, jobs), len(jobs), what)
    with ProcessPoolExecutor(min(workers, len(jobs)), multiprocessing.get_context("spawn")) as pool:
        return _told(pool.map(work, jobs, chunksize=max(1, min(8, len(jobs) // workers))), len(jobs), what)


def _told(results: Iterable[R], count: int, what: str) -> list[R]:
    done: list[R] = []
    for result in results:
        done.append(result)
        if len(done) % max(1, count // 10) == 0:
            progress(f"{what}: {len(done)} of {count}")
    return done
