"""A route with its waypoints looked up, and how far a robot has come on it."""

from collections.abc import Mapping
from dataclasses import dataclass

from protocol.messages import Leg, Movement, Route, Waypoint
from server.guidance.path import Point


@dataclass(frozen=True, slots=True)
class Stop:
    """A leg resolved: the waypoint that it ends at."""

    waypoint: Waypoint
    leg: Leg

    @property
    def point(self) -> Point:
        return self.waypoint.x, self.waypoint.y

    @property
    def speed_mps(self) -> float:
        """The set-point on the way there."""
        return self.leg.speed_mps

    @property
    def yaw(self) -> float | None:
        """The heading to end with (rad), if it matters: the leg's, or else the waypoint's."""
        return self.waypoint.yaw if self.leg.yaw is None else self.leg.yaw

    @property
    def turns_only(self) -> bool:
        """Whether the leg is a turn on the spot."""
        return self.leg.movement is Movement.ROTATE

    @property
    def rests(self) -> bool:
        """Whether the robot comes to rest at the leg's end, wherever the route goes on."""
        return self.yaw is not None or self.leg.stays or self.turns_only


@dataclass(frozen=True, slots=True)
class RoutePlan:
    """A route with its waypoints looked up. A loop with a single waypoint is no loop: one arrives and stays."""

    stops: tuple[Stop, ...]
    loop: bool

    def arrives_at(self, leg: int) -> bool:
        """Whether the robot is to stop at the leg's end: the route ends there, or the robot turns, or stays a while."""
        ends = not self.loop and leg == len(self.stops) - 1
        return ends or self.stops[leg].rests or self.stops[(leg + 1) % len(self.stops)].turns_only

    def driven_after(self, leg: int) -> list[int]:
        """The legs that are driven after that one, in order: to the route's end, or one lap."""
        last = leg + len(self.stops) if self.loop else len(self.stops)
        legs = (index % len(self.stops) for index in range(leg + 1, last))
        return [index for index in legs if not self.stops[index].turns_only]

    def ways(self, leg: int) -> list[tuple[Stop, Stop]]:
        """The straight ways that are yet to be driven: of a loop all, else those from one waypoint to the next after the
        beginning of the leg. Turns on the spot lead nowhere."""
        stops = [stop for stop in self.stops if not stop.turns_only]
        if not stops:
            return []
        ways = list(zip([stops[-1], *stops[:-1]], stops, strict=True))
        if self.loop:
            return ways
        driven = sum(not stop.turns_only for stop in self.stops[:leg])
        return ways[max(1, driven) :]


def resolve(route: Route, waypoints: Mapping[str, Waypoint]) -> RoutePlan | str:
    """The plan, or the id of the first waypoint that does not exist."""
    for leg in route.legs:
        if leg.waypoint not in waypoints:
            return leg.waypoint
    stops = tuple(Stop(waypoints[leg.waypoint], leg) for leg in route.legs)
    return RoutePlan(stops, route.loop and len({stop.point for stop in stops if not stop.turns_only}) > 1)


@dataclass(frozen=True, slots=True)
class Progress:
    """How far along a route: the leg being driven, laps completed, whether the robot has come to the leg's end and stays
    there, and whether the route is over."""

    leg: int
    laps: int
    staying: bool = False
    done: bool = False
