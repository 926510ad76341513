"""Poses all over the floor of one surveyed room, and while driving across it, with their true errors."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, angle_difference
from lab.snapshot import VehicleSnapshot
from launcher.experiments.fleets import with_fleet
from launcher.experiments.rooms import Room
from localization.pipeline import PipelineOptions
from localization.tag_pose import from_upper
from localization.tracking import Tracker
from protocol.lab import Lab
from protocol.messages import TrackedPose

Array = NDArray[np.float64]

_AT_ONCE = 14
"""Vehicles on the floor at the same time; more would stand in each other's way."""
_APART_M = 0.75
"""Nearer ones could hide each other's tags from a camera that looks at them aslant."""
_BETWEEN_S = 1.0
"""Longer than a track lives: what stands somewhere else now is found anew."""
_SPEED_MPS = 0.7
_LINES = 4


@dataclass(frozen=True, slots=True, eq=False)
class Placements:
    """N vehicles that stood somewhere: `places` (N, 2) in m; `visible` and `found` (N,), how many cameras saw the whole tag and
    how many of those gave its pose; `errors` (N, 3), tracked minus true x, y, yaw, NaN where nothing was tracked, `covariances`
    (N, 3, 3)."""

    places: Array
    visible: NDArray[np.int64]
    found: NDArray[np.int64]
    errors: Array
    covariances: Array

    @classmethod
    def joined(cls, parts: Sequence["Placements"]) -> "Placements":
        """All of them, one after another."""
        return cls(
            np.concatenate([part.places for part in parts]),
            np.concatenate([part.visible for part in parts]),
            np.concatenate([part.found for part in parts]),
            np.concatenate([part.errors for part in parts]),
            np.concatenate([part.covariances for part in parts]),
        )

    @property
    def tracked(self) -> NDArray[np.bool_]:
        return np.isfinite(self.errors[:, 0])


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """Vehicles that drove across all cameras' views: the greatest change of the error (m) from one pose to the next where other
    cameras had come to see the vehicle, how often that was, and the same over all poses."""

    jump_max_m: float
    handovers: int
    step_max_m: float


@dataclass(frozen=True, slots=True, eq=False)
class RoomSamples:
    """One room's."""

    seed: int
    placements: Placements
    drive: Drive | None


def sample_room(lab: Lab, seed: int, cell_m: float, *, drives: bool) -> RoomSamples:
    """A vehicle in every cell of a grid over the lab's bounds, its place in the cell and its heading by chance; with `drives`
    also vehicles on straight lines from end to end."""
    # Every frame is searched as a whole: what stands is somewhere else in each.
    standing = Room(with_fleet(lab, _AT_ONCE), seed, PipelineOptions(full_search_every=1))
    placements = _placements(standing, cell_m)
    return RoomSamples(seed, placements, _drive(Room(with_fleet(lab, _LINES), seed)) if drives else None)


def grid(lab: Lab, cell_m: float) -> tuple[Array, Array]:
    """The edges of the cells in x and y (m): the lab's bounds cut into cells of about that size."""
    min_x, min_y, max_x, max_y = lab.bounds()
    columns, rows = (max(1, round((high - low) / cell_m)) for low, high in ((min_x, max_x), (min_y, max_y)))
    return np.linspace(min_x, max_x, columns + 1), np.linspace(min_y, max_y, rows + 1)


def _placements(room: Room, cell_m: float) -> Placements:
    rng = np.random.default_rng([room.seed, 1])
    xs, ys = grid(room.lab, cell_m)
    corners = np.stack(np.meshgrid(xs[:-1], ys[:-1]), axis=-1).reshape(-1, 2)
    places = corners + rng.random(corners.shape) * (xs[1] - xs[0], ys[1] - ys[0])
    return Placements.joined([_shot(room, places[group], rng) for group in _groups(places, rng)])


def _groups(places: Array, rng: np.random.Generator) -> list[list[int]]:
    """Indices of places that vehicles can take at the same time, each place once."""
    waiting, groups = list(map(int, rng.permutation(len(places)))), list[list[int]]()
    while waiting:
        group: list[int] = []
        for index in waiting:
            if len(group) < _AT_ONCE and all(math.dist(places[index], places[other]) >= _APART_M for other in group):
                group.append(index)
        waiting = [index for index in waiting if index not in group]
        groups.append(group)
    return groups


def _shot(room: Room, places: Array, rng: np.random.Generator) -> Placements:
    """Vehicles at these places, seen once by every camera."""
    room.clock.wait(_BETWEEN_S)
    wearers = rng.permutation(len(room.lab.vehicles))[: len(places)]
    vehicles = [room.lab.vehicles[int(index)] for index in wearers]
    poses = [SE2(float(x), float(y), float(rng.uniform(-math.pi, math.pi))) for x, y in places]
    snapshots = [
        VehicleSnapshot(vehicle.id, pose.x, pose.y, pose.yaw, 0.0, 0.0)
        for vehicle, pose in zip(vehicles, poses, strict=True)
    ]
    tracker, tracked = Tracker(room.lab), dict[str, TrackedPose]()
    visible, found = np.zeros(len(poses), dtype=np.int64), np.zeros(len(poses), dtype=np.int64)
    for camera in room.cameras:
        seen = room.look(camera, snapshots, {})
        ids = {detection.tag_id for detection in seen.detections}
        for index, (vehicle, pose) in enumerate(zip(vehicles, poses, strict=True)):
            if camera.visibility.sees(vehicle.id, pose):
                visible[index] += 1
                found[index] += vehicle.tag.id in ids
        tracked.update({pose.vehicle: pose for pose in tracker.update(seen)})
    errors, covariances = np.full((len(poses), 3), np.nan), np.full((len(poses), 3, 3), np.nan)
    for index, (vehicle, pose) in enumerate(zip(vehicles, poses, strict=True)):
        if vehicle.id in tracked:
            errors[index] = _error(tracked[vehicle.id], pose)
            covariances[index] = from_upper(tracked[vehicle.id].covariance)
    return Placements(places, visible, found, errors, covariances)


def _drive(room: Room) -> Drive:
    """Every vehicle on a line of its own along the room's longer side, cameras taking turns as free-running ones do."""
    rng = np.random.default_rng([room.seed, 2])
    min_x, min_y, max_x, max_y = room.lab.bounds()
    ways = (np.arange(_LINES) + rng.uniform(0.2, 0.8, _LINES)) / _LINES * (max_y - min_y) + min_y
    turned = rng.random(_LINES) < 0.5
    period_s = 1.0 / (room.cameras[0].pipeline.spec.rate_hz * len(room.cameras))
    tracker, poses = Tracker(room.lab), dict[str, TrackedPose]()
    last: dict[str, tuple[tuple[str, ...], Array]] = {}
    steps_m, jumps_m = [0.0], [0.0]
    handovers = 0
    for turn in range(round((max_x - min_x) / _SPEED_MPS / period_s)):
        room.clock.wait(period_s)
        way = _SPEED_MPS * turn * period_s
        truth = {
            vehicle.id: SE2(max_x - way, float(y), math.pi) if back else SE2(min_x + way, float(y), 0.0)
            for vehicle, y, back in zip(room.lab.vehicles, ways, turned, strict=True)
        }
        snapshots = [VehicleSnapshot(name, p.x, p.y, p.yaw, _SPEED_MPS, 0.0) for name, p in truth.items()]
        for pose in tracker.update(room.look(room.cameras[turn % len(room.cameras)], snapshots, poses)):
            poses[pose.vehicle] = pose
            error = _error(pose, truth[pose.vehicle])
            if pose.vehicle in last:
                cameras, before = last[pose.vehicle]
                steps_m.append(math.hypot(*(error - before)[:2]))
                if cameras != pose.cameras:
                    handovers += 1
                    jumps_m.append(steps_m[-1])
            last[pose.vehicle] = (pose.cameras, error)
    return Drive(max(jumps_m), handovers, max(steps_m))


def _error(pose: TrackedPose, truth: SE2) -> Array:
    return np.array([pose.x - truth.x, pose.y - truth.y, angle_difference(pose.yaw, truth.yaw)])
