"""The model behind the Kalman filter: how odometry moves the state, what a camera sees of it, and all Jacobians. Pure.

The state: the pose of the rotation centre in the map frame, x and y (m) and yaw (rad); how odometry lies, `linear` and
`angular` (factors on its way and turn) and `curvature` (rad of turn per metre of way that it does not see, as with wheels of
different size); and `delay` (s), by how much capture stamps are late against the stamps of odometry.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, angle_difference, wrap_angle

Array = NDArray[np.float64]

X, Y, YAW, LINEAR, ANGULAR, CURVATURE, DELAY = range(7)
SIZE = 7
_SMALL_ANGLE_RAD = 1e-4
_SHORTEST_S = 1e-3
_LOWEST = np.array([-math.inf, -math.inf, -math.inf, 0.7, 0.6, -0.3, -0.4])
_HIGHEST = np.array([math.inf, math.inf, math.inf, 1.3, 1.4, 0.3, 0.6])
"""Beyond these no wheel and no camera is mistaken; an estimate that wants to go there is held."""


@dataclass(frozen=True, slots=True)
class Motion:
    """What odometry says happened within `dt_s`: the twist (forward m, left m, turn rad) held over that time."""

    forward_m: float
    left_m: float
    turn_rad: float
    dt_s: float

    @classmethod
    def between(cls, before: SE2, after: SE2, dt_s: float) -> "Motion":
        """From two poses in the odometry frame."""
        return cls(*before.between(after).log(), dt_s)


def moved(mean: Array, motion: Motion) -> Array:
    """The state (7,) after the motion."""
    forward, left, turn = _corrected(mean, motion)
    s, c = _arc(turn)
    ahead, aside = s * forward - c * left, c * forward + s * left
    cos, sin = math.cos(mean[YAW]), math.sin(mean[YAW])
    after = mean.copy()
    after[X] += cos * ahead - sin * aside
    after[Y] += sin * ahead + cos * aside
    after[YAW] = wrap_angle(float(mean[YAW]) + turn)
    return after


def motion_jacobians(mean: Array, motion: Motion) -> tuple[Array, Array]:
    """d moved / d state (7, 7), and d pose / d corrected twist (3, 3), through which noise of the wheels enters."""
    forward, left, turn = _corrected(mean, motion)
    s, c = _arc(turn)
    ds, dc = _arc_slopes(turn, s, c)
    cos, sin = math.cos(mean[YAW]), math.sin(mean[YAW])
    ahead, aside = s * forward - c * left, c * forward + s * left
    bent_ahead, bent_aside = ds * forward - dc * left, dc * forward + ds * left
    by_twist = np.array(
        [
            [cos * s - sin * c, -cos * c - sin * s, cos * bent_ahead - sin * bent_aside],
            [sin * s + cos * c, -sin * c + cos * s, sin * bent_ahead + cos * bent_aside],
            [0.0, 0.0, 1.0],
        ]
    )
    by_state = np.eye(SIZE)
    by_state[X, YAW] = -sin * ahead - cos * aside
    by_state[Y, YAW] = cos * ahead - sin * aside
    by_state[:3, LINEAR] = by_twist[:, 0] * motion.forward_m + by_twist[:, 1] * motion.left_m
    by_state[:3, ANGULAR] = by_twist[:, 2] * motion.turn_rad
    by_state[:3, CURVATURE] = by_twist[:, 2] * motion.forward_m
    return by_state, by_twist


def velocity(mean: Array, motion: Motion) -> Array:
    """x and y (m/s) in the map frame and the yaw rate (rad/s), (3,): those of the motion at this state."""
    forward, left, turn = _corrected(mean, motion)
    cos, sin = math.cos(mean[YAW]), math.sin(mean[YAW])
    return np.array([cos * forward - sin * left, sin * forward + cos * left, turn]) / max(motion.dt_s, _SHORTEST_S)


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """A camera's pose (3,) with its covariance (3, 3), looked up in odometry `delay_s` before its stamp, when the robot
    moved at `velocity` (3,) in the map frame."""

    pose: Array
    covariance: Array
    delay_s: float
    velocity: Array

    def innovation(self, mean: Array) -> Array:
        """The pose minus the predicted one (3,). The state's `delay` may have changed since the look-up; the robot was
        then as far from the place looked up as it goes in the difference."""
        late = self.velocity * (float(mean[DELAY]) - self.delay_s)
        difference = self.pose - mean[:3] + late
        difference[YAW] = angle_difference(float(self.pose[YAW]), float(mean[YAW] - late[YAW]))
        return difference

    def jacobian(self) -> Array:
        """d predicted pose / d state, (3, 7)."""
        by_state = np.zeros((3, SIZE))
        by_state[0, X] = by_state[1, Y] = by_state[2, YAW] = 1.0
        by_state[:, DELAY] = -self.velocity
        return by_state


def corrected(mean: Array, change: Array) -> Array:
    """The state plus a correction (7,), the yaw wrapped, the rest kept where wheels and cameras can be."""
    after = np.clip(mean + change, _LOWEST, _HIGHEST)
    after[YAW] = wrap_angle(float(after[YAW]))
    return after


def _corrected(mean: Array, motion: Motion) -> tuple[float, float, float]:
    """The true twist over the step."""
    linear = float(mean[LINEAR])
    turn = float(mean[ANGULAR]) * motion.turn_rad + float(mean[CURVATURE]) * motion.forward_m
    return linear * motion.forward_m, linear * motion.left_m, turn


def _arc(turn: float) -> tuple[float, float]:
    """sin(a)/a and (1 - cos(a))/a, the latter as 2 sin(a/2)^2 / a, which loses no digits at small angles."""
    if abs(turn) < _SMALL_ANGLE_RAD:
        return 1.0 - turn * turn / 6.0, turn / 2.0
    return math.sin(turn) / turn, 2.0 * math.sin(turn / 2.0) ** 2 / turn


def _arc_slopes(turn: float, s: float, c: float) -> tuple[float, float]:
    """The derivatives of both by a."""
    if abs(turn) < _SMALL_ANGLE_RAD:
        return -turn / 3.0, 0.5 - turn * turn / 8.0
    return (math.cos(turn) - s) / turn, (math.sin(turn) - c) / turn
