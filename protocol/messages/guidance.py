"""What guidance knows of a robot beyond its command (spec gpss, "The operator's side"): the obstacle box, what is in it,
the temporary waypoint and the path ahead. For the map and the 3D scene; robots do not read it."""

from typing import Annotated

from pydantic import Field

from protocol.messages.base import Finite, Identifier, Message, NonNegative, PointXY, StampNs
from protocol.messages.fleet import Reason


class Blockage(Message):
    """The nearest thing in an obstacle box: where it is (m, map frame), how far ahead of the robot's front along the path
    (m), and which robot it is (None: something on the floor)."""

    x: Finite
    y: Finite
    distance_m: NonNegative
    robot: Identifier | None = None


class GuidanceState(Message):
    """How guidance sees one robot at `stamp_ns`.

    `box` is the outline of the obstacle box (empty while the robot is not on a route); `blocked` tells whether it counts
    as taken, also for the moment for which it must have been clear before the robot drives on; `blockage` is what is in
    it now. `path` runs from the robot over the waypoints ahead, `carrot` is the temporary waypoint on it. `detour` is what is
    left of the way around something, or out of another robot's way, that the robot makes (empty on its route).
    """

    robot: Identifier
    stamp_ns: StampNs
    reason: Reason
    blocked: bool = False
    blockage: Blockage | None = None
    box: tuple[PointXY, ...] = ()
    carrot: PointXY | None = None
    path: tuple[PointXY, ...] = ()
    detour: tuple[PointXY, ...] = ()
    leg: Annotated[int, Field(ge=0)] | None = Field(default=None, description="Index of the route's leg being driven.")
