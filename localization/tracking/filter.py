"""The Kalman filter of one vehicle, with what its cameras have wrong among its unknowns.

A calibration that is 1 mm off puts every frame of its camera 1 mm off: such an error does not average away, and a filter that
takes it for noise becomes surer than right and jumps to and fro between cameras. So each camera's error is estimated with
the vehicle's motion (Friedland 1969, the augmented form): where one camera alone sees the vehicle, the pose stays as unsure as
the calibration; where two do, their difference tells both errors, and the estimate glides from one to the other.

Errors are kept in units of their own standard deviations: a camera's is F (sqrt(c) u + sqrt(1 - c) w), F the factor of the
sight's systematic covariance at its place (`Sight.bias`), u (3,) shared by all cameras and w (3,) the camera's own, each N(0, 1)
beforehand. u is what neighbours have in common: floor tags that both were calibrated with, and the tag's height. As the vehicle
drives on they lose their hold over `_LENGTH_M` (Gauss-Markov, Bar-Shalom et al. 2001, sec. 8.2), since a calibration's error
is another at another place.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import wrap_angle
from localization.tracking.motion import (
    ACCELERATION,
    FORWARD,
    MOTION,
    SIDEWAYS,
    SLIDE_SHARE,
    TURN,
    YAW,
    Agility,
    move,
)
from localization.tracking.sight import Sight
from protocol.lab import Limits

Array = NDArray[np.float64]

_SHARED = slice(MOTION, MOTION + 3)
_FIRST_CAMERA = MOTION + 3
_COMMON = 0.3
"""The share c of the variance that cameras have in common."""
_OF_ALL, _OF_ONE = math.sqrt(_COMMON), math.sqrt(1.0 - _COMMON)
_LENGTH_M = 4.0
"""About the floor that one ceiling camera sees: at its other end the calibration's error is another."""
_MOST_CAMERAS = 6
"""So many cameras' errors are kept; of more, the one known worst is forgotten."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Mean (n,) and covariance (n, n) at a time (ns since the epoch), n = 10 + 3 len(cameras): the motion (see `motion`), the
    shared error, each camera's own. The mean's yaw is within (-pi, pi]."""

    stamp_ns: int
    mean: Array
    covariance: Array
    cameras: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Innovation:
    """What a sight says beyond the prediction: difference (3,), its covariance (3, 3), and the covariance (n, 3) of the state
    with it. `state` is the prediction, with the sight's camera among its unknowns."""

    state: State
    difference: Array
    covariance: Array
    cross: Array


def start(sight: Sight, limits: Limits) -> State:
    """The state after a first sight: the pose as measured, standing still as far as the limits allow to say so."""
    mean = np.zeros(_FIRST_CAMERA + 3)
    mean[:3] = sight.pose
    covariance = np.zeros((_FIRST_CAMERA + 3, _FIRST_CAMERA + 3))
    covariance[:3, :3] = sight.covariance
    covariance[FORWARD, FORWARD] = limits.speed_mps**2
    covariance[SIDEWAYS, SIDEWAYS] = (SLIDE_SHARE * limits.speed_mps) ** 2
    covariance[TURN, TURN] = limits.yaw_rate_radps**2
    covariance[ACCELERATION, ACCELERATION] = Agility.of(limits).forward ** 2
    covariance[MOTION:, MOTION:] = np.eye(6)
    covariance[:3, _SHARED], covariance[:3, _FIRST_CAMERA:] = -_OF_ALL * sight.bias, -_OF_ONE * sight.bias
    covariance[MOTION:, :3] = covariance[:3, MOTION:].T
    return State(sight.stamp_ns, mean, covariance, (sight.camera,))


def predict(state: State, stamp_ns: int, agility: Agility) -> State:
    """The state at a later (or a little earlier) time; the covariance grows either way."""
    dt = (stamp_ns - state.stamp_ns) * 1e-9
    if dt == 0.0:
        return state
    step = move(state.mean[:MOTION], dt, agility)
    forward, sideways = float(state.mean[FORWARD]), float(state.mean[SIDEWAYS])
    kept = math.exp(-abs(dt) * math.hypot(forward, sideways) / _LENGTH_M)
    mean = kept * state.mean
    mean[:MOTION] = step.mean
    before = state.covariance
    covariance = (kept * kept) * before
    covariance.flat[(len(mean) + 1) * MOTION :: len(mean) + 1] += 1.0 - kept * kept
    top = step.jacobian @ before[:MOTION]
    covariance[:MOTION, :MOTION] = top[:, :MOTION] @ step.jacobian.T + step.noise
    covariance[:MOTION, MOTION:] = rest = kept * top[:, MOTION:]
    covariance[MOTION:, :MOTION] = rest.T
    return State(stamp_ns, mean, covariance, state.cameras)


def innovation(state: State, sight: Sight) -> Innovation:
    """What a sight says of a state of its own time."""
    if sight.camera not in state.cameras:
        state = _with_camera(state, sight.camera)
    first = _FIRST_CAMERA + 3 * state.cameras.index(sight.camera)
    own = slice(first, first + 3)
    of_all, of_one = _OF_ALL * sight.bias, _OF_ONE * sight.bias
    mean, full = state.mean, state.covariance
    difference = sight.pose - mean[:3] - of_all @ mean[_SHARED] - of_one @ mean[own]
    difference[YAW] = wrap_angle(float(difference[YAW]))
    cross = full[:, :3] + full[:, _SHARED] @ of_all.T + full[:, own] @ of_one.T
    covariance = cross[:3] + of_all @ cross[_SHARED] + of_one @ cross[own] + sight.noise
    return Innovation(state, difference, covariance, cross)


def distance2(seen: Innovation, extra: Array) -> float:
    """The squared Mahalanobis distance, with the covariance `extra` (3, 3) allowed for besides."""
    return float(seen.difference @ inverse(seen.covariance + extra) @ seen.difference)


def correct(seen: Innovation) -> State:
    """The Kalman update; the covariance stays symmetric."""
    state = seen.state
    gain = seen.cross @ inverse(seen.covariance)
    mean = state.mean + gain @ seen.difference
    mean[YAW] = wrap_angle(float(mean[YAW]))
    covariance = state.covariance - gain @ seen.cross.T
    covariance += covariance.T.copy()
    covariance *= 0.5
    return State(state.stamp_ns, mean, covariance, state.cameras)


def inverse(matrix: Array) -> Array:
    """The inverse of a symmetric (3, 3) matrix by its adjugate: LAPACK takes several times as long for so little."""
    (a, b, c), (_, d, e), (_, _, f) = matrix.tolist()
    aa, bb, cc = d * f - e * e, c * e - b * f, b * e - c * d
    scale = 1.0 / (a * aa + b * bb + c * cc)
    dd, ee, ff = a * f - c * c, b * c - a * e, a * d - b * b
    return scale * np.array([[aa, bb, cc], [bb, dd, ee], [cc, ee, ff]])


def _with_camera(state: State, camera: str) -> State:
    if len(state.cameras) >= _MOST_CAMERAS:
        state = _without_worst(state)
    size = len(state.mean)
    mean = np.zeros(size + 3)
    mean[:size] = state.mean
    covariance = np.zeros((size + 3, size + 3))
    covariance[:size, :size] = state.covariance
    covariance[size:, size:] = np.eye(3)
    return State(state.stamp_ns, mean, covariance, (*state.cameras, camera))


def _without_worst(state: State) -> State:
    variances = np.diag(state.covariance)[_FIRST_CAMERA:].reshape(-1, 3).sum(axis=1)
    worst = int(np.argmax(variances))
    keep = np.delete(np.arange(len(state.mean)), np.arange(3) + _FIRST_CAMERA + 3 * worst)
    cameras = (*state.cameras[:worst], *state.cameras[worst + 1 :])
    return State(state.stamp_ns, state.mean[keep], state.covariance[np.ix_(keep, keep)], cameras)
