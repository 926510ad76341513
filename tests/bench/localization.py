"""Localization's speed: frame to message, and frames per second, ours and the published methods on the same rendered frames."""

import argparse
import multiprocessing
import os
import tempfile
import time
from collections.abc import Generator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from launcher.errors import LauncherError
from launcher.experiments.cameras import RESOLUTIONS
from launcher.lab_file import read_lab
from launcher.output import Result, progress
from launcher.paths import DEFAULT_LAB
from protocol.lab import Lab
from tests.bench.follow import Run, figures, follow
from tests.bench.methods import PUBLISHED_K, methods
from tests.bench.scene import JPEG_QUALITY, LOOP_FRAMES, RATE_HZ, VEHICLE_COUNTS, bench_lab, read_recording, record
from tests.bench.sustained import SustainedError, sustained

PUBLISHED = {
    "fullhd_4_follow_median_ms": 14.0,
    "fullhd_4_gulliview2025_median_ms": 14.0,
    "fullhd_4_gulliview2024_median_ms": 102.0,
}
"""GulliView 2025, table 5.1: the new version, and the one before it, on a Core i7-1360P."""

_MAIN_COUNT = 4


@dataclass(frozen=True, slots=True)
class Plan:
    """How much is measured: vehicle counts, blocks, each method's frames per camera in a block by resolution, seconds of each
    sustained run, and who runs sustained."""

    counts: tuple[int, ...]
    blocks: int
    frames: dict[str, dict[str, int]]
    seconds: float
    sustained: tuple[str, ...]


FULL = Plan(
    VEHICLE_COUNTS,
    5,
    {
        "fullhd": {"ours": 120, "gulliview2025": 48, "gulliview2024": 32, "gulliview2023": 8},
        "uhd": {"ours": 60, "gulliview2025": 8, "gulliview2024": 8, "gulliview2023": 2},
    },
    6.0,
    ("ours", "gulliview2025", "gulliview2024", "gulliview2023"),
)
QUICK = Plan(
    (_MAIN_COUNT,),
    3,
    {
        "fullhd": {"ours": 120, "gulliview2025": 48, "gulliview2024": 16, "gulliview2023": 1},
        "uhd": {"ours": 30, "gulliview2025": 8},
    },
    2.0,
    ("ours",),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--quick", action="store_true", help="four vehicles only and fewer frames, in about a minute")
    parser.add_argument("--seed", type=int, default=1, help="of floor, noise and lenses (default: 1)")


def run(arguments: argparse.Namespace) -> Result:
    plan = QUICK if arguments.quick else FULL
    _, lab = read_lab(DEFAULT_LAB)
    found = measure(lab, plan, tuple(RESOLUTIONS), int(arguments.seed))
    settings = {
        "lab": lab.name,
        "cameras": len(lab.cameras),
        "rate_hz": RATE_HZ,
        "quick": bool(arguments.quick),
        "seed": arguments.seed,
        "jpeg_quality": JPEG_QUALITY,
        "loop_frames": LOOP_FRAMES,
        "blocks": plan.blocks,
        "frames_per_camera_and_block": plan.frames,
        "full_search_every": PUBLISHED_K,
        "cores": os.cpu_count(),
    }
    return Result("localization", found, {key: PUBLISHED[key] for key in found if key in PUBLISHED}, settings)


def measure(lab: Lab, plan: Plan, resolutions: Sequence[str], seed: int) -> dict[str, float]:
    """All figures of these resolutions. LauncherError when a process ends early."""
    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory(prefix="lilliput-bench-") as folder:
        for resolution in resolutions:
            labs = {count: bench_lab(lab, resolution, count) for count in plan.counts}
            with _timed(f"{resolution}: rendering"):
                files = _rendered(labs, Path(folder), seed)
            for count, room in labs.items():
                with _timed(f"{resolution}: following {count}"):
                    found |= _followed(room, files[count], resolution, count, plan)
            with _timed(f"{resolution}: sustained"):
                found |= _sustained(labs[_MAIN_COUNT], files[_MAIN_COUNT], resolution, plan)
    return found | ratios(found)


def ratios(found: dict[str, float]) -> dict[str, float]:
    """Baselines relative to ours (more than 1: ours is faster), and 4K relative to Full HD."""
    result: dict[str, float] = {}
    for key, value in found.items():
        for figure in ("median", "p99"):
            case, _, method = key.removesuffix(f"_{figure}_ms").rpartition("_")
            ours = found.get(f"{case}_follow_{figure}_ms")
            if key.endswith(f"_gulliview{method[-4:]}_{figure}_ms") and ours:
                result[f"{case}_{method}_{figure}_ratio"] = value / ours
    for figure in ("median", "p99"):
        fullhd, uhd = (found.get(f"{resolution}_{_MAIN_COUNT}_follow_{figure}_ms") for resolution in ("fullhd", "uhd"))
        if fullhd and uhd:
            result["uhd_4_ratio" if figure == "median" else "uhd_4_p99_ratio"] = uhd / fullhd
    return result


def _rendered(labs: dict[int, Lab], folder: Path, seed: int) -> dict[int, list[Path]]:
    """A file for each camera by number of vehicles, rendered on all cores."""
    rooms = list(labs.values())
    cameras = [camera.id for camera in rooms[0].cameras]
    files = {count: [folder / f"{count}-{camera}" for camera in cameras] for count in labs}
    with ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn")) as pool:
        waiting = [
            pool.submit(record, rooms, camera, None, seed, [files[count][index] for count in labs])
            for index, camera in enumerate(cameras)
        ]
        for done in as_completed(waiting):
            done.result()
    return files


def _followed(lab: Lab, files: Sequence[Path], resolution: str, count: int, plan: Plan) -> dict[str, float]:
    recordings = [read_recording(file) for file in files]
    known = methods(resolution)
    frames = plan.frames[resolution]
    played = follow([Run(known[name], lab, recordings) for name in frames], frames, plan.blocks)
    return {
        f"{resolution}_{count}_{'follow' if name == 'ours' else name}_{key}": value
        for name, blocks in played.items()
        for key, value in figures(blocks).items()
    }


def _sustained(lab: Lab, files: Sequence[Path], resolution: str, plan: Plan) -> dict[str, float]:
    result: dict[str, float] = {}
    for name in plan.sustained:
        for with_decode in (False, True):
            prefix = f"{resolution}_cameras" if name == "ours" else f"{resolution}_{_MAIN_COUNT}_{name}"
            key = f"{prefix}_sustained_{'jpeg_' if with_decode else ''}fps"
            try:
                rate = sustained(lab, files, resolution, name, with_decode=with_decode, seconds=plan.seconds)
            except SustainedError as error:
                raise LauncherError(f"{error}; is there enough memory for the frames?") from error
            result[key] = rate.fps
            if rate.pose_share is not None:
                result[key.replace("_fps", "_pose_share")] = rate.pose_share
    return result


@contextmanager
def _timed(what: str) -> Generator[None]:
    began_s = time.perf_counter()
    yield
    progress(f"{what} ({time.perf_counter() - began_s:.0f} s)")
