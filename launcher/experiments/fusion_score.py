"""One method over one run as the agent would have it: odometry and estimates twenty times a second, cameras as they come."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.pacing import CONTROL_RATE_HZ
from launcher.experiments.fusion_camera import Delivery
from launcher.experiments.fusion_methods import Method
from launcher.experiments.fusion_runs import Run
from launcher.experiments.nees import nees

Array = NDArray[np.float64]

SETTLED_S = 10.0
"""Errors count from this long after the start."""


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """At each moment of asking `seconds` (N,): the error (N, 3) of the pose against the truth of that very moment, x, y (m) and
    yaw (rad), and the covariance (N, 3, 3) that was claimed, NaN where none was; `positions` (N, 2) are the estimated ones."""

    seconds: Array
    errors: Array
    covariances: Array
    positions: Array

    def within(self, since_s: float, until_s: float) -> "Trace":
        """A part of it."""
        part = (self.seconds >= since_s) & (self.seconds < until_s)
        return Trace(self.seconds[part], self.errors[part], self.covariances[part], self.positions[part])

    @property
    def distances_m(self) -> Array:
        """Position errors (N,)."""
        return np.hypot(self.errors[:, 0], self.errors[:, 1])

    @property
    def nees(self) -> Array:
        """(N,), over x, y and yaw."""
        return nees(self.errors, self.covariances)


def traced(run: Run, method: Method, delivered: Sequence[Delivery]) -> Trace:
    """All moments for which there is a pose and the truth is known, from SETTLED_S on."""
    seconds = np.arange(0.0, run.duration_s, 1.0 / CONTROL_RATE_HZ)
    truth = run.truth(seconds)
    rows: list[tuple[float, ...]] = []
    next_camera = next_odometry = 0
    for second, true in zip(seconds, truth, strict=True):
        now_ns = run.start_ns + round(float(second) * 1e9)
        while next_camera < len(delivered) and delivered[next_camera].arrival_ns <= now_ns:
            method.camera(delivered[next_camera].pose, delivered[next_camera].arrival_ns)
            next_camera += 1
        newest = next_odometry
        while newest < len(run.odometry) and run.odometry[newest].stamp_ns <= now_ns:
            newest += 1
        if newest > next_odometry:
            method.odometry(run.odometry[newest - 1])
            next_odometry = newest
        estimate = method.estimate(now_ns)
        if estimate.pose is not None and second >= SETTLED_S and np.isfinite(true).all():
            pose, covariance = estimate.pose, estimate.covariance or (np.nan,) * 6
            off = np.remainder(pose.yaw - true[2] + np.pi, 2 * np.pi) - np.pi
            rows.append((float(second), pose.x - true[0], pose.y - true[1], off, *covariance, pose.x, pose.y))
    table = np.array(rows, dtype=np.float64).reshape(-1, 12)
    covariances = table[:, [4, 5, 6, 5, 7, 8, 6, 8, 9]].reshape(-1, 3, 3)
    return Trace(table[:, 0], table[:, 1:4], covariances, table[:, 10:])


def rmse_mm(traces: Sequence[Trace]) -> float:
    """Root of the mean squared distance over all moments of all traces."""
    return float(np.sqrt(np.mean(np.concatenate([trace.distances_m for trace in traces]) ** 2)) * 1e3)


def heading_rmse_deg(traces: Sequence[Trace]) -> float:
    """Root of the mean squared yaw error over all moments of all traces."""
    return float(np.degrees(np.sqrt(np.mean(np.concatenate([trace.errors[:, 2] for trace in traces]) ** 2))))
