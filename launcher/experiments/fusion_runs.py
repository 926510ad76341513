"""What fusion is tried on: a robot's odometry with the truth beside it, from the simulated lab or from recorded files."""

import gzip
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from agents.drivers import OdometryReading
from agents.motion import Twist
from geometry import SE2
from lab.world import World
from launcher.errors import UsageError
from launcher.experiments.courses import CourseFollower, infinity
from protocol.lab import Lab

Array = NDArray[np.float64]

_TRUTH_GAP_S = 0.1
"""Between samples of the truth that lie further apart nothing is judged."""
_ODOMETRY_EVERY = 2
"""Steps of the simulated world (10 ms) per reading: a base reports at 50 Hz."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """`odometry` in order; `seconds` (N,) since `start_ns` and `poses` (N, 3), x, y (m) and unwrapped yaw (rad) of the truth."""

    name: str
    start_ns: int
    odometry: tuple[OdometryReading, ...]
    seconds: Array
    poses: Array

    @property
    def duration_s(self) -> float:
        """As long as there are both odometry and truth."""
        return min(float(self.seconds[-1]), (self.odometry[-1].stamp_ns - self.start_ns) / 1e9)

    def truth(self, seconds: Array) -> Array:
        """The true poses (M, 3) at these times (M,), NaN where the truth has a gap or no more."""
        poses = np.column_stack([np.interp(seconds, self.seconds, self.poses[:, axis]) for axis in range(3)])
        after = np.clip(np.searchsorted(self.seconds, seconds), 1, len(self.seconds) - 1)
        gap = self.seconds[after] - self.seconds[after - 1] > _TRUTH_GAP_S
        poses[gap | (seconds < self.seconds[0]) | (seconds > self.seconds[-1])] = np.nan
        return poses


def simulated(lab: Lab, speed_mps: float, seed: int, seconds: float) -> Run:
    """The lab's first simulated vehicle on the infinity course, steered by the truth, on the wheels that the lab describes. Its
    limits are raised where the speed needs it; odometry is what its base reports."""
    first = next((vehicle for vehicle in lab.vehicles if vehicle.driver == "sim"), None)
    if first is None:
        raise UsageError(f"lab {lab.name!r} has no simulated vehicle")
    limits = first.limits.model_copy(
        update={"speed_mps": max(first.limits.speed_mps, 1.1 * speed_mps), "yaw_rate_radps": 4.0}
    )
    alone = lab.model_copy(update={"vehicles": (first.model_copy(update={"limits": limits}),)})
    world = World(alone, seed)
    min_x, min_y, max_x, max_y = lab.bounds()
    center = ((min_x + max_x) / 2.0, (min_y + max_y) / 2.0)
    course = infinity(center, 0.4 * (max_x - min_x), 0.3 * (max_y - min_y))
    way = float(np.random.default_rng(seed).uniform(0.0, course.length_m))
    world.place(first.id, SE2(*course.at(way)))
    follower = CourseFollower(course, way, speed_mps)
    start_ns = world.stamp_ns
    odometry: list[OdometryReading] = []
    truth: list[tuple[float, float, float, float]] = []
    for step in range(round(seconds / world.step_s) + 1):
        pose = world.truth().vehicles[first.id]
        truth.append(((world.stamp_ns - start_ns) / 1e9, pose.x, pose.y, pose.yaw))
        if step % _ODOMETRY_EVERY == 0:
            said = world.odometry(first.id)
            twist = Twist(said.linear_mps, said.angular_radps)
            odometry.append(OdometryReading(said.stamp_ns, said.session, SE2(said.x, said.y, said.yaw), twist))
        world.set_drive(first.id, *follower.twist(pose))
        world.step()
    table = np.array(truth)
    table[:, 3] = np.unwrap(table[:, 3])
    return Run(f"simulated {speed_mps} m/s, seed {seed}", start_ns, tuple(odometry), table[:, 0], table[:, 1:])


@dataclass(frozen=True, slots=True)
class Recording:
    """A recorded run: files of odometry and of the truth."""

    name: str
    odometry: Path
    truth: Path

    def load(self) -> Run:
        """UsageError when the files are not of that kind."""
        return _joined(self.name, _table(self.odometry, 3), _table(self.truth, 4))


def recordings(folder: Path) -> list[Recording]:
    """The runs of the UTIAS multi-robot data set (Leung et al. 2011) in a folder and those in it: each `*_Odometry.dat` with
    its `*_Groundtruth.dat`, compressed or not. UsageError when there is none."""
    found = sorted(path for path in folder.rglob("*_Odometry.dat*") if path.name.endswith((".dat", ".dat.gz")))
    if not found:
        raise UsageError(f"no RobotN_Odometry.dat or .dat.gz in {folder}")
    return [
        Recording(
            str(path.relative_to(folder)).split("_Odometry")[0],
            path,
            _either(path.with_name(path.name.replace("_Odometry", "_Groundtruth"))),
        )
        for path in found
    ]


def _either(path: Path) -> Path:
    """The file, or its twin that is compressed, or not. UsageError when there is neither."""
    twin = path.with_suffix("") if path.suffix == ".gz" else path.with_name(path.name + ".gz")
    for candidate in (path, twin):
        if candidate.is_file():
            return candidate
    raise UsageError(f"odometry without truth: {path} is missing")


def _table(path: Path, columns: int) -> Array:
    """The numbers of a file (N, columns), in the order of their times; lines that repeat a time are left out."""
    try:
        with (gzip.open if path.suffix == ".gz" else open)(path, "rt") as file:
            table = np.loadtxt(file, comments="#", ndmin=2)
    except (OSError, ValueError) as error:
        raise UsageError(f"cannot read {path}: {error}") from error
    if table.shape[1] != columns or len(table) < 2 or not np.isfinite(table).all():
        raise UsageError(f"{path} does not have lines of {columns} numbers")
    table = table[np.argsort(table[:, 0], kind="stable")]
    return table[np.concatenate([[True], np.diff(table[:, 0]) > 0.0])]


def _joined(name: str, odometry: Array, truth: Array) -> Run:
    """The velocities, each held until the next, become the pose that a base would report. The run begins when both have begun."""
    start_s = max(odometry[0, 0], truth[0, 0])
    odometry, truth = odometry[odometry[:, 0] >= start_s], truth[truth[:, 0] >= start_s - _TRUTH_GAP_S]
    if len(odometry) < 2 or len(truth) < 2:
        raise UsageError(f"{name}: odometry and truth are of different times")
    start_ns = round(start_s * 1e9)
    pose, readings = SE2.identity(), list[OdometryReading]()
    before_s, linear, angular = odometry[0]
    for stamp_s, next_linear, next_angular in odometry:
        held_s = stamp_s - before_s
        pose = pose @ SE2.exp(held_s * linear, 0.0, held_s * angular)
        before_s, linear, angular = stamp_s, next_linear, next_angular
        readings.append(
            OdometryReading(round(stamp_s * 1e9), name, pose, Twist(float(next_linear), float(next_angular)))
        )
    poses = truth[:, 1:].copy()
    poses[:, 2] = np.unwrap(poses[:, 2])
    return Run(name, start_ns, tuple(readings), truth[:, 0] - start_s, poses)
