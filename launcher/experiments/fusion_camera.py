"""A camera made from the truth: noise, delay, stamps that are late, outliers and gaps, all by a seed."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from launcher.experiments.fusion_runs import Run
from protocol.messages import TrackedPose

Array = NDArray[np.float64]

_OUTLIER_M = (0.1, 2.0)
_JITTER = 0.2


@dataclass(frozen=True, slots=True)
class Camera:
    """`rate_hz` poses a second with Gaussian noise of `sigma_m` in x and in y and `sigma_rad` in yaw, which its covariance
    tells. They arrive after `delay_s`, 20 % more or less at random, so that quick ones overtake; their stamps are late by
    `stamps_late_s`.

    A share of `outliers` is anything: off by 0.1 to 2 m (even in the logarithm) in any direction, half of them turned by any
    angle too; they claim the covariance of the others. After each `seen_s` on average (exponential; infinite: no gaps) nothing
    is seen for 0.5 to `gap_s` seconds.
    """

    rate_hz: float
    delay_s: float
    sigma_m: float
    sigma_rad: float
    outliers: float = 0.0
    seen_s: float = math.inf
    gap_s: float = 3.0
    stamps_late_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Delivery:
    """A pose and when it arrives (ns)."""

    arrival_ns: int
    pose: TrackedPose


def deliveries(run: Run, camera: Camera, seed: int, blind: tuple[tuple[float, float], ...] = ()) -> list[Delivery]:
    """What the camera says of a run in the order of arrival; nothing is captured within the `blind` intervals (s)."""
    rng = np.random.default_rng([seed, 77])
    seconds = np.arange(float(rng.uniform(0.0, 1.0 / camera.rate_hz)), run.duration_s, 1.0 / camera.rate_hz)
    hidden = [*blind, *_gaps(camera, run.duration_s, rng)]
    visible = np.ones(len(seconds), dtype=bool)
    for since, until in hidden:
        visible &= (seconds < since) | (seconds >= until)
    sigma = (camera.sigma_m, camera.sigma_m, camera.sigma_rad)
    poses = run.truth(seconds) + rng.standard_normal((len(seconds), 3)) * sigma
    poses += _outliers(len(seconds), camera.outliers, rng)
    delays = camera.delay_s * (1.0 + rng.uniform(-_JITTER, _JITTER, len(seconds)))
    visible &= np.isfinite(poses).all(axis=1)
    found = [
        Delivery(
            run.start_ns + round(float(second + delay) * 1e9),
            _pose(run.start_ns + round(float(second + camera.stamps_late_s) * 1e9), pose, camera),
        )
        for second, pose, delay in zip(seconds[visible], poses[visible], delays[visible], strict=True)
    ]
    return sorted(found, key=lambda delivery: delivery.arrival_ns)


def _gaps(camera: Camera, duration_s: float, rng: np.random.Generator) -> list[tuple[float, float]]:
    found: list[tuple[float, float]] = []
    at_s = 0.0
    while math.isfinite(camera.seen_s):
        at_s += float(rng.exponential(camera.seen_s))
        if at_s >= duration_s:
            break
        length_s = float(rng.uniform(0.5, camera.gap_s))
        found.append((at_s, at_s + length_s))
        at_s += length_s
    return found


def _outliers(count: int, share: float, rng: np.random.Generator) -> Array:
    """What is added to each pose (count, 3): nothing but for the share."""
    chosen = rng.random(count) < share
    nearest, farthest = (math.log(distance_m) for distance_m in _OUTLIER_M)
    distance = np.exp(rng.uniform(nearest, farthest, count))
    direction = rng.uniform(-math.pi, math.pi, count)
    turn = rng.uniform(-math.pi, math.pi, count) * (rng.random(count) < 0.5)
    off = np.column_stack([distance * np.cos(direction), distance * np.sin(direction), turn])
    return off * chosen[:, None]


def _pose(stamp_ns: int, pose: Array, camera: Camera) -> TrackedPose:
    x, y, yaw = (float(value) for value in pose)
    variance = camera.sigma_m**2
    return TrackedPose(
        vehicle="robot",
        stamp_ns=stamp_ns,
        x=x,
        y=y,
        yaw=math.remainder(yaw, math.tau),
        vx=0.0,
        vy=0.0,
        yaw_rate=0.0,
        covariance=(variance, 0.0, 0.0, variance, 0.0, camera.sigma_rad**2),
        cameras=("camera",),
    )
