"""The other vehicles as the ceiling cameras see them: who is near a zone, who stands in an area, who is ahead on the way."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from agents.manoeuvres.passages import Way
from geometry import SE2
from geometry.angles import wrap_angle
from protocol.lab import ZoneSpec

_AHEAD_M = 6.0
_SAMPLE_M = 0.05


@dataclass(frozen=True, slots=True)
class Sighting:
    """Another vehicle: its pose (map frame), speed (m/s, forwards) and outline (m, seen from its rotation centre)."""

    pose: SE2
    speed_mps: float
    outline: tuple[tuple[float, float], ...]


class ZoneMap:
    """The lab's zones, to ask what is near them and in them."""

    def __init__(self, zones: Iterable[ZoneSpec]) -> None:
        self.zones = tuple(zones)
        self._areas = {
            f"{zone.id}/{name}": shapely.Polygon(outline)
            for zone in self.zones
            for name, outline in zone.subareas.items()
        }
        shapely.prepare(list(self._areas.values()))
        self._centres = {
            zone.id: shapely.unary_union([shapely.Polygon(outline) for outline in zone.subareas.values()]).centroid
            for zone in self.zones
        }
        self._detection = {zone.id: zone.detection_m for zone in self.zones}

    @property
    def areas(self) -> frozenset[str]:
        """All sub-areas, as `zone/sub-area`."""
        return frozenset(self._areas)

    def near(self, x: float, y: float, further_m: float = 0.0) -> frozenset[str]:
        """The zones whose middle is within their detection distance, or `further_m` more, of that point."""
        return frozenset(
            zone
            for zone, centre in self._centres.items()
            if np.hypot(centre.x - x, centre.y - y) <= self._detection[zone] + further_m
        )

    def touches(self, area: str, sighting: Sighting) -> bool:
        """Whether the vehicle's outline reaches into the area."""
        return bool(shapely.intersects(self._areas[area], shapely.Polygon(sighting.pose.apply(sighting.outline))))


@dataclass(frozen=True, slots=True)
class Ahead:
    """A vehicle on the way: how far its nearest part is from the robot's front (m, along the way; 0 beside it), how fast it
    drives along the way (m/s, 0 for one that comes towards), and how far its heading is from the way's there (rad, from 0)."""

    robot: str
    gap_m: float
    speed_mps: float
    turn_rad: float


def ahead_on(
    way: Way, progress_m: float, outline: NDArray[np.float64], others: Mapping[str, Sighting], until_m: float = np.inf
) -> list[Ahead]:
    """Vehicles that reach into the robot's lane (its outline's width) between its middle and `until_m` along the way, or some
    metres ahead; nearest first."""
    if not others:
        return []
    distances = np.arange(progress_m, min(progress_m + _AHEAD_M, until_m, way.length_m + 1.0), _SAMPLE_M)
    if not len(distances):
        return []
    lane = way.poses(distances)
    half_m, front_m = float(np.abs(outline[:, 1]).max()), float(outline[:, 0].max())
    found: list[Ahead] = []
    for robot, other in others.items():
        points = _rim(other)
        offset = points[:, None, :] - lane[None, :, :2]
        along = offset[..., 0] * np.cos(lane[:, 2]) + offset[..., 1] * np.sin(lane[:, 2])
        across = offset[..., 1] * np.cos(lane[:, 2]) - offset[..., 0] * np.sin(lane[:, 2])
        inside = (np.abs(across) <= half_m) & (np.abs(along) <= _SAMPLE_M)
        if not inside.any():
            continue
        first = int(np.flatnonzero(inside.any(axis=0))[0])
        turn = other.pose.yaw - float(lane[first, 2])
        found.append(
            Ahead(
                robot,
                max(0.0, first * _SAMPLE_M - front_m),
                max(0.0, other.speed_mps * float(np.cos(turn))),
                abs(wrap_angle(turn)),
            )
        )
    return sorted(found, key=lambda one: one.gap_m)


def _rim(other: Sighting) -> NDArray[np.float64]:
    """Points around the outline, its corners and what lies between, shape (N, 2), map frame."""
    corners = np.asarray(other.outline)
    following = np.roll(corners, -1, axis=0)
    shares = np.linspace(0.0, 1.0, 5)[:-1, None, None]
    return other.pose.apply((corners + shares * (following - corners)).reshape(-1, 2))
