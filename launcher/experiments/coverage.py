"""Localization all over the floor: error, detection rate, honesty of the covariance, and the jump between cameras."""

import argparse
import math
import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from launcher.errors import LauncherError, UsageError
from launcher.experiments.coverage_plot import plot_coverage
from launcher.experiments.coverage_samples import Placements, RoomSamples, sample_room
from launcher.experiments.nees import consistency, nees
from launcher.experiments.rooms import surveyed_as_described
from launcher.lab_file import add_lab_file_argument, read_lab
from launcher.output import Result, progress
from protocol.lab import Lab

ROOMS = 24
DRIVES = 6
CELL_M = 0.4


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_file_argument(parser)
    parser.add_argument(
        "--rooms", type=int, default=ROOMS, help=f"rooms surveyed with errors of their own (default: {ROOMS})"
    )
    parser.add_argument(
        "--drives", type=int, default=DRIVES, help=f"rooms that are also driven across (default: {DRIVES})"
    )
    parser.add_argument("--cell", type=float, default=CELL_M, metavar="M", help=f"grid of places (default: {CELL_M} m)")
    parser.add_argument("--seed", type=int, default=1, help="of the first room (default: 1)")
    parser.add_argument("--workers", type=int, default=2, help="rooms at the same time (default: 2)")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="write the heat map there (PNG)")


def run(arguments: argparse.Namespace) -> Result:
    path, lab = read_lab(arguments.lab)
    _check(arguments, path, lab)
    seeds = range(arguments.seed, arguments.seed + arguments.rooms)
    rooms = measure(surveyed_as_described(lab), seeds, arguments.drives, arguments.cell, arguments.workers)
    if arguments.plot is not None:
        plot_coverage(lab, Placements.joined([room.placements for room in rooms]), arguments.cell, arguments.plot)
    settings = {
        "lab": lab.name,
        "rooms": arguments.rooms,
        "drives": arguments.drives,
        "cell_m": arguments.cell,
        "seed": arguments.seed,
        "accuracy": lab.accuracy.model_dump(),
    }
    return Result("coverage", figures(rooms), settings=settings)


def measure(lab: Lab, seeds: Sequence[int], drives: int, cell_m: float, workers: int = 1) -> list[RoomSamples]:
    """The rooms of these seeds, the first `drives` of them also driven across; the same whatever the number of processes."""
    jobs = [(seed, number < drives) for number, seed in enumerate(seeds)]
    job = partial(_job, lab, cell_m)
    if workers == 1:
        return [job(each) for each in jobs]
    rooms: list[RoomSamples] = []
    # spawn: forked processes would share locks that OpenCV's threads hold.
    with ProcessPoolExecutor(
        workers, multiprocessing.get_context("spawn"), initializer=cv2.setNumThreads, initargs=(1,)
    ) as pool:
        for room in pool.map(job, jobs):
            rooms.append(room)
            progress(f"room {len(rooms)} of {len(jobs)}")
    return rooms


def _job(lab: Lab, cell_m: float, job: tuple[int, bool]) -> RoomSamples:
    seed, drives = job
    return sample_room(lab, seed, cell_m, drives=drives)


def figures(rooms: Sequence[RoomSamples]) -> dict[str, float | int]:
    """Flat figures. The NEES is over x, y and yaw (`nees_dimension`), its band as `nees.consistency` has it. LauncherError when
    nothing was tracked."""
    everything = Placements.joined([room.placements for room in rooms])
    tracked = everything.tracked
    if not tracked.any():
        raise LauncherError(f"nothing was tracked: cameras saw {int(everything.visible.sum())} whole tags")
    errors_mm = np.hypot(*everything.errors[tracked, :2].T) * 1e3
    normalised = [
        nees(room.placements.errors[room.placements.tracked], room.placements.covariances[room.placements.tracked])
        for room in rooms
    ]
    honest = consistency(normalised, dimension=3)
    several = everything.visible[tracked] > 1
    found: dict[str, float | int] = {
        "error_median_mm": float(np.median(errors_mm)),
        "error_p95_mm": float(np.percentile(errors_mm, 95)),
        "error_max_mm": float(errors_mm.max()),
        "heading_error_median_deg": math.degrees(float(np.median(np.abs(everything.errors[tracked, 2])))),
        "detection_share": float(everything.found.sum() / everything.visible.sum()),
        "visible_tags": int(everything.visible.sum()),
        "poses": int(tracked.sum()),
        "nees_mean": honest.mean,
        "nees_band_low": honest.low,
        "nees_band_high": honest.high,
        "nees_dimension": 3,
        "nees_independent_per_room": honest.independent,
    }
    if several.any() and not several.all():
        together = np.concatenate(normalised)
        found["nees_one_camera_mean"] = float(together[~several].mean())
        found["nees_several_cameras_mean"] = float(together[several].mean())
    drives = [room.drive for room in rooms if room.drive is not None]
    if drives:
        found["handover_jump_max_mm"] = max(drive.jump_max_m for drive in drives) * 1e3
        found["handovers"] = sum(drive.handovers for drive in drives)
        found["error_step_max_mm"] = max(drive.step_max_m for drive in drives) * 1e3
    return found


def _check(arguments: argparse.Namespace, path: Path, lab: Lab) -> None:
    if arguments.rooms < 2:
        raise UsageError(
            f"--rooms must be at least 2, not {arguments.rooms}: one room alone does not tell how far rooms differ"
        )
    if not 0 <= arguments.drives <= arguments.rooms:
        raise UsageError(f"--drives must be from 0 to --rooms, not {arguments.drives}")
    if not 0.1 <= arguments.cell <= 5.0:
        raise UsageError(f"--cell must be from 0.1 to 5 m, not {arguments.cell:g}")
    if arguments.workers < 1:
        raise UsageError(f"--workers must be at least 1, not {arguments.workers}")
    if not lab.cameras or any(camera.id not in lab.simulation.mounts for camera in lab.cameras):
        raise UsageError(f"{path} has no simulated cameras to measure with")
    if not lab.vehicles:
        raise UsageError(f"{path} has no vehicle to place on the floor")
