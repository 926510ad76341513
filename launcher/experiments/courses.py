"""Test courses: closed curves that vehicles follow by the ground truth, so that localization alone is judged.

The infinity-shaped course (a lemniscate of Gerono through all cameras' fields, GulliView 2024, figure 4.1) and a rectangle
with rounded corners around it.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import angle_difference
from protocol.messages import TruePose

_SAMPLES = 2000


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A closed curve. `points` (N, 2) in metres, map frame, `arc` (N,) the way along it in metres, `length_m` once around."""

    name: str
    points: NDArray[np.float64]
    arc: NDArray[np.float64]
    length_m: float

    @classmethod
    def closed(cls, name: str, points: NDArray[np.float64]) -> "Course":
        """From points (N, 2) in driving order; the last is joined to the first."""
        ring = np.vstack([points, points[:1]])
        arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(ring, axis=0).T))])
        return cls(name, ring, arc, float(arc[-1]))

    def at(self, way_m: float) -> tuple[float, float, float]:
        """x, y (m) and the heading of the tangent (rad) after `way_m` metres."""
        x, y = self._point(way_m)
        ahead_x, ahead_y = self._point(way_m + 0.01)
        return x, y, math.atan2(ahead_y - y, ahead_x - x)

    def nearest(self, x: float, y: float, around_m: float, reach_m: float = 0.5) -> float:
        """The way (m) of the curve's point nearest to (x, y), sought within `reach_m` of `around_m`: where the curve
        crosses itself the other branch is not taken."""
        ways = around_m + np.linspace(-reach_m, reach_m, 101)
        xs = np.interp(ways % self.length_m, self.arc, self.points[:, 0])
        ys = np.interp(ways % self.length_m, self.arc, self.points[:, 1])
        return float(ways[int(np.argmin((xs - x) ** 2 + (ys - y) ** 2))])

    def _point(self, way_m: float) -> tuple[float, float]:
        way = way_m % self.length_m
        return float(np.interp(way, self.arc, self.points[:, 0])), float(np.interp(way, self.arc, self.points[:, 1]))


def infinity(center: tuple[float, float], half_length_m: float, half_width_m: float) -> Course:
    """The lemniscate x = a sin t, y = b sin 2t around `center`, its long axis along x."""
    t = np.linspace(0.0, math.tau, _SAMPLES, endpoint=False)
    x = center[0] + half_length_m * np.sin(t)
    y = center[1] + half_width_m * np.sin(2 * t)
    return Course.closed("infinity", np.column_stack([x, y]))


def rectangle(min_x: float, min_y: float, max_x: float, max_y: float, radius_m: float) -> Course:
    """A rectangle driven counter-clockwise, its corners rounded."""
    corners = [
        (max_x - radius_m, min_y + radius_m, -math.pi / 2),
        (max_x - radius_m, max_y - radius_m, 0.0),
        (min_x + radius_m, max_y - radius_m, math.pi / 2),
        (min_x + radius_m, min_y + radius_m, math.pi),
    ]
    points = [
        (cx + radius_m * math.cos(start + angle), cy + radius_m * math.sin(start + angle))
        for cx, cy, start in corners
        for angle in np.linspace(0.0, math.pi / 2, 60)
    ]
    return Course.closed("rectangle", np.array(points))


class CourseFollower:
    """Steers one vehicle along a course by its true pose: feed-forward of the course's curvature with feedback of the
    offset (m) and the heading error (rad), as in Samson's path-following law linearized."""

    OFFSET_GAIN = 4.0
    HEADING_GAIN = 4.0
    PREVIEW_M = 0.05

    def __init__(self, course: Course, start_m: float, speed_mps: float) -> None:
        self.course = course
        self._way_m = start_m
        self._speed_mps = speed_mps

    def twist(self, pose: TruePose) -> tuple[float, float]:
        """Linear (m/s) and angular (rad/s) speed to ask for at this pose."""
        self._way_m = self.course.nearest(pose.x, pose.y, self._way_m)
        x, y, heading = self.course.at(self._way_m)
        _, _, heading_ahead = self.course.at(self._way_m + self.PREVIEW_M)
        curvature = angle_difference(heading_ahead, heading) / self.PREVIEW_M
        offset_m = -math.sin(heading) * (pose.x - x) + math.cos(heading) * (pose.y - y)
        heading_error = angle_difference(pose.yaw, heading)
        speed = self._speed_mps
        return speed, speed * (curvature - self.OFFSET_GAIN * offset_m - self.HEADING_GAIN * heading_error)
