"""The trials of the fusion experiment: which run, which camera, which methods; each in a process of its own."""

import math
import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from agents.estimation import EkfEstimator
from geometry import SE2
from launcher.experiments.fusion_camera import Camera, deliveries
from launcher.experiments.fusion_methods import MAKERS, Fused
from launcher.experiments.fusion_runs import Recording, Run, simulated
from launcher.experiments.fusion_score import Trace, traced
from launcher.output import progress
from protocol.lab import Lab

Array = NDArray[np.float64]

BLIND_S = 8.0
_BLIND_EVERY_S = 30.0
_BLIND_FIRST_S = 22.0
PLAIN = ("odometry", "camera", "report", "exponential")


@dataclass(frozen=True, slots=True)
class Trial:
    """`group` says which figures it belongs to. `source` is a recording or the speed (m/s) of a simulated drive; `blind`: nothing
    is captured for 8 s of every 30 s. The `methods` are told of the same poses. `longest_s` cuts the run."""

    group: str
    source: Recording | float
    camera: Camera
    seed: int
    methods: tuple[str, ...]
    longest_s: float
    blind: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """`traces` by method; `blind` the intervals (s) without a capture; `constants` what the Kalman filter thinks of odometry and
    stamps at the end, empty where it took no part; `linear` is the true factor on odometry's way."""

    trial: Trial
    traces: dict[str, Trace]
    blind: tuple[tuple[float, float], ...]
    constants: dict[str, float]
    linear: float


def conduct(trials: Sequence[Trial], lab: Lab, workers: int) -> list[Outcome]:
    """All of them, in their order."""
    outcomes: list[Outcome] = []
    # Spawned, not forked: the parent may have threads. One thread each, the processes share the cores.
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        for outcome in pool.map(partial(conduct_one, lab=lab), trials):
            outcomes.append(outcome)
            progress(f"fusion: {len(outcomes)} of {len(trials)} trials")
    return outcomes


def conduct_one(trial: Trial, lab: Lab) -> Outcome:
    """UsageError when a recording cannot be read."""
    run = trial.source.load() if isinstance(trial.source, Recording) else _drive(trial, trial.source, lab)
    run = _cut(run, trial.longest_s)
    blind = _blind(run, trial.seed) if trial.blind else ()
    camera = replace(trial.camera, seen_s=math.inf) if trial.blind else trial.camera
    delivered = deliveries(run, camera, trial.seed, blind)
    start = SE2(*(float(value) for value in run.poses[0]))
    traces: dict[str, Trace] = {}
    constants: dict[str, float] = {}
    for name in trial.methods:
        method = MAKERS[name](start)
        traces[name] = traced(run, method, delivered)
        if (
            name in ("ekf", "ekf_camera_time")
            and isinstance(method, Fused)
            and isinstance(method.estimator, EkfEstimator)
        ):
            constants = constants or method.estimator.constants
    return Outcome(trial, traces, blind, constants, _linear(run))


def _drive(trial: Trial, speed_mps: float, lab: Lab) -> Run:
    return simulated(lab, speed_mps, trial.seed, trial.longest_s)


def _cut(run: Run, longest_s: float) -> Run:
    if longest_s >= run.duration_s:
        return run
    kept = run.seconds <= longest_s
    until_ns = run.start_ns + round(longest_s * 1e9)
    odometry = tuple(reading for reading in run.odometry if reading.stamp_ns <= until_ns)
    return replace(run, odometry=odometry, seconds=run.seconds[kept], poses=run.poses[kept])


def _blind(run: Run, seed: int) -> tuple[tuple[float, float], ...]:
    """Whole intervals only; where they lie depends on the seed."""
    first = _BLIND_FIRST_S + float(np.random.default_rng([seed, 8]).uniform(0.0, _BLIND_EVERY_S / 3.0))
    starts = np.arange(first, run.duration_s - BLIND_S - 1.0, _BLIND_EVERY_S)
    return tuple((float(start), float(start) + BLIND_S) for start in starts)


def _linear(run: Run) -> float:
    """The true way by odometry's, NaN where it did not move."""
    seconds = np.array([(reading.stamp_ns - run.start_ns) / 1e9 for reading in run.odometry])
    said = np.array([(reading.pose.x, reading.pose.y) for reading in run.odometry])
    true = run.truth(seconds)[:, :2]
    steps, true_steps = np.diff(said, axis=0), np.diff(true, axis=0)
    known = np.isfinite(true_steps).all(axis=1)
    way = float(np.hypot(steps[known, 0], steps[known, 1]).sum())
    return float(np.hypot(true_steps[known, 0], true_steps[known, 1]).sum()) / way if way > 0.0 else math.nan
