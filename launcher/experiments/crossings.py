"""Straight drives through one camera's view: from outside through the picture and out again (GulliView 2024, 4.1.3)."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geometry import SE2
from lab.snapshot import VehicleSnapshot

ACCELERATION_MPS2 = 10.0
"""One g: more than tyres give."""
_REACH_M = 4.0
"""No picture of a ceiling camera shows the floor further than this from the point below it."""
_REST_FRAMES = 10


@dataclass(frozen=True, slots=True)
class Crossing:
    """A drive along a line through (x, y) in metres, map frame, in the direction `heading` (rad). From rest the vehicle stands
    at that point first and is accelerated from there (m/s^2); otherwise it drives at constant speed all the way."""

    vehicle: str
    x: float
    y: float
    heading: float
    acceleration_mps2: float | None = None

    def drive(self, speed_mps: float, rate_hz: float) -> Iterator[VehicleSnapshot]:
        """The vehicle at each frame, centred on the middle of the exposure."""
        start = SE2(self.x, self.y, self.heading)
        frames = range(-_REST_FRAMES, 10_000) if self.acceleration_mps2 else range(10_000)
        for frame in frames:
            way_m, now_mps = self._way(frame / rate_hz, speed_mps)
            if way_m > _REACH_M:
                return
            at = start @ SE2(way_m, 0.0, 0.0)
            yield VehicleSnapshot(self.vehicle, at.x, at.y, at.yaw, now_mps, 0.0)

    def _way(self, time_s: float, speed_mps: float) -> tuple[float, float]:
        """Metres past the line's point and speed after that time."""
        if self.acceleration_mps2 is None:
            return speed_mps * time_s - _REACH_M, speed_mps
        if time_s <= 0:
            return 0.0, 0.0
        faster_s = min(time_s, speed_mps / self.acceleration_mps2)
        now_mps = self.acceleration_mps2 * faster_s
        return now_mps * faster_s / 2 + speed_mps * (time_s - faster_s), now_mps


def crossings(
    vehicles: tuple[str, ...], center: tuple[float, float], half_size_m: tuple[float, float], rng: np.random.Generator
) -> list[Crossing]:
    """Six directions, along and across the view and its diagonals, each a little turned and shifted by chance and with the
    next vehicle; and one start from rest at either end of the view's longer axis. `half_size_m`: half the view in x and y."""
    x, y = center
    half_x, half_y = half_size_m
    diagonal = math.atan2(half_y, half_x)
    lines = [0.0, math.pi, math.pi / 2, -math.pi / 2, diagonal, diagonal - math.pi]
    found: list[Crossing] = []
    for index, heading in enumerate(lines):
        aside_x, aside_y = rng.uniform(-0.5, 0.5, 2) * half_size_m
        turned = heading + float(rng.uniform(-0.15, 0.15))
        found.append(Crossing(vehicles[index % len(vehicles)], x + float(aside_x), y + float(aside_y), turned))
    along, across = (0.0, math.pi / 2) if half_x > half_y else (math.pi / 2, 0.0)
    for sign in (1, -1):
        heading = along if sign > 0 else along - math.pi
        back, aside = 0.8 * max(half_size_m), float(rng.uniform(-0.3, 0.3)) * min(half_size_m)
        start_x = x - back * math.cos(heading) + aside * math.cos(across)
        start_y = y - back * math.sin(heading) + aside * math.sin(across)
        vehicle = vehicles[(len(lines) + len(found)) % len(vehicles)]
        found.append(Crossing(vehicle, start_x, start_y, heading, ACCELERATION_MPS2))
    return found
