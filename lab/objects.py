"""People and pallets on the simulated floor: their sizes, and people who walk a path back and forth."""

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from shapely import affinity
from shapely.geometry import Point, Polygon, box

from geometry import SE2
from lab.snapshot import ObjectSnapshot
from protocol.messages import SimulatedObject

PERSON_RADIUS_M = 0.22
PERSON_HEIGHT_M = 1.72
PALLET_LENGTH_M, PALLET_WIDTH_M, PALLET_HEIGHT_M = 0.6, 0.4, 0.144
"""A quarter pallet, which fits a floor of scaled vehicles; its length lies along its x axis."""

_PERSON = Point(0.0, 0.0).buffer(PERSON_RADIUS_M, quad_segs=4)
_PALLET = box(-PALLET_LENGTH_M / 2, -PALLET_WIDTH_M / 2, PALLET_LENGTH_M / 2, PALLET_WIDTH_M / 2)


_OUTLINES = {kind: np.array(shape.exterior.coords[:-1]) for kind, shape in (("person", _PERSON), ("pallet", _PALLET))}


class _Leg(NamedTuple):
    start: tuple[float, float]
    end: tuple[float, float]
    length_m: float


class PlacedObject:
    """An object as put down, and how far along its path it has come."""

    def __init__(self, description: SimulatedObject) -> None:
        self.description = description
        points = [(description.x, description.y)]
        if description.kind == "person":
            points += description.path
        self._legs = [_Leg(a, b, math.dist(a, b)) for a, b in itertools.pairwise(points) if a != b]
        self._total_m = math.fsum(leg.length_m for leg in self._legs)
        self._travelled_m = 0.0
        self._speed_mps = 0.0
        self.pose = self._pose_at(0.0)
        self.radius_m = (
            PERSON_RADIUS_M if description.kind == "person" else math.hypot(PALLET_LENGTH_M, PALLET_WIDTH_M) / 2
        )

    @property
    def outline(self) -> NDArray[np.float64]:
        """The corners (N, 2) seen from its centre (m)."""
        return _OUTLINES[self.description.kind]

    @property
    def walks(self) -> bool:
        return self._total_m > 0.0 and self.description.speed_mps > 0.0

    def footprint_at(self, pose: SE2) -> Polygon:
        """The outline on the map (m)."""
        shape = _PERSON if self.description.kind == "person" else _PALLET
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        return affinity.affine_transform(shape, [c, -s, s, c, pose.x, pose.y])

    def plan(self, step_s: float) -> SE2:
        """Where one more step of walking leads."""
        return self._pose_at(self._travelled_m + self.description.speed_mps * step_s)

    def commit(self, pose: SE2, step_s: float) -> None:
        self.pose = pose
        self._travelled_m = math.fmod(self._travelled_m + self.description.speed_mps * step_s, 2.0 * self._total_m)
        self._speed_mps = self.description.speed_mps

    def wait(self) -> None:
        """Something stands in the way."""
        self._speed_mps = 0.0

    def snapshot(self) -> ObjectSnapshot:
        d = self.description
        return ObjectSnapshot(d.id, d.kind, self.pose.x, self.pose.y, self.pose.yaw, self._speed_mps)

    def _pose_at(self, travelled_m: float) -> SE2:
        """Forth along the path, then back, and so on."""
        if not self.walks:
            return SE2(self.description.x, self.description.y, self.description.yaw)
        rest = math.fmod(travelled_m, 2.0 * self._total_m)
        back = rest > self._total_m
        rest = 2.0 * self._total_m - rest if back else rest
        leg = 0
        while leg < len(self._legs) - 1 and rest > self._legs[leg].length_m:
            rest -= self._legs[leg].length_m
            leg += 1
        (ax, ay), (bx, by), length_m = self._legs[leg]
        share, yaw = min(1.0, rest / length_m), math.atan2(by - ay, bx - ax)
        return SE2(ax + share * (bx - ax), ay + share * (by - ay), yaw + math.pi if back else yaw)
