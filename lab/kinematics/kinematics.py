"""The interface of a kind's kinematics: a twist to hold goes in, the way on the ground and what the encoders say come out."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from geometry import SE2

_SLIP_TIME_CONSTANT_S = 0.5
"""How long a wheel keeps slipping about as much as it does now."""


@dataclass(frozen=True, slots=True)
class Chance:
    """One step's draw for two wheels: how much of the described slip each has now (0..1), and standard normal noise of its
    encoder."""

    slip: tuple[float, float]
    noise: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Motion:
    """What one step would do: the true pose it leads to, the way (m) and turn (rad) of the rotation centre on the ground,
    how far the wheels roll (m, for the battery), and the raw readings of the kind's two encoders."""

    pose: SE2
    way_m: float
    turn_rad: float
    rolled_m: float
    encoders: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Measured:
    """What the base believes of one step: way (m) and turn (rad) of its rotation centre, and its twist (m/s, rad/s)."""

    way_m: float
    turn_rad: float
    linear_mps: float
    angular_radps: float


class Kinematics(Protocol):
    """One base's. After a `plan` comes either `commit` or `stall`."""

    def plan(self, pose: SE2, target: tuple[float, float], chance: Chance, step_s: float) -> Motion:
        """Moves the motors on towards the twist `target` (m/s, rad/s; within the vehicle's limits)."""
        ...

    def commit(self, motion: Motion, step_s: float) -> Measured:
        """The way was free: what the encoders make of it."""
        ...

    def stall(self) -> None:
        """Something stands in the way: motors and wheels stand still."""
        ...


class Wander:
    """A share that wanders within 0..1 around a half and keeps for about as long as a wheel slips alike."""

    def __init__(self, rng: np.random.Generator, time_constant_s: float = _SLIP_TIME_CONSTANT_S) -> None:
        self._rng = rng
        self._time_constant_s = time_constant_s
        self._share = 0.5

    def step(self, step_s: float) -> float:
        """The share after one step; draws one number."""
        self._share = wandered(self._share, float(self._rng.standard_normal()), step_s, self._time_constant_s)
        return self._share


def wandered(share: float, draw: float, step_s: float, time_constant_s: float = _SLIP_TIME_CONSTANT_S) -> float:
    """A first-order Gauss-Markov step around 0.5 with a standard deviation of 0.3, clipped to 0..1."""
    keep = math.exp(-step_s / time_constant_s)
    return min(1.0, max(0.0, 0.5 + keep * (share - 0.5) + 0.3 * math.sqrt(1.0 - keep * keep) * draw))


def rolled(pose: SE2, way_m: float, turn_rad: float) -> SE2:
    """The pose after that way and turn of the rotation centre, along the chord at the heading of mid-step."""
    heading = pose.yaw + turn_rad / 2.0
    return SE2(pose.x + way_m * math.cos(heading), pose.y + way_m * math.sin(heading), pose.yaw + turn_rad)


def approached(current: float, target: float, faster: float, slower: float) -> float:
    """One step towards the target: at most `faster` when gaining speed, at most `slower` when losing it; a change of
    direction passes through standstill."""
    if current * target < 0.0:
        target = 0.0
    limit = slower if abs(target) < abs(current) else faster
    return current + min(max(target - current, -limit), limit)
