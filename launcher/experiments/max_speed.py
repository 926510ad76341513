"""The fastest tag that one camera follows without losing it in a single frame, at 60 Hz with 4 ms of motion blur."""

import argparse
import math
import multiprocessing
import statistics
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass

import cv2
import numpy as np

from geometry import SE2
from lab.rendering import CameraRenderer
from lab.snapshot import Snapshot, VehicleSnapshot
from launcher.errors import LauncherError, UsageError
from launcher.experiments.cameras import RESOLUTIONS, FrameClock, with_cameras
from launcher.experiments.crossings import ACCELERATION_MPS2, Crossing, crossings
from launcher.experiments.visibility import TagVisibility
from launcher.lab_file import add_lab_file_argument, read_lab
from launcher.output import Result, progress
from localization.pipeline import CameraPipeline
from localization.tracking import Tracker
from protocol.frames import Frame
from protocol.lab import Lab, Limits
from protocol.messages import TrackedPose

RATE_HZ = 60.0
EXPOSURE_S = 0.004
SIZES_MM = (200, 100, 50)
STEP_MPS = 0.5
FASTEST_MPS = 8.0
PUBLISHED = {
    "fullhd_100mm_max_mps": 0.88,
    "uhd_200mm_max_mps": 0.61,
    "uhd_100mm_max_mps": 0.60,
    "uhd_50mm_max_mps": 0.33,
}
"""The better of 2023 and 2024 (GulliView 2024, tables 5.1 and 5.2). In Full HD 200 mm had no limit up to the robot's 0.85 m/s and
50 mm were not seen."""

_TAG_YAWS = (0.0, math.radians(25.0), math.radians(45.0))
"""How the tags lie on their vehicles: the blur runs along their sides, along their diagonals, and between."""
_LEAD_FRAMES = 20
_PAUSE_S = 3.0
_MOST_CALIBRATION_FRAMES = 200
_POSES_EVERY = 2
"""A camera reads the tracks at 30 Hz (`localization.pose_feed`), so every second frame."""
_ATTEMPTS = 3
"""A whole round of the search takes many frames for small tags; a tag that it came too late for drives by again."""
_WRONG_M = 0.05
"""A pose this far off is not of this tag."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """One crossing: frames in which the whole tag was visible, how many of them went by before it was found (all, when it
    never was), and in how many it was lost afterwards; counting ends at the first loss."""

    visible: int
    unseen: int
    lost: int

    @property
    def followed(self) -> bool:
        """Found in the first half of its way, and never lost from then on."""
        return self.lost == 0 and 2 * self.unseen <= self.visible


@dataclass(frozen=True, slots=True)
class Fastest:
    """The highest speed that passed, and after how many seconds in view tags were found at it and below (the whole time in view,
    when they never were), for those that drove in from outside."""

    speed_mps: float
    first_seen_s: tuple[float, ...]


class SpeedTest:
    """One calibrated camera, watching. LauncherError when it does not find its place."""

    def __init__(self, lab: Lab, camera_id: str, seed: int) -> None:
        self._lab, self._seed = lab, seed
        self._renderer = CameraRenderer(lab, camera_id, seed)
        self._visibility = TagVisibility(lab, camera_id, seed)
        self._clock = FrameClock()
        self._pipeline = CameraPipeline(lab, camera_id, clock=self._clock)
        self._tracker = Tracker(lab)
        self._frames = 0
        while self._pipeline.extrinsics is None:
            self._look(None, {})
            if self._frames > _MOST_CALIBRATION_FRAMES:
                raise LauncherError(f"camera {camera_id}: {self._pipeline.problem or 'not calibrated'}")

    def run(self, crossing: Crossing, speed_mps: float) -> Outcome:
        """Drives once through the view; up to the frame in which the tag is lost."""
        self._clock.stamp_ns += round(_PAUSE_S * 1e9)
        told: dict[str, TrackedPose] = {}
        newest: dict[str, TrackedPose] = {}
        visible = unseen = 0
        for seen, vehicle in self._in_view(crossing, speed_mps):
            if self._frames % _POSES_EVERY == 0:
                told = dict(newest)
            poses = self._look(vehicle, told)
            newest.update(poses)
            if not seen:
                continue
            visible += 1
            found = poses.get(vehicle.id)
            if found is not None and math.hypot(found.x - vehicle.x, found.y - vehicle.y) <= _WRONG_M:
                continue
            if visible > unseen + 1:
                return Outcome(visible, unseen, 1)
            unseen += 1
        return Outcome(visible, unseen, 0)

    def _in_view(self, crossing: Crossing, speed_mps: float) -> Iterator[tuple[bool, VehicleSnapshot]]:
        """The frames worth rendering, each with whether the whole tag is visible."""
        drive = list(crossing.drive(speed_mps, RATE_HZ))
        seen = [index for index, at in enumerate(drive) if self._visibility.sees(at.id, SE2(at.x, at.y, at.yaw))]
        if not seen:
            raise LauncherError(f"{crossing} does not lead through the camera's view")
        for index in range(max(0, seen[0] - _LEAD_FRAMES), seen[-1] + 1):
            yield seen[0] <= index, drive[index]

    def _look(self, vehicle: VehicleSnapshot | None, told: dict[str, TrackedPose]) -> dict[str, TrackedPose]:
        """The next frame; the poses that came of it."""
        self._frames += 1
        self._clock.stamp_ns += round(1e9 / RATE_HZ)
        stamp_ns = self._clock.stamp_ns
        snapshot = Snapshot(stamp_ns, () if vehicle is None else (vehicle,), ())
        frame = Frame(self._frames, stamp_ns, self._renderer.render(snapshot, self._frames))
        updated = self._tracker.update(self._pipeline.process(frame, told))
        return {pose.vehicle: pose for pose in updated if pose.stamp_ns == stamp_ns}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_file_argument(parser)
    parser.add_argument("--camera", help="whose view is driven through (default: the lab's first)")
    parser.add_argument("--seeds", type=int, default=2, help="of noise, floor, lens and lines (default: 2)")
    parser.add_argument("--resolution", choices=sorted(RESOLUTIONS), help="only this one (default: all)")


def run(arguments: argparse.Namespace) -> Result:
    path, lab = read_lab(arguments.lab)
    camera_id = arguments.camera or next((camera.id for camera in lab.cameras), None)
    if camera_id is None or camera_id not in lab.simulation.mounts:
        raise UsageError(f"{path} has no simulated camera {camera_id or ''}".rstrip())
    if not lab.vehicles:
        raise UsageError(f"{path} has no vehicle that could wear the tag")
    if not 1 <= arguments.seeds <= 100:
        raise UsageError(f"--seeds must be 1 to 100, not {arguments.seeds}")
    seeds = tuple(range(lab.simulation.seed, lab.simulation.seed + arguments.seeds))
    resolutions = [arguments.resolution] if arguments.resolution else list(RESOLUTIONS)
    cases = [(resolution, size) for resolution in resolutions for size in SIZES_MM]
    found: dict[tuple[str, int], Fastest] = {}
    with ProcessPoolExecutor(max_workers=2, mp_context=multiprocessing.get_context("spawn")) as pool:
        # The large pictures first: they take the longest.
        waiting = {pool.submit(fastest, lab, camera_id, *case, seeds): case for case in reversed(cases)}
        for done in as_completed(waiting):
            case = waiting[done]
            found[case] = done.result()
            progress(f"{case[0]}, {case[1]} mm: {found[case].speed_mps:g} m/s ({len(found)} of {len(cases)})")
    figures: dict[str, float] = {}
    for resolution, size in cases:
        figures[f"{resolution}_{size}mm_max_mps"] = found[resolution, size].speed_mps
        if seen_s := found[resolution, size].first_seen_s:
            figures[f"{resolution}_{size}mm_first_seen_median_ms"] = statistics.median(seen_s) * 1e3
            figures[f"{resolution}_{size}mm_first_seen_max_ms"] = max(seen_s) * 1e3
    settings = {
        "lab": lab.name,
        "camera": camera_id,
        "seeds": list(seeds),
        "rate_hz": RATE_HZ,
        "exposure_ms": EXPOSURE_S * 1e3,
        "step_mps": STEP_MPS,
        "fastest_tried_mps": FASTEST_MPS,
    }
    return Result("max-speed", figures, {key: PUBLISHED[key] for key in figures if key in PUBLISHED}, settings)


def fastest(lab: Lab, camera_id: str, resolution: str, size_mm: int, seeds: Sequence[int]) -> Fastest:
    """The highest of the speeds k * STEP_MPS up to FASTEST_MPS at which every crossing of every seed is followed, by bisection;
    0 when not even the lowest is. As in the report, a speed that is followed vouches for all below."""
    cv2.setNumThreads(1)
    room = speed_lab(lab, camera_id, resolution, size_mm)
    tests = [(SpeedTest(room, camera_id, seed), drives(room, camera_id, seed)) for seed in seeds]
    first_seen_s: list[float] = []
    passed, failed = 0, round(FASTEST_MPS / STEP_MPS) + 1
    while failed - passed > 1:
        middle = (passed + failed) // 2
        seen_s = _first_seen(tests, middle * STEP_MPS)
        if seen_s is None:
            failed = middle
        else:
            passed = middle
            first_seen_s += seen_s
    return Fastest(passed * STEP_MPS, tuple(first_seen_s))


def _first_seen(tests: Sequence[tuple[SpeedTest, list[Crossing]]], speed_mps: float) -> list[float] | None:
    """After how many seconds in view the tags that drove in were found; None as soon as one was not followed."""
    seen_s: list[float] = []
    for test, lines in tests:
        for line in lines:
            outcomes = _drives_by(test, line, speed_mps)
            if not outcomes[-1].followed:
                return None
            if line.acceleration_mps2 is None:
                seen_s += [outcome.unseen / RATE_HZ for outcome in outcomes]
    return seen_s


def _drives_by(test: SpeedTest, crossing: Crossing, speed_mps: float) -> list[Outcome]:
    """What came of each drive, until the tag was followed or lost or has driven by often enough."""
    outcomes = [test.run(crossing, speed_mps)]
    while len(outcomes) < _ATTEMPTS and not outcomes[-1].followed and not outcomes[-1].lost:
        outcomes.append(test.run(crossing, speed_mps))
    return outcomes


def speed_lab(lab: Lab, camera_id: str, resolution: str, size_mm: int) -> Lab:
    """The lab with one camera, and three of its first vehicle that may be this fast, whose tags of that size lie at different
    angles."""
    resized = with_cameras(lab, resolution, RATE_HZ)
    first = lab.vehicles[0]
    limits = Limits(
        speed_mps=FASTEST_MPS,
        yaw_rate_radps=first.limits.yaw_rate_radps,
        acceleration_mps2=ACCELERATION_MPS2,
        braking_mps2=ACCELERATION_MPS2,
        yaw_acceleration_radps2=first.limits.yaw_acceleration_radps2,
    )
    vehicles = tuple(
        first.model_copy(
            update={
                "id": f"fast-{index}",
                "driver": "sim",
                "limits": limits,
                "tag": first.tag.model_copy(
                    update={"id": first.tag.id + index, "size_m": size_mm / 1e3, "offset": (0.0, 0.0, yaw)}
                ),
            }
        )
        for index, yaw in enumerate(_TAG_YAWS)
    )
    simulation = lab.simulation.model_copy(
        update={
            "mounts": {camera_id: lab.simulation.mounts[camera_id]},
            "starts": {},
            "tours": {},
            "image": lab.simulation.image.model_copy(update={"exposure_s": EXPOSURE_S}),
        }
    )
    return resized.model_copy(
        update={"cameras": (resized.camera(camera_id),), "vehicles": vehicles, "simulation": simulation}
    )


def drives(lab: Lab, camera_id: str, seed: int) -> list[Crossing]:
    """The crossings of that seed through the camera's view at the height of the tags."""
    mount, model = lab.simulation.mounts[camera_id], lab.camera(camera_id).model()
    drop_m = mount.position[2] - lab.vehicles[0].tag.height_m
    along, across = model.width / 2 / model.fx * drop_m, model.height / 2 / model.fy * drop_m
    c, s = abs(math.cos(mount.yaw)), abs(math.sin(mount.yaw))
    half_size_m = (c * along + s * across, s * along + c * across)
    return crossings(
        tuple(vehicle.id for vehicle in lab.vehicles),
        (mount.position[0], mount.position[1]),
        half_size_m,
        np.random.default_rng([seed, 7]),
    )
