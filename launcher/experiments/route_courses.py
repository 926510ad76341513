"""The courses of the route experiment: lines that an operator draws, from rest at (0, 0) facing +x to a halt."""

import math
from dataclasses import dataclass

from protocol.messages import Leg, Route, Waypoint

Point = tuple[float, float]

_DENSE_M = 0.25
"""Curves are drawn as waypoints about so far apart."""


@dataclass(frozen=True, slots=True)
class RouteCourse:
    """`points` in metres, map frame, the first is the start; `yaw_rad` the heading to end with, None where it does not matter."""

    name: str
    points: tuple[Point, ...]
    yaw_rad: float | None = None

    @property
    def length_m(self) -> float:
        return sum(math.dist(a, b) for a, b in zip(self.points, self.points[1:], strict=False))

    def plan(self, area: str, speed_mps: float, radius_m: float) -> tuple[Route, dict[str, Waypoint]]:
        """As the operator enters it: a waypoint at every point but the start, reached within the radius, driven once at this
        speed."""
        waypoints: dict[str, Waypoint] = {}
        for number, (x, y) in enumerate(self.points[1:], start=1):
            last = number == len(self.points) - 1
            name = f"{self.name}-{number}"
            waypoints[name] = Waypoint(
                id=name, area=area, x=x, y=y, radius_m=radius_m, yaw=self.yaw_rad if last else None
            )
        return Route(id=self.name, legs=tuple(Leg(waypoint=name, speed_mps=speed_mps) for name in waypoints)), waypoints


def courses() -> tuple[RouteCourse, ...]:
    """A straight line, right angles, an S of two arcs, once around a circle, a zigzag of sharp corners, and a line to a place
    with a heading."""
    s_curve = _arc((1.0, 0.0), 0.0, 1.2, math.pi / 2) + _arc((2.2, 1.2), math.pi / 2, 1.2, -math.pi / 2)
    circle = _arc((1.0, 0.0), 0.0, 1.0, math.tau)
    zigzag = [(0.0, 0.0), (2.0, 0.0), (1.25, 1.3), (3.25, 1.3), (2.5, 2.6), (4.5, 2.6)]
    return (
        RouteCourse("straight", ((0.0, 0.0), (5.0, 0.0))),
        RouteCourse("corners", ((0.0, 0.0), (2.0, 0.0), (2.0, 1.8), (4.0, 1.8), (4.0, 0.2), (5.5, 0.2))),
        RouteCourse("s_curve", ((0.0, 0.0), (1.0, 0.0), *s_curve, (4.4, 2.4))),
        RouteCourse("circle", ((0.0, 0.0), (1.0, 0.0), *circle, (2.5, 0.0))),
        RouteCourse("zigzag", tuple(zigzag)),
        RouteCourse("heading", ((0.0, 0.0), (2.0, 0.0), (3.5, 1.0)), yaw_rad=-math.pi / 2),
    )


def _arc(start: Point, heading_rad: float, radius_m: float, turn_rad: float) -> list[Point]:
    """Points of an arc behind its start; it turns left for positive angles."""
    steps = max(2, round(radius_m * abs(turn_rad) / _DENSE_M))
    side = math.copysign(1.0, turn_rad)
    center = (
        start[0] - side * radius_m * math.sin(heading_rad),
        start[1] + side * radius_m * math.cos(heading_rad),
    )
    first = heading_rad - side * math.pi / 2
    angles = [first + turn_rad * step / steps for step in range(1, steps + 1)]
    return [
        (round(center[0] + radius_m * math.cos(a), 4), round(center[1] + radius_m * math.sin(a), 4)) for a in angles
    ]
