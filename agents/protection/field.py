"""The floor that a robot cannot help covering before it stands, and what of a scan lies in it: pure geometry.

A robot that holds its twist for the reaction time and then brakes, in a straight line and in turning, as hard as it can,
passes a row of poses. The protective field is its outline (the convex hull of it) at each of them, widened by the margin. So
the field grows with the speed, bends with the path, and lies around a robot that turns on the spot.
"""

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import MultiPoint

from agents.motion import Twist
from protocol.lab import Limits

Floats = NDArray[np.float64]
_APART_M = 0.03
"""How far the fastest point of the outline moves from one pose of the row to the next, at most; what the row leaves out
between two poses is far less than the margin."""
_MOST_POSES = 48
_NEARER_M = 0.003
"""A thing within the margin already is in the way of a motion only if that brings it nearer: else a robot that stands too
near to something could never leave it."""
_SELF_M = 0.02
"""Echoes from deeper inside the outline are of the robot itself."""


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """Poses in the robot's present frame, from standing here to standing still: x, y (m) and yaw (rad), each (K,)."""

    x: Floats
    y: Floats
    yaw: Floats


class Outline:
    """The convex hull of a footprint as half-planes n . p <= c with unit normals."""

    def __init__(self, footprint: tuple[tuple[float, float], ...]) -> None:
        hull = np.asarray(shapely.get_coordinates(MultiPoint(footprint).convex_hull))[:-1]
        edges = np.roll(hull, -1, axis=0) - hull
        doubled_area = float(np.sum(hull[:, 0] * np.roll(hull[:, 1], -1) - hull[:, 1] * np.roll(hull[:, 0], -1)))
        outward = np.column_stack((edges[:, 1], -edges[:, 0])) * math.copysign(1.0, doubled_area)
        self._normals = outward / np.hypot(*outward.T)[:, None]
        self._offsets = np.sum(self._normals * hull, axis=1)
        self.radius_m = float(np.max(np.hypot(*hull.T)))

    def clearance_m(self, points: Floats, sweep: Sweep) -> Floats:
        """How far each of the points (N, 2) is outside of the outline at each pose, (K, N); negative inside. At corners the
        true distance is larger."""
        c, s = np.cos(sweep.yaw)[:, None], np.sin(sweep.yaw)[:, None]
        dx, dy = points[:, 0] - sweep.x[:, None], points[:, 1] - sweep.y[:, None]
        local_x, local_y = c * dx + s * dy, c * dy - s * dx
        clearance = np.full(local_x.shape, -np.inf)
        for (nx, ny), offset in zip(self._normals, self._offsets, strict=True):
            np.maximum(clearance, nx * local_x + ny * local_y - offset, out=clearance)
        return clearance


def braking_sweep(twist: Twist, limits: Limits, radius_m: float, hold_s: float) -> Sweep:
    """The row of poses of a robot that holds `twist` for `hold_s` and then brakes with its limits; `radius_m` is how far its
    outline reaches from the rotation centre."""
    v, w = abs(twist.linear_mps), abs(twist.angular_radps)
    stop_v_s, stop_w_s = v / limits.braking_mps2, w / limits.yaw_acceleration_radps2
    end_s = hold_s + max(stop_v_s, stop_w_s)
    if end_s <= 0.0 or v == w == 0.0:
        return Sweep(np.zeros(1), np.zeros(1), np.zeros(1))
    poses = min(_MOST_POSES, 2 + math.ceil((v + w * radius_m) * end_s / _APART_M))
    t = np.linspace(0.0, end_s, poses)
    along = math.copysign(1.0, twist.linear_mps) * _travelled(t, v, limits.braking_mps2, hold_s)
    yaw = math.copysign(1.0, twist.angular_radps) * _travelled(t, w, limits.yaw_acceleration_radps2, hold_s)
    step, heading = np.diff(along), (yaw[1:] + yaw[:-1]) / 2
    x = np.concatenate(([0.0], np.cumsum(step * np.cos(heading))))
    y = np.concatenate(([0.0], np.cumsum(step * np.sin(heading))))
    return Sweep(x, y, yaw)


def in_the_way(points: Floats, outline: Outline, sweep: Sweep, margin_m: float) -> Floats:
    """The points (M, 2) of the points (N, 2) that come nearer to the outline than `margin_m` on the way, in the order of their
    distance from the rotation centre."""
    if len(sweep.x) < 2 or not len(points):
        return np.empty((0, 2))
    reach = outline.radius_m + margin_m + float(np.max(np.hypot(sweep.x, sweep.y)))
    near = points[np.sum(points**2, axis=1) <= (1.5 * reach) ** 2]
    if not len(near):
        return near
    clearance = outline.clearance_m(near, sweep)
    now, then = clearance[0], np.min(clearance[1:], axis=0)
    hit = np.flatnonzero((then < margin_m) & (then < now - _NEARER_M) & (now > -_SELF_M))
    return near[hit[np.argsort(np.hypot(*near[hit].T))]]


def _travelled(t: Floats, rate: float, braking: float, hold_s: float) -> Floats:
    """The way after the times `t` of something that moves at `rate` for `hold_s` and then brakes."""
    braked_s = np.clip(t - hold_s, 0.0, rate / braking)
    return rate * np.minimum(t, hold_s) + rate * braked_s - braking * braked_s**2 / 2
