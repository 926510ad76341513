"""Turning on the spot: the floor that a robot's outline sweeps while it does (spec gpss, "Safety").

Only a disc about the rotation centre covers no new floor when it turns; the corners of every other outline do. Robots turn
on the spot to a heading, and towards a target that lies far beside or behind them: their controller does so above 65
degrees. Guidance looks from `_STEERING_RAD` on, for below that a robot drives slowly and its rear swings out all the same.
"""

import itertools
import math

import shapely
from shapely.geometry import LineString

from geometry import SE2, angle_difference
from protocol.lab import VehicleSpec
from server.guidance.box import Box, footprint_at
from server.guidance.following import Goal
from server.guidance.path import bearing

LITTLE_RAD = 0.1
"""A turn that is not looked at: less than the error of a heading and the margin around the outline cover."""
_STEERING_RAD = math.radians(45.0)
_EITHER_WAY_RAD = math.radians(165.0)
"""From here on the measured heading does not tell which way round the robot turns."""
_STEP_RAD = math.radians(8.0)
_CENTRE_M = 1e-3


def turn_ahead(pose: SE2, goal: Goal) -> float:
    """The turn (rad, counter-clockwise) that the goal asks for on the spot, or nearly so; 0 when it is none to look at."""
    if goal.turn_to is not None:
        turn, least = angle_difference(goal.turn_to, pose.yaw), LITTLE_RAD
    else:
        direction = bearing((pose.x, pose.y), (goal.target.x, goal.target.y))
        turn, least = angle_difference(direction, pose.yaw), _STEERING_RAD
    return turn if abs(turn) > least else 0.0


def swept_by_turning(pose: SE2, turn_rad: float, spec: VehicleSpec) -> Box:
    """The floor that the outline covers during the turn, map frame; its line is the rotation centre, so to say: what is
    nearest to it is what is named."""
    first, last = min(0.0, turn_rad), max(0.0, turn_rad)
    if abs(turn_rad) > _EITHER_WAY_RAD:
        first, last = -abs(turn_rad), abs(turn_rad)
    steps = max(1, math.ceil((last - first) / _STEP_RAD))
    step = (last - first) / steps
    outlines = [footprint_at(SE2(pose.x, pose.y, pose.yaw + first + step * i), spec) for i in range(steps + 1)]
    # The hull of two neighbours holds the chord of every corner's way; its arc bulges beyond by at most `bulge`.
    hulls = [a.union(b).convex_hull for a, b in itertools.pairwise(outlines)]
    bulge = max(math.hypot(x, y) for x, y in spec.footprint) * (1 - math.cos(step / 2))
    centre = LineString([(pose.x, pose.y), (pose.x + _CENTRE_M, pose.y)])
    return Box(shapely.union_all(hulls).buffer(bulge, quad_segs=2), centre)
