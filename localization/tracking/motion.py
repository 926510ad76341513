"""The motion model of a vehicle's filter: its twist stays as it is, disturbed by accelerations.

State: x, y (m), yaw (rad) of the rotation centre in the map frame; forward and sideways speed (m/s) in the vehicle's frame;
yaw rate (rad/s). With no sideways speed it is the constant-turn-rate-and-velocity model (CTRV; Schubert et al. 2008, sec.
III), with the chord's direction taken at half the turn; the sideways speed lets it follow what is pushed or slides.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from geometry import wrap_angle
from protocol.lab import Limits

Array = NDArray[np.float64]

X, Y, YAW, FORWARD, SIDEWAYS, TURN = range(6)
_SLIDE_SHARE = 0.3
"""Sideways acceleration relative to forward: wheels hold, but not perfectly, and hands push robots."""


@dataclass(frozen=True, slots=True)
class Agility:
    """Standard deviations of the accelerations that the model does not know of: m/s^2, m/s^2, rad/s^2."""

    forward: float
    sideways: float
    turn: float

    @classmethod
    def of(cls, limits: Limits) -> Self:
        """Half of what the vehicle can do at most: its limits are two sigmas."""
        strongest = max(limits.acceleration_mps2, limits.braking_mps2) / 2
        return cls(strongest, _SLIDE_SHARE * strongest, limits.yaw_acceleration_radps2 / 2)


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Mean (6,) and covariance (6, 6) at a time (ns since the epoch). The mean's yaw is within (-pi, pi]."""

    stamp_ns: int
    mean: Array
    covariance: Array


def start(stamp_ns: int, pose: Array, covariance: Array, limits: Limits) -> State:
    """The state after a first sight: the pose (3,) as measured, standing still as far as the limits allow to say so."""
    mean = np.zeros(6)
    mean[:3] = pose
    full = np.zeros((6, 6))
    full[:3, :3] = covariance
    full[FORWARD, FORWARD] = limits.speed_mps**2
    full[SIDEWAYS, SIDEWAYS] = (_SLIDE_SHARE * limits.speed_mps) ** 2
    full[TURN, TURN] = limits.yaw_rate_radps**2
    return State(stamp_ns, mean, full)


def predict(state: State, stamp_ns: int, agility: Agility) -> State:
    """The state at a later (or a little earlier) time; the covariance grows either way."""
    dt = (stamp_ns - state.stamp_ns) * 1e-9
    if dt == 0.0:
        return state
    x, y, yaw, forward, sideways, turn = (float(value) for value in state.mean)
    c, s = math.cos(yaw + turn * dt / 2), math.sin(yaw + turn * dt / 2)
    dx, dy = (forward * c - sideways * s) * dt, (forward * s + sideways * c) * dt
    mean = np.array([x + dx, y + dy, wrap_angle(yaw + turn * dt), forward, sideways, turn])
    jacobian = np.eye(6)
    jacobian[X, YAW], jacobian[Y, YAW] = -dy, dx
    jacobian[X, FORWARD], jacobian[Y, FORWARD] = c * dt, s * dt
    jacobian[X, SIDEWAYS], jacobian[Y, SIDEWAYS] = -s * dt, c * dt
    jacobian[X, TURN], jacobian[Y, TURN] = -dy * dt / 2, dx * dt / 2
    jacobian[YAW, TURN] = dt
    half, span = dt * dt / 2, abs(dt)
    noise = np.zeros((6, 3))
    noise[X, 0], noise[Y, 0], noise[FORWARD, 0] = c * half, s * half, span
    noise[X, 1], noise[Y, 1], noise[SIDEWAYS, 1] = -s * half, c * half, span
    noise[YAW, 2], noise[TURN, 2] = half, span
    noise *= (agility.forward, agility.sideways, agility.turn)
    return State(stamp_ns, mean, jacobian @ state.covariance @ jacobian.T + noise @ noise.T)


@dataclass(frozen=True, slots=True, eq=False)
class Innovation:
    """What a measured pose says beyond the prediction: difference (3,), its covariance (3, 3), and the squared Mahalanobis
    distance."""

    difference: Array
    covariance: Array
    distance2: float


def innovation(state: State, pose: Array, covariance: Array) -> Innovation:
    """A pose (3,) with covariance (3, 3), measured at the state's time."""
    difference = pose - state.mean[:3]
    difference[2] = wrap_angle(float(difference[2]))
    total = state.covariance[:3, :3] + covariance
    return Innovation(difference, total, float(difference @ np.linalg.solve(total, difference)))


def correct(state: State, seen: Innovation) -> State:
    """The Kalman update; the covariance stays symmetric."""
    gain = np.linalg.solve(seen.covariance, state.covariance[:3, :]).T
    mean = state.mean + gain @ seen.difference
    mean[YAW] = wrap_angle(float(mean[YAW]))
    covariance = state.covariance - gain @ seen.covariance @ gain.T
    return State(state.stamp_ns, mean, (covariance + covariance.T) / 2)


def map_velocity(state: State) -> tuple[float, float]:
    """vx, vy in the map frame, m/s."""
    yaw, forward, sideways = (float(state.mean[i]) for i in (YAW, FORWARD, SIDEWAYS))
    c, s = math.cos(yaw), math.sin(yaw)
    return forward * c - sideways * s, forward * s + sideways * c
