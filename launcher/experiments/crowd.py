"""Thirty vehicles at once: whether every tag in view gives its pose, whether any is lost, how fast frames are worked off."""

import argparse

from launcher.errors import LauncherError, UsageError
from launcher.experiments.crowd_drive import CrowdDrive, drive_crowd
from launcher.experiments.crowd_rate import measure_rate
from launcher.experiments.rooms import surveyed_as_described
from launcher.lab_file import add_lab_file_argument, read_lab
from launcher.output import Result, progress

VEHICLES = 30


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_file_argument(parser)
    parser.add_argument("--vehicles", type=int, default=VEHICLES, help=f"how many (default: {VEHICLES})")
    parser.add_argument("--seconds", type=float, default=10.0, help="how long to drive (default: 10)")
    parser.add_argument("--seed", type=int, default=1, help="of the room and its noise (default: 1)")
    parser.add_argument(
        "--frames", type=int, default=45, help="frames of each camera to take the time of (default: 45)"
    )


def run(arguments: argparse.Namespace) -> Result:
    path, lab = read_lab(arguments.lab)
    count = arguments.vehicles
    if not 1 <= count <= 60:
        raise UsageError(f"--vehicles must be from 1 to 60, not {count}: more would not have room")
    if not 0 < arguments.seconds <= 600:
        raise UsageError(f"--seconds must be more than 0 and at most 600, not {arguments.seconds:g}")
    if not 5 <= arguments.frames <= 200:
        raise UsageError(f"--frames must be from 5 to 200, not {arguments.frames}: they are all kept in memory")
    if not lab.cameras or any(camera.id not in lab.simulation.mounts for camera in lab.cameras):
        raise UsageError(f"{path} has no simulated cameras to watch a crowd with")
    if not lab.vehicles:
        raise UsageError(f"{path} has no vehicle to make a crowd after")
    drive = drive_crowd(surveyed_as_described(lab), arguments.seed, count, arguments.seconds)
    if not drive.visible_tags:
        raise LauncherError("no camera saw a whole tag; drive for longer, or look at the cameras' places")
    progress("timing")
    rate = measure_rate(drive, arguments.frames)
    prefix = f"crowd_{count}"
    figures = {
        f"{prefix}_pose_share": drive.found_tags / drive.visible_tags,
        f"{prefix}_vehicles_lost": drive.lost,
        f"{prefix}_camera_rate_hz": rate.camera_rate_hz,
        f"{prefix}_frame_median_ms": rate.frame_median_ms,
        f"{prefix}_frame_p99_ms": rate.frame_p99_ms,
        f"{prefix}_track_median_ms": rate.track_median_ms,
        f"{prefix}_position_error_median_mm": drive.error_median_mm,
        f"{prefix}_position_error_max_mm": drive.error_max_mm,
        "visible_tags": drive.visible_tags,
        "tags_in_view_mean": drive.visible_tags / len(drive.looks),
    }
    return Result("crowd", figures, settings=_settings(arguments, drive))


def _settings(arguments: argparse.Namespace, drive: CrowdDrive) -> dict[str, object]:
    lab = drive.room.lab
    return {
        "lab": lab.name,
        "cameras": len(lab.cameras),
        "width": lab.cameras[0].width,
        "height": lab.cameras[0].height,
        "seconds": arguments.seconds,
        "seed": arguments.seed,
        "timed_frames": arguments.frames,
    }
