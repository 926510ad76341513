"""The motion model of a vehicle's filter: constant turn rate, and an acceleration that fades.

State: x, y (m), yaw (rad) of the rotation centre in the map frame; forward and sideways speed (m/s) in the vehicle's frame;
yaw rate (rad/s); forward acceleration (m/s^2). It is the constant-turn-rate-and-acceleration model (CTRA; Schubert et al.
2008, sec. III) with the chord's direction taken at half the turn. The acceleration is Singer's (1970): correlated over
`FADING_S`, so that how fast doubt grows does not depend on how many cameras look how often. The sideways speed lets the state
follow what is pushed or slides.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from geometry import wrap_angle
from protocol.lab import Limits

Array = NDArray[np.float64]

X, Y, YAW, FORWARD, SIDEWAYS, TURN, ACCELERATION = range(7)
MOTION = 7
"""How many numbers say how a vehicle moves."""
FADING_S = 0.5
"""Time constant of the forward acceleration."""
_JERK_S = 0.1
"""So long do sideways and turning accelerations last."""
SLIDE_SHARE = 0.3
"""Sideways acceleration relative to forward: wheels hold, but not perfectly, and hands push robots."""


@dataclass(frozen=True, slots=True)
class Agility:
    """Standard deviations of the accelerations: m/s^2, m/s^2, rad/s^2."""

    forward: float
    sideways: float
    turn: float

    @classmethod
    def of(cls, limits: Limits) -> Self:
        """Half of what the vehicle can do at most: its limits are two sigmas."""
        strongest = max(limits.acceleration_mps2, limits.braking_mps2) / 2
        return cls(strongest, SLIDE_SHARE * strongest, limits.yaw_acceleration_radps2 / 2)


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """What a span of time does: the mean after it (7,), how that moves with the mean before it (7, 7), and the covariance (7, 7)
    of what happened that nobody knows of."""

    mean: Array
    jacobian: Array
    noise: Array


def move(mean: Array, dt: float, agility: Agility) -> Step:
    """The motion (7,) after `dt` seconds (or a little earlier, where it is negative; doubt grows either way).

    Noise is that of a white jerk along the way (Bar-Shalom et al. 2001, sec. 6.2.3), which is Singer's for spans below his time
    constant and no less for longer ones, and of white accelerations across it and of the heading (sec. 6.2.2).
    """
    x, y, yaw, forward, sideways, turn, acceleration = mean.tolist()
    c, s = math.cos(yaw + turn * dt / 2), math.sin(yaw + turn * dt / 2)
    fade = math.exp(-dt / FADING_S)
    gained = FADING_S * (1.0 - fade)
    reached = FADING_S * (dt - gained)
    along = forward * dt + acceleration * reached
    across = sideways * dt
    dx, dy = along * c - across * s, along * s + across * c
    moved = np.array(
        [
            x + dx,
            y + dy,
            wrap_angle(yaw + turn * dt),
            forward + acceleration * gained,
            sideways,
            turn,
            acceleration * fade,
        ]
    )
    half = dt / 2
    jacobian = np.array(
        [
            [1.0, 0.0, -dy, c * dt, -s * dt, -dy * half, c * reached],
            [0.0, 1.0, dx, s * dt, c * dt, dx * half, s * reached],
            [0.0, 0.0, 1.0, 0.0, 0.0, dt, 0.0],
            [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, gained],
            [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, fade],
        ]
    )
    span = abs(dt)
    span2 = span * span
    span3 = span2 * span
    sign = 1.0 if dt >= 0 else -1.0
    jerk = 2.0 * agility.forward**2 / FADING_S
    slide, spin = agility.sideways**2 * _JERK_S, agility.turn**2 * _JERK_S
    pp, pv, pa = jerk * span3 * span2 / 20, sign * jerk * span2 * span2 / 8, jerk * span3 / 6
    vv, va, aa = jerk * span3 / 3, sign * jerk * span2 / 2, jerk * span
    qq, qw, ww = slide * span3 / 3, sign * slide * span2 / 2, slide * span
    hh, ht, tt = spin * span3 / 3, sign * spin * span2 / 2, spin * span
    xy = c * s * (pp - qq)
    noise = np.array(
        [
            [c * c * pp + s * s * qq, xy, 0.0, c * pv, -s * qw, 0.0, c * pa],
            [xy, s * s * pp + c * c * qq, 0.0, s * pv, c * qw, 0.0, s * pa],
            [0.0, 0.0, hh, 0.0, 0.0, ht, 0.0],
            [c * pv, s * pv, 0.0, vv, 0.0, 0.0, va],
            [-s * qw, c * qw, 0.0, 0.0, ww, 0.0, 0.0],
            [0.0, 0.0, ht, 0.0, 0.0, tt, 0.0],
            [c * pa, s * pa, 0.0, va, 0.0, 0.0, aa],
        ]
    )
    return Step(moved, jacobian, noise)


def map_velocity(mean: Array) -> tuple[float, float]:
    """vx, vy in the map frame, m/s."""
    _, _, yaw, forward, sideways, *_ = mean[:MOTION].tolist()
    c, s = math.cos(yaw), math.sin(yaw)
    return forward * c - sideways * s, forward * s + sideways * c


def map_acceleration(mean: Array) -> tuple[float, float]:
    """ax, ay in the map frame, m/s^2: the forward acceleration, and the velocity's turning (v times yaw rate, to the left)."""
    _, _, yaw, forward, sideways, turn, acceleration = mean[:MOTION].tolist()
    c, s = math.cos(yaw), math.sin(yaw)
    along, left = acceleration - sideways * turn, forward * turn
    return along * c - left * s, along * s + left * c
