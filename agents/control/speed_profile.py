"""How fast a line may be driven: curves ahead, and braking for them. Pure; metres and seconds."""

import math

import numpy as np
from numpy.typing import NDArray

from agents.control.smooth_path import SmoothPath

Array = NDArray[np.float64]

_STRAIGHT = 1e-6
_JUMP_M = 0.01


class SpeedProfile:
    """The speed by the way along a line, such that braking by `braking_mps2` is always enough for what comes."""

    def __init__(self, path: SmoothPath, caps_mps: Array, braking_mps2: float) -> None:
        """`caps_mps` (N,): the most at each sample of the line."""
        self._ways = path.ways
        self._braking = braking_mps2
        # v^2 <= cap_j^2 + 2 b (s_j - s) for every place j ahead.
        reach = caps_mps**2 + 2.0 * braking_mps2 * path.ways
        self._reach = np.minimum.accumulate(reach[::-1])[::-1]

    def speed_mps(self, way_m: float) -> float:
        within = min(max(way_m, 0.0), float(self._ways[-1]))
        squared = float(np.interp(within, self._ways, self._reach)) - 2.0 * self._braking * within
        return math.sqrt(max(0.0, squared))


def curve_caps(
    path: SmoothPath, yaw_rate_radps: float, yaw_step_radps: float, lateral_mps2: float, slowest_mps: float
) -> Array:
    """The most at each sample (N,) such that neither the yaw rate, nor its change within a centimetre, nor the acceleration to
    the side is exceeded; never less than `slowest_mps`, so that the tightest bend is got through."""
    bent = np.maximum(np.abs(path.curvatures), _STRAIGHT)
    caps = np.minimum(yaw_rate_radps / bent, np.sqrt(lateral_mps2 / bent))
    jumps = np.abs(np.diff(path.curvatures)) * np.minimum(1.0, _JUMP_M / np.diff(path.ways))
    around = np.maximum(np.append(jumps, 0.0), np.append(0.0, jumps))
    return np.maximum(np.minimum(caps, yaw_step_radps / np.maximum(around, _STRAIGHT)), slowest_mps)


def braking_speed(left_m: float, braking_mps2: float, approach_per_s: float) -> float:
    """The speed with this way left to a halt: braking steadily, and in proportion to the way at the very end."""
    knee_m = braking_mps2 / approach_per_s**2
    if left_m <= knee_m:
        return approach_per_s * left_m
    return math.sqrt(2.0 * braking_mps2 * (left_m - knee_m / 2.0))
