"""Scenes of the obstacles experiment: a robot on a route, and something that comes into its way.

A *person* steps in from the side and stays; a *pallet* is left behind on the path; a *drop* appears inside the protective field
itself, nearer than people put anything before a moving robot, but no nearer than the robot can stop.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from shapely.geometry import LineString, Polygon
from shapely.geometry import Point as ShapelyPoint
from shapely.geometry.base import BaseGeometry

from geometry import SE2
from lab.objects import PALLET_LENGTH_M, PALLET_WIDTH_M, PERSON_RADIUS_M
from protocol.lab import Lab, VehicleSpec
from protocol.messages import SimulatedObject

Kind = Literal["person", "pallet", "drop"]
Point = tuple[float, float]

THING = "thing"
SLOWEST_MPS, FASTEST_MPS = 0.15, 0.45
_FREE_M = 0.6
"""What waypoints keep from the border of the areas."""
_CLOSE_M, _AWAY_M = (-0.1, 0.15), (0.35, 1.3)
"""Ahead of the robot's front, where a pallet is left (never close), or a person would come to stand if the robot did not slow
down (every second one close, right before it)."""
_SHARPEST_RAD = 1.0
_TRIES = 1000


@dataclass(frozen=True, slots=True)
class Scene:
    """Drawn from `seed`: a robot drives from `start` over the points at `speed_mps`; `after_s` later a thing comes, `ahead_m`
    ahead of its front along the path and `beside_m` beside it. A person walks there at `walk_mps` from `aside_m` away."""

    seed: int
    kind: Kind
    vehicle: VehicleSpec
    start: SE2
    points: tuple[Point, ...]
    speed_mps: float
    after_s: float
    ahead_m: float
    beside_m: float
    yaw: float
    walk_mps: float
    aside_m: float

    def place(self, here: SE2, speed_mps: float) -> tuple[SimulatedObject, SimulatedObject | None, float]:
        """What is put down when the robot is `here` at this speed; and, if that walks, what it is once it stands, and after
        how many seconds."""
        front_m = max(x for x, _ in self.vehicle.footprint)
        path = LineString([(self.start.x, self.start.y), *self.points])
        done_m = path.project(ShapelyPoint(here.x, here.y))
        if self.kind == "person":
            walk_s = self.aside_m / self.walk_mps
            x, y, heading = _along(path, done_m + front_m + self.ahead_m + PERSON_RADIUS_M + speed_mps * walk_s)
            side = math.copysign(1.0, self.beside_m)
            from_x, from_y = _beside(x, y, heading, side * self.aside_m)
            walking = SimulatedObject(
                id=THING, kind="person", x=from_x, y=from_y, path=((x, y),), speed_mps=self.walk_mps
            )
            return walking, SimulatedObject(id=THING, kind="person", x=x, y=y), walk_s
        depth_m = _half_depth_m(self.yaw)
        x, y, heading = _along(path, done_m + front_m + self.ahead_m + depth_m)
        x, y = _beside(x, y, heading, self.beside_m)
        return SimulatedObject(id=THING, kind="pallet", x=x, y=y, yaw=heading + self.yaw), None, 0.0


def draw_scene(lab: Lab, seed: int, *, drop: bool = False) -> Scene:
    """The scene of that seed. ValueError when the lab has no room for a route."""
    rng = np.random.default_rng([seed, 2026])
    vehicles = [vehicle for vehicle in lab.vehicles if vehicle.driver == "sim" and vehicle.scanner is not None]
    vehicle = vehicles[int(rng.integers(len(vehicles)))]
    kind: Kind = "drop" if drop else ("person", "pallet")[int(rng.integers(2))]
    speed = float(rng.uniform(SLOWEST_MPS, min(FASTEST_MPS, vehicle.limits.speed_mps)))
    start, points = _route(lab, rng)
    close = kind == "person" and bool(rng.integers(2))
    ahead = float(rng.uniform(*(_CLOSE_M if close else _AWAY_M)))
    if drop:
        limits, field = vehicle.limits, vehicle.protective_field
        stopping = speed**2 / (2.0 * limits.braking_mps2)
        ahead = stopping + float(rng.uniform(0.7, 1.0)) * (speed * field.reaction_s + field.margin_m) - 0.005
    return Scene(
        seed=seed,
        kind=kind,
        vehicle=vehicle,
        start=start,
        points=points,
        speed_mps=speed,
        after_s=float(rng.uniform(1.6, 3.0)),
        ahead_m=ahead,
        beside_m=float(rng.uniform(-0.1, 0.1)) if not drop else 0.0,
        yaw=float(rng.uniform(-math.pi, math.pi)) if not drop else 0.0,
        walk_mps=float(rng.uniform(0.8, 1.5)),
        aside_m=float(rng.uniform(0.8, 1.3)),
    )


def _route(lab: Lab, rng: np.random.Generator) -> tuple[SE2, tuple[Point, ...]]:
    """A start and two legs with a bend between them (or none), well inside the areas."""
    floor: BaseGeometry = Polygon(lab.areas[0].outline).buffer(-_FREE_M)
    min_x, min_y, max_x, max_y = Polygon(lab.areas[0].outline).bounds
    for _ in range(_TRIES):
        x, y = float(rng.uniform(min_x, max_x)), float(rng.uniform(min_y, max_y))
        heading = float(rng.uniform(-math.pi, math.pi))
        turn = float(rng.choice([0.0, 1.0])) * float(rng.uniform(-_SHARPEST_RAD, _SHARPEST_RAD))
        first = _ahead((x, y), heading, float(rng.uniform(0.8, 2.0)))
        second = _ahead(first, heading + turn, 2.5)
        if floor.covers(LineString([(x, y), first, second])):
            return SE2(x, y, heading), (first, second)
    raise ValueError(f"area {lab.areas[0].id} of lab {lab.name} has no room for routes of 3 to 4.5 m")


def _half_depth_m(yaw: float) -> float:
    """Half of how far a pallet that is turned by `yaw` reaches along the path."""
    return (abs(PALLET_LENGTH_M * math.cos(yaw)) + abs(PALLET_WIDTH_M * math.sin(yaw))) / 2.0


def _along(path: LineString, way_m: float) -> tuple[float, float, float]:
    """The point of the path after `way_m` and the path's heading there; beyond its end straight on."""
    way = min(way_m, path.length)
    here, before = path.interpolate(way), path.interpolate(max(0.0, way - 0.05))
    heading = math.atan2(here.y - before.y, here.x - before.x)
    x, y = _ahead((here.x, here.y), heading, way_m - way)
    return x, y, heading


def _ahead(point: Point, heading: float, metres: float) -> Point:
    return point[0] + metres * math.cos(heading), point[1] + metres * math.sin(heading)


def _beside(x: float, y: float, heading: float, metres: float) -> Point:
    return _ahead((x, y), heading + math.pi / 2, metres)
