"""What a drive of the route experiment is worth: how far beside the drawn line, how long, how smoothly, how near to its end."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from launcher.experiments.route_drive import Track, ideal_s

Array = NDArray[np.float64]

SAMPLE_M = 0.01
"""Offsets count once per so much of the way, so that standing and creeping count no more than driving."""
_BACK_M, _FORTH_M = 0.3, 0.5
_SMOOTHED_S = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """`offsets_m` (N,): distances of the rotation centre from the drawn line. `stop_error_m`: from the line's end, standing."""

    offsets_m: Array
    duration_s: float
    ideal_s: float
    stop_error_m: float
    heading_error_rad: float | None
    jerk_rms_mps3: float
    arrived: bool


def scored(track: Track) -> Score:
    course = track.trial.course
    end_x, end_y, end_yaw = (float(value) for value in track.poses[-1])
    x, y = course.points[-1]
    yaw = course.yaw_rad
    return Score(
        offsets_m=offsets(track.poses[:, :2], np.array(course.points)),
        duration_s=track.duration_s,
        ideal_s=ideal_s(track.trial),
        stop_error_m=math.hypot(end_x - x, end_y - y),
        heading_error_rad=None if yaw is None else abs(math.remainder(end_yaw - yaw, math.tau)),
        jerk_rms_mps3=jerk_rms(track),
        arrived=track.arrived,
    )


def offsets(places: Array, line: Array) -> Array:
    """Distances (m) of the places (N, 2), taken every centimetre of way, from a polyline (M, 2). The nearest place on the line is
    sought around the last one, so that a line that comes back to itself is not taken for its other part."""
    steps = np.hypot(*np.diff(places, axis=0).T)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    chosen = np.searchsorted(way, np.arange(0.0, way[-1] + 1e-9, SAMPLE_M))
    found = np.empty(len(chosen))
    along_m = 0.0
    for index, place in enumerate(places[np.minimum(chosen, len(places) - 1)]):
        found[index], along_m = _nearest(place, line, along_m)
    return found


def jerk_rms(track: Track) -> float:
    """Root of the mean square of the second derivative of the forward speed (m/s^3), which is smoothed over a quarter of a
    second (Savitzky and Golay 1964, third order); until the vehicle stands for good."""
    step_s = float(track.seconds[1] - track.seconds[0])
    window = 2 * round(_SMOOTHED_S / step_s / 2.0) + 1
    jerk = savgol_filter(track.twists[:, 0], window, 3, deriv=2, delta=step_s)
    driven = track.seconds <= track.duration_s
    return float(np.sqrt(np.mean(jerk[driven] ** 2)))


def _nearest(place: Array, line: Array, along_m: float) -> tuple[float, float]:
    """Distance from the line, and the way along it, within a window around `along_m`."""
    steps = np.diff(line, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    begins = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    low = np.clip((along_m - _BACK_M - begins) / lengths, 0.0, 1.0)
    high = np.clip((along_m + _FORTH_M - begins) / lengths, 0.0, 1.0)
    shares = np.clip(np.einsum("ij,ij->i", place - line[:-1], steps) / lengths**2, low, high)
    apart = place - line[:-1] - shares[:, None] * steps
    distances = np.hypot(apart[:, 0], apart[:, 1])
    outside = (begins + lengths < along_m - _BACK_M) | (begins > along_m + _FORTH_M)
    distances[outside] = math.inf
    best = int(np.argmin(distances))
    return float(distances[best]), float(begins[best] + shares[best] * lengths[best])


def pooled_mm(scores: Sequence[Score], percent: float) -> float:
    """A percentile of all offsets of these drives."""
    return float(np.percentile(np.concatenate([score.offsets_m for score in scores]), percent)) * 1e3
