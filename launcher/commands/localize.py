"""`./lilliput localize RECORDING`: recorded cameras in, poses out (docs/recordings.md)."""

import argparse
import os
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from launcher.errors import LauncherError, UsageError
from launcher.lab_file import read_lab
from launcher.output import Result, print_result, progress
from launcher.progress_bar import ProgressBar
from localization.offline import (
    LAB_FILE,
    POSES_FILE,
    Localization,
    NotCalibratedError,
    OfflineError,
    Recording,
    ResultsFolder,
    TrajectoryWriter,
    calibrated,
    calibration_text,
    look_at_floors,
    open_recording,
    read_calibration,
    trajectory_file,
)
from localization.tags import KnownTags
from protocol.lab import Lab
from protocol.messages import Calibration, TrackedPose

_CALIBRATION_FILE = "calibration.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="folder with a video or pictures per camera")
    parser.add_argument("--lab", type=Path, metavar="FILE", help="lab description (default: RECORDING/lab.yaml)")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="write poses.csv, a .tum file per vehicle and more there"
    )
    parser.add_argument("--calibration", type=Path, metavar="FILE", help="calibration.json of an earlier run")
    parser.add_argument(
        "--full-search-every", type=int, metavar="K", help="full search every K-th frame (default: 15 times a second)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(arguments: argparse.Namespace) -> int:
    if arguments.full_search_every is not None and arguments.full_search_every < 1:
        raise UsageError(f"--full-search-every must be at least 1, not {arguments.full_search_every}")
    if not arguments.recording.exists():
        raise UsageError(f"{arguments.recording} does not exist")
    lab_file, lab = _lab_of(arguments)
    try:
        result = _localize(arguments, lab_file, lab)
    except NotCalibratedError as error:
        raise LauncherError(str(error)) from error
    except OfflineError as error:
        raise UsageError(str(error)) from error
    print_result(result, as_json=arguments.json)
    return 0


def _lab_of(arguments: argparse.Namespace) -> tuple[Path, Lab]:
    """The lab file given or the recording's own; it must say what to look for."""
    own: Path = arguments.recording / LAB_FILE
    if arguments.lab is None and not own.is_file():
        raise UsageError(f"{arguments.recording} has no {LAB_FILE}: say with --lab FILE which lab was recorded")
    path, lab = read_lab(arguments.lab or own, recorded=True)
    if not lab.floor_tags.poses:
        raise UsageError(f"{path} describes no floor tags; without them no camera knows where it hangs")
    if not lab.vehicles:
        raise UsageError(f"{path} describes no vehicles to look for")
    return path, lab


def _localize(arguments: argparse.Namespace, lab_file: Path, lab: Lab) -> Result:
    started_s = time.monotonic()
    recording = open_recording(arguments.recording, lab)
    warnings = list(recording.warnings)
    given = None if arguments.calibration is None else read_calibration(arguments.calibration, lab)
    with ExitStack() as stack:
        folder = writer = None
        if arguments.out is not None:
            names = [POSES_FILE, _CALIBRATION_FILE, *(trajectory_file(vehicle.id) for vehicle in lab.vehicles)]
            folder = stack.enter_context(ResultsFolder(arguments.out, names))
            writer = stack.enter_context(TrajectoryWriter(folder.draft))
        executor = stack.enter_context(ThreadPoolExecutor(os.cpu_count() or 1))
        calibration = given or _calibrate(lab, recording, executor, warnings)
        run = Localization(lab, recording, calibration, executor, arguments.full_search_every)
        uncalibrated = [c.spec.id for c in recording.cameras if given and c.spec.id not in given.cameras]
        warnings += [f"{camera} is not in {arguments.calibration} and gives no poses" for camera in uncalibrated]
        for poses in _with_progress(run):
            if writer is not None:
                writer.write(poses)
        figures = _figures(run, recording, calibration, time.monotonic() - started_s)
        warnings += [*run.statistics.warnings.values(), *_missing_vehicles(lab, run)]
        settings = {
            "recording": str(arguments.recording),
            "lab": str(lab_file),
            "calibration": str(arguments.calibration or "from the recording"),
            "full_search_every": run.full_search_every,
        }
        result = Result("localize", {**figures, "warnings": warnings}, settings=settings)
        for warning in warnings:
            progress(f"warning: {warning}")
        if folder is not None and writer is not None:
            writer.close()
            (folder.draft / _CALIBRATION_FILE).write_bytes(calibration_text(calibration))
            folder.commit({"figures": result.figures, "settings": result.settings})
    return result


def _calibrate(lab: Lab, recording: Recording, executor: Executor, warnings: list[str]) -> Calibration:
    progress(f"calibrating {len(recording.cameras)} cameras from the floor tags in the recording")
    looks = look_at_floors(recording.cameras, KnownTags.of(lab), executor)
    calibration, problems = calibrated(lab, looks)
    warnings += problems
    return calibration


def _with_progress(run: Localization) -> Iterator[list[TrackedPose]]:
    bar = ProgressBar("localizing", run.frames)
    for poses in run.poses():
        yield poses
        bar.show(run.statistics.frames.total())
    bar.end()


def _missing_vehicles(lab: Lab, run: Localization) -> list[str]:
    missing = [vehicle.id for vehicle in lab.vehicles if not run.statistics.poses[vehicle.id]]
    return [f"not seen at all: {', '.join(missing)}"] if missing else []


def _figures(run: Localization, recording: Recording, calibration: Calibration, took_s: float) -> dict[str, Any]:
    done = run.statistics
    frames, poses = done.frames.total(), done.poses.total()
    seconds = recording.seconds
    figures: dict[str, Any] = {
        "frames": frames,
        "broken_frames": done.broken.total(),
        "cameras": len(recording.cameras),
        "cameras_calibrated": len(calibration.cameras),
        "recorded_s": seconds,
        "vehicles": len(done.poses),
        "poses": poses,
        "poses_per_vehicle_hz": poses / len(done.poses) / seconds if done.poses and seconds > 0 else 0.0,
        "processing_s": took_s,
        "processing_per_frame_ms": took_s / frames * 1e3 if frames else 0.0,
        "floor_tag_shift_max_mm": max((p.shift_m for p in calibration.floor_tags.values()), default=0.0) * 1e3,
    }
    for camera in recording.cameras:
        name = camera.spec.id.replace("-", "_")
        figures[f"{name}_frames"] = done.frames[camera.spec.id]
        figures[f"{name}_detections"] = done.detections[camera.spec.id]
        found = calibration.cameras.get(camera.spec.id)
        if found is not None:
            figures[f"{name}_reprojection_px"] = found.reprojection_px
            figures[f"{name}_floor_tags"] = list(found.floor_tags)
    for vehicle, count in sorted(done.poses.items()):
        figures[f"{vehicle.replace('-', '_')}_poses"] = count
    return figures
