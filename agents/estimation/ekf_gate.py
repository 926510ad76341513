"""The gate in front of the Kalman filter, and the way out when it is the filter that is wrong.

A pose that is too unlikely is refused. Outliers of a camera contradict one another; poses that agree with one another, given
the way between them, contradict the filter: the robot was lifted elsewhere, or the filter began with an outlier.
"""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, angle_difference

Array = NDArray[np.float64]

GATE_NIS = 16.27
"""Chi-square of 3 degrees of freedom: one right pose in a thousand is refused."""
AGREEING = 5
"""So many refused poses that agree, the newest among them, with none used in between, begin anew."""
_REMEMBERED = 4 * AGREEING
_SPAN_NS = 10_000_000_000
_AGREE_NIS = 16.27
_WAY_SHARE = 0.1
"""Odometry is trusted to this share of its way and turn when poses are compared."""


@dataclass(frozen=True, slots=True, eq=False)
class Refused:
    """A pose (3,) with its covariance (3, 3) that did not pass, and where odometry was then."""

    stamp_ns: int
    T_odom_robot: SE2
    pose: Array
    covariance: Array


class Recovery:
    """The refused poses since the last one that was used."""

    def __init__(self) -> None:
        self._refused: deque[Refused] = deque(maxlen=_REMEMBERED)

    def clear(self) -> None:
        """A pose was used, or everything began anew."""
        self._refused.clear()

    def add(self, refused: Refused) -> bool:
        """Whether the filter is to begin anew from this pose."""
        recent = [other for other in self._refused if abs(refused.stamp_ns - other.stamp_ns) <= _SPAN_NS]
        self._refused.append(refused)
        return 1 + _agreeing(recent, refused) >= AGREEING


def _agreeing(others: Iterable[Refused], newest: Refused) -> int:
    return sum(1 for other in others if _agree(other, newest))


def _agree(before: Refused, after: Refused) -> bool:
    way = before.T_odom_robot.between(after.T_odom_robot)
    expected = SE2(float(before.pose[0]), float(before.pose[1]), float(before.pose[2])) @ way
    length = (way.x**2 + way.y**2) ** 0.5
    difference = np.array(
        [
            after.pose[0] - expected.x,
            after.pose[1] - expected.y,
            angle_difference(float(after.pose[2]), expected.yaw),
        ]
    )
    aside = (_WAY_SHARE**2 + float(before.covariance[2, 2])) * length**2
    turn = (_WAY_SHARE * abs(way.yaw)) ** 2 + (_WAY_SHARE * length) ** 2
    covariance = before.covariance + after.covariance + np.diag([aside, aside, turn]) + 1e-12 * np.eye(3)
    return float(difference @ np.linalg.solve(covariance, difference)) <= _AGREE_NIS
