"""`./lilliput record OUT`: a recording of a simulated lab, or of cameras as they run (docs/recordings.md)."""

import argparse
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from launcher.errors import LauncherError, UsageError
from launcher.lab_file import add_lab_arguments, read_lab, state_folder
from launcher.output import Result, print_result, progress
from launcher.progress_bar import ProgressBar
from launcher.recorder.folder import RecordingFolder
from launcher.recorder.live import record_live
from launcher.recorder.simulated import record_simulated
from protocol.clock import SystemClock
from protocol.lab import Lab

_PROGRESS_STEPS = 1000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("out", type=Path, metavar="OUT", help="folder for the recording; must be empty or not exist")
    add_lab_arguments(parser)
    parser.add_argument("--seconds", type=float, default=10.0, help="how long (default: 10)")
    parser.add_argument("--cameras", metavar="IDS", help="camera ids separated by commas (default: all)")
    parser.add_argument("--format", choices=("jpg", "png"), default="jpg", help="of the pictures (default: jpg)")
    parser.add_argument("--quality", type=int, default=90, help="of JPEG, 1 to 100 (default: 90)")
    parser.add_argument(
        "--live", action="store_true", help="record what runs now, simulated cameras too, instead of rendering"
    )
    parser.add_argument("--rate-hz", type=float, help="rendered frames per second and camera (default: the lab file's)")
    parser.add_argument("--seed", type=int, help="of the rendered lab (default: the lab file's)")
    parser.add_argument(
        "--without-simulation",
        action="store_true",
        help="leave the lab file's section `simulation` out of the recording",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(arguments: argparse.Namespace) -> int:
    path, lab = read_lab(arguments.lab)
    if not 0 < arguments.seconds <= 86400:
        raise UsageError(f"--seconds must be more than 0 and at most 86400, not {arguments.seconds:g}")
    if arguments.rate_hz is not None and not 0 < arguments.rate_hz <= 1000:
        raise UsageError(f"--rate-hz must be more than 0 and at most 1000, not {arguments.rate_hz:g}")
    if not 1 <= arguments.quality <= 100:
        raise UsageError(f"--quality must be from 1 to 100, not {arguments.quality}")
    cameras = _chosen(arguments.cameras, lab, path)
    live = arguments.live or any(lab.camera(camera).source != "sim" for camera in cameras)
    if live and (arguments.rate_hz is not None or arguments.seed is not None):
        raise UsageError("--rate-hz and --seed are for rendered recordings; running cameras have rates of their own")
    folder = RecordingFolder(arguments.out, cameras, arguments.format, arguments.quality)
    try:
        if arguments.without_simulation:
            folder.write_lab_without_simulation(lab)
        else:
            folder.write_lab(path.read_text(encoding="utf-8"))
        figures = _live(arguments, lab, cameras, folder) if live else _rendered(arguments, lab, cameras, folder)
    except BaseException:
        if not folder.frames.total():  # else the next attempt would find a folder that is not empty
            folder.discard()
        raise
    settings = {
        "recording": str(arguments.out),
        "lab": str(path),
        "cameras": cameras,
        "live": live,
        "format": arguments.format,
        "quality": arguments.quality if arguments.format == "jpg" else None,
        "seed": None if live else lab.simulation.seed if arguments.seed is None else arguments.seed,
    }
    counts = {f"{camera.replace('-', '_')}_frames": folder.frames[camera] for camera in cameras}
    result = Result("record", {"frames": folder.frames.total(), **counts, **figures}, settings=settings)
    print_result(result, as_json=arguments.json)
    return 0


def _chosen(given: str | None, lab: Lab, path: Path) -> list[str]:
    known = [camera.id for camera in lab.cameras]
    chosen = known if given is None else [name.strip() for name in given.split(",") if name.strip()]
    unknown = [name for name in chosen if name not in known]
    if unknown or not chosen:
        raise UsageError(f"{path} has no camera {', '.join(unknown)}; there are {', '.join(known) or 'none'}")
    return list(dict.fromkeys(chosen))


def _rendered(arguments: argparse.Namespace, lab: Lab, cameras: list[str], folder: RecordingFolder) -> dict[str, Any]:
    bar = ProgressBar("rendering", _PROGRESS_STEPS)
    with ThreadPoolExecutor(os.cpu_count() or 1) as executor:
        truth = record_simulated(
            lab,
            cameras,
            folder,
            executor,
            seconds=arguments.seconds,
            rate_hz=arguments.rate_hz,
            seed=arguments.seed,
            on_progress=lambda share: bar.show(round(share * _PROGRESS_STEPS)),
        )
    bar.end()
    folder.write_truth(truth)
    return {"recorded_s": arguments.seconds, "truth_rows": len(truth)}


def _live(arguments: argparse.Namespace, lab: Lab, cameras: list[str], folder: RecordingFolder) -> dict[str, Any]:
    bar = ProgressBar("recording", _PROGRESS_STEPS)
    counts = record_live(
        [lab.camera(camera) for camera in cameras],
        state_folder(arguments.state, lab),
        folder,
        SystemClock(),
        seconds=arguments.seconds,
        on_progress=lambda share: bar.show(round(share * _PROGRESS_STEPS)),
    )
    bar.end()
    for camera, count in counts.items():
        if count.error is not None:
            progress(f"warning: {camera}: {count.error}")
    if not folder.frames.total():
        raise LauncherError(
            "no camera gave a frame; is the system running (./lilliput up), are the cameras plugged in?"
        )
    return {
        "recorded_s": arguments.seconds,
        "skipped": sum(count.skipped for count in counts.values()),
        "broken": sum(count.broken for count in counts.values()),
    }
