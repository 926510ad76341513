"""The zones on a robot's way: which sub-areas its body will sweep, and between which distances along the way."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from geometry import SE2
from protocol.lab import ZoneSpec

_STEP_M = 0.02
_FINE_M = 0.001


@dataclass(frozen=True, slots=True)
class Use:
    """A sub-area (`zone/sub-area`) on the way: the body, with its margin, touches it from `enter_m` to `exit_m`, which are
    distances of the rotation centre along the way (m). A way that comes back to an area uses it twice."""

    zone: str
    area: str
    enter_m: float
    exit_m: float


@dataclass(frozen=True, slots=True)
class Passage:
    """Uses that are booked together: between them is no room to stand. In the order of entering."""

    uses: tuple[Use, ...]

    @property
    def enter_m(self) -> float:
        return min(use.enter_m for use in self.uses)

    @property
    def exit_m(self) -> float:
        return max(use.exit_m for use in self.uses)

    @property
    def zones(self) -> frozenset[str]:
        return frozenset(use.zone for use in self.uses)


class Way:
    """A line of points (m, map frame), shape (N, 2), by the distance along it. ValueError for fewer than two different ones."""

    def __init__(self, points: Sequence[tuple[float, float]] | NDArray[np.float64]) -> None:
        given = np.asarray(points, dtype=np.float64).reshape(-1, 2)
        kept = np.concatenate([[True], np.hypot(*np.diff(given, axis=0).T) > 1e-9]) if len(given) else np.zeros(0, bool)
        self.points = given[kept]
        if len(self.points) < 2:
            raise ValueError("a way needs two different points")
        pieces = np.diff(self.points, axis=0)
        self._along = np.concatenate([[0.0], np.cumsum(np.hypot(*pieces.T))])
        self._yaws = np.arctan2(pieces[:, 1], pieces[:, 0])

    @property
    def length_m(self) -> float:
        return float(self._along[-1])

    def at(self, distance_m: float) -> SE2:
        """The pose there, heading along the way; beyond its ends on the straight on."""
        piece = int(np.clip(np.searchsorted(self._along, distance_m, side="right") - 1, 0, len(self._yaws) - 1))
        yaw = float(self._yaws[piece])
        past = distance_m - float(self._along[piece])
        x, y = self.points[piece]
        return SE2(float(x) + past * float(np.cos(yaw)), float(y) + past * float(np.sin(yaw)), yaw)

    def poses(self, distances_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same for many, shape (N, 3): x, y, yaw."""
        piece = np.clip(np.searchsorted(self._along, distances_m, side="right") - 1, 0, len(self._yaws) - 1)
        yaw = self._yaws[piece]
        past = distances_m - self._along[piece]
        return np.column_stack(
            [self.points[piece, 0] + past * np.cos(yaw), self.points[piece, 1] + past * np.sin(yaw), yaw]
        )


def uses_of(
    way: Way, footprint: Sequence[tuple[float, float]], zones: Iterable[ZoneSpec], margin_m: float
) -> list[Use]:
    """Every use of a sub-area on the way, by entering. The body is the `footprint` (m, seen from the rotation centre) grown by
    the margin, its heading along the way; distances are right to about a millimetre, on the safe side."""
    body = shapely.Polygon(footprint).buffer(margin_m, join_style="mitre")
    distances = np.arange(0.0, way.length_m + _STEP_M, _STEP_M)
    bodies = _placed(body, way.poses(distances))
    found: list[Use] = []
    for zone in zones:
        for name, outline in zone.subareas.items():
            area = shapely.Polygon(outline)
            shapely.prepare(area)
            touched = shapely.intersects(area, bodies)
            for first, last in _runs(touched):
                found.append(
                    Use(
                        zone.id,
                        f"{zone.id}/{name}",
                        _edge(area, body, way, float(distances[first]), -_STEP_M) if first else 0.0,
                        _edge(area, body, way, float(distances[last]), _STEP_M),
                    )
                )
    return sorted(found, key=lambda use: (use.enter_m, use.area))


def passages_of(uses: Sequence[Use], standing_m: float) -> list[Passage]:
    """Uses booked together: one that begins less than `standing_m` after those before have ended belongs to them."""
    groups: list[list[Use]] = []
    end_m = -np.inf
    for use in uses:
        if groups and use.enter_m < end_m + standing_m:
            groups[-1].append(use)
        else:
            groups.append([use])
        end_m = max(end_m, use.exit_m)
    return [Passage(tuple(group)) for group in groups]


def _placed(body: shapely.Polygon, poses: NDArray[np.float64]) -> NDArray[np.object_]:
    outline = shapely.get_coordinates(body)
    cos, sin = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    x = poses[:, :1] + cos * outline[:, 0] - sin * outline[:, 1]
    y = poses[:, 1:2] + sin * outline[:, 0] + cos * outline[:, 1]
    return np.asarray(shapely.polygons(np.stack([x, y], axis=-1)), dtype=np.object_)


def _runs(touched: NDArray[np.bool_]) -> list[tuple[int, int]]:
    edges = np.diff(np.concatenate([[0], touched.astype(np.int8), [0]]))
    return list(zip(np.flatnonzero(edges == 1).tolist(), (np.flatnonzero(edges == -1) - 1).tolist(), strict=True))


def _edge(area: shapely.Polygon, body: shapely.Polygon, way: Way, inside_m: float, step_m: float) -> float:
    """Between a distance at which the body touches the area and one a step further: the outermost that still may."""
    outside_m = inside_m + step_m
    while abs(outside_m - inside_m) > _FINE_M:
        middle = (inside_m + outside_m) / 2
        if shapely.intersects(area, _placed(body, way.poses(np.array([middle]))))[0]:
            inside_m = middle
        else:
            outside_m = middle
    return outside_m
