"""The geofence: a robot stays in the lab's areas by itself, whatever commands say (spec gpss, "Safety").

It goes by where the rotation centre would stand if the robot braked now. Beyond the border it may only come nearer to an
area again, as when somebody drives it back by hand.
"""

import math
from collections.abc import Sequence

import shapely
from shapely.geometry import Point, Polygon

from agents.motion import STOP, Twist
from geometry import SE2
from protocol.lab import Area, Limits
from protocol.messages import Reason, ReasonCode

TOLERANCE_M = 0.15
"""A robot that arrives on the border is not beyond it: errors of its pose, and what a controller still takes off its speed."""
REACTION_S = 0.05


class Geofence:
    """The areas of a lab, joined."""

    def __init__(self, areas: Sequence[Area], limits: Limits) -> None:
        self._limits = limits
        self._allowed = shapely.union_all([Polygon(area.outline) for area in areas]).buffer(TOLERANCE_M)
        shapely.prepare(self._allowed)

    def limit(self, twist: Twist, pose: SE2) -> tuple[Twist, Reason | None]:
        """The twist that may be driven from `pose` (T_map_robot), and why when it is another one."""
        if twist == STOP:
            return twist, None
        here, there = Point(pose.x, pose.y), self._standing(twist, pose)
        if self._allowed.covers(there):
            return twist, None
        inside = self._allowed.covers(here)
        if not inside and (twist.linear_mps == 0.0 or self._allowed.distance(there) < self._allowed.distance(here)):
            return twist, None
        text = f"({pose.x:.2f}, {pose.y:.2f}) is {'at the border of the areas' if inside else 'in no area'}"
        return STOP, Reason(code=ReasonCode.OUTSIDE_AREA, text=text)

    def _standing(self, twist: Twist, pose: SE2) -> Point:
        """Where the rotation centre is when the robot stands; the turn during that way is that of the present twist."""
        speed = abs(twist.linear_mps)
        way_m = speed * REACTION_S + speed**2 / (2.0 * self._limits.braking_mps2)
        turn_rad = twist.angular_radps * way_m / speed if speed > 0.0 else 0.0
        moved = SE2.exp(math.copysign(way_m, twist.linear_mps), 0.0, turn_rad)
        stands = pose @ moved
        return Point(stands.x, stands.y)
