"""Speed limits by zone (spec gpss, "Safety"): a robot is at the zone's speed before any part of it comes in, and until all of it
is out again."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from protocol.messages import SpeedZone
from server.guidance.line import Line
from server.guidance.parameters import GuidanceParameters
from server.guidance.path import Point


@dataclass(frozen=True, slots=True)
class SpeedLimit:
    """A limit that holds for a robot now, or will: the speed (m/s) that it may have here, and the zone that says so."""

    speed_mps: float
    zone: str


class SpeedLimits:
    """All zones of the floor, widened by how far a robot reaches from its rotation centre."""

    def __init__(self, zones: Iterable[SpeedZone], parameters: GuidanceParameters) -> None:
        self._zones = tuple(zones)
        self._parameters = parameters
        self._widened: dict[float, tuple[BaseGeometry, ...]] = {}

    def at(self, here: Point, radius_m: float) -> SpeedLimit | None:
        """The lowest limit where a robot of that radius is, None where there is none."""
        if not self._zones:
            return None
        point = shapely.Point(here)
        zones = zip(self._zones, self._of(radius_m), strict=True)
        inside = [SpeedLimit(zone.speed_mps, zone.id) for zone, area in zones if area.covers(point)]
        return min(inside, key=lambda limit: limit.speed_mps, default=None)

    def along(self, path: Sequence[Point], radius_m: float, speed_mps: float) -> SpeedLimit | None:
        """The limit for a robot at the beginning of `path` that wants `speed_mps`: v of the zone inside it, and before it the
        speed from which braking gently still leaves v at its border, sqrt(v^2 + 2 a d). None when it may have its wish."""
        if not self._zones or not path:
            return None
        p, way = self._parameters, Line(path)
        found = self.at(path[0], radius_m)
        points = way.part(0.0, speed_mps * p.zone_lead_s + speed_mps**2 / (2 * p.zone_mps2))
        if len(points) > 1:
            line = LineString(points)
            for zone, area in zip(self._zones, self._of(radius_m), strict=True):
                if zone.speed_mps >= speed_mps or not area.intersects(line):
                    continue
                inside = shapely.get_coordinates(line.intersection(area))
                first_m = float(np.min(shapely.line_locate_point(line, shapely.points(inside))))
                left_m = max(0.0, first_m - speed_mps * p.zone_lead_s)
                here_mps = math.sqrt(zone.speed_mps**2 + 2 * p.zone_mps2 * left_m)
                if found is None or here_mps < found.speed_mps:
                    found = SpeedLimit(here_mps, zone.id)
        return found if found is not None and found.speed_mps < speed_mps else None

    def _of(self, radius_m: float) -> tuple[BaseGeometry, ...]:
        areas = self._widened.get(radius_m)
        if areas is None:
            areas = tuple(Polygon(zone.outline).buffer(radius_m) for zone in self._zones)
            for area in areas:
                shapely.prepare(area)
            self._widened[radius_m] = areas
        return areas
