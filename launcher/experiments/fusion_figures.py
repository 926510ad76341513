"""The figures of the fusion experiment, from the traces of its trials (docs/experiments.md, "Fusion")."""

from collections.abc import Mapping, Sequence

import numpy as np

from launcher.errors import UsageError
from launcher.experiments.fusion_runs import Recording
from launcher.experiments.fusion_score import SETTLED_S, Trace, heading_rmse_deg, rmse_mm
from launcher.experiments.fusion_trials import PLAIN, Outcome
from launcher.experiments.nees import Consistency, consistency

BLIND_SPEED_MPS = 0.3
"""The simulated speed that counts for `blind_8s_max_mm`: at higher ones the wheels' slip alone leads further away."""
_COMPENSATED_FROM_MPS = 0.5
_BLOCK_S = 60.0
"""A recorded run is cut into such blocks for the consistency."""


def figures(outcomes: Sequence[Outcome]) -> dict[str, float | int]:
    """Everything that was measured."""
    groups = {
        name: [outcome for outcome in outcomes if outcome.trial.group == name]
        for name in ("mrclam", "mrclam_blind", "sim", "sim_blind", "sim_late")
    }
    found: dict[str, float | int] = {}
    if groups["mrclam"]:
        found |= _recorded_figures(groups["mrclam"])
    found |= _simulated_figures(groups["sim"])
    found |= _blind_figures(groups["sim_blind"], groups["mrclam_blind"])
    found |= _late_figures(groups["sim_late"])
    found |= _consistency_figures(groups["sim"], groups["mrclam"])
    return found


def _recorded_figures(outcomes: Sequence[Outcome]) -> dict[str, float | int]:
    found: dict[str, float | int] = {"mrclam_runs": len({_name(outcome) for outcome in outcomes})}
    for key, method in (*((name, name) for name in PLAIN), ("ekf", "ekf_camera_time"), ("ekf_odometry_time", "ekf")):
        traces = [outcome.traces[method] for outcome in outcomes if method in outcome.traces]
        found[f"mrclam_{key}_rmse_mm"] = rmse_mm(traces)
        found[f"mrclam_{key}_heading_rmse_deg"] = heading_rmse_deg(traces)
    for name in sorted({_name(outcome) for outcome in outcomes}):
        own = [outcome for outcome in outcomes if _name(outcome) == name]
        key = "".join(letter if letter.isalnum() else "_" for letter in name.lower())
        found[f"mrclam_{key}_ekf_rmse_mm"] = rmse_mm([outcome.traces["ekf_camera_time"] for outcome in own])
        found[f"mrclam_{key}_ekf_delay_ms"] = own[0].constants["delay_s"] * 1e3
    return found


def _simulated_figures(outcomes: Sequence[Outcome]) -> dict[str, float | int]:
    found: dict[str, float | int] = {"sim_runs": len(outcomes)}
    speeds = sorted({_speed(outcome) for outcome in outcomes})
    for method in (*PLAIN, "ekf", "ekf_uncompensated"):
        traces = [outcome.traces[method] for outcome in outcomes]
        found[f"sim_{method}_rmse_mm"] = rmse_mm(traces)
        found[f"sim_{method}_heading_rmse_deg"] = heading_rmse_deg(traces)
        for speed in speeds:
            own = [outcome.traces[method] for outcome in outcomes if _speed(outcome) == speed]
            found[f"sim_{_cmps(speed)}_{method}_rmse_mm"] = rmse_mm(own)
    gains = [
        found[f"sim_{_cmps(speed)}_ekf_uncompensated_rmse_mm"] / found[f"sim_{_cmps(speed)}_ekf_rmse_mm"]
        for speed in speeds
        if speed >= _COMPENSATED_FROM_MPS
    ]
    found["delay_compensation_gain"] = min(gains)
    for delay_s in sorted({outcome.trial.camera.delay_s for outcome in outcomes}):
        own = [o for o in outcomes if o.trial.camera.delay_s == delay_s and _speed(o) >= _COMPENSATED_FROM_MPS]
        without, with_it = (rmse_mm([o.traces[name] for o in own]) for name in ("ekf_uncompensated", "ekf"))
        found[f"delay_compensation_gain_{round(delay_s * 1e3)}_ms"] = without / with_it
    found["ekf_linear_error_max"] = max(abs(o.constants["linear"] - o.linear) for o in outcomes)
    return found


def _blind_figures(simulated: Sequence[Outcome], recorded: Sequence[Outcome]) -> dict[str, float | int]:
    """The largest errors until the first pose after the blindness arrives."""
    found: dict[str, float | int] = {}
    counting = [outcome for outcome in simulated if _speed(outcome) == BLIND_SPEED_MPS]
    for method in (*PLAIN, "ekf"):
        of_recorded = "ekf_camera_time" if method == "ekf" else method
        worst = [_blind_max_mm(counting, method)]
        if recorded:
            worst.append(_blind_max_mm(recorded, of_recorded))
            found[f"mrclam_{method}_blind_8s_max_mm"] = worst[-1]
        found["blind_8s_max_mm" if method == "ekf" else f"{method}_blind_8s_max_mm"] = max(worst)
    found["blind_8s_windows"] = sum(len(outcome.blind) for outcome in (*counting, *recorded))
    for speed in sorted({_speed(outcome) for outcome in simulated}):
        own = [outcome for outcome in simulated if _speed(outcome) == speed]
        found[f"sim_{_cmps(speed)}_blind_8s_max_mm"] = _blind_max_mm(own, "ekf")
        found[f"sim_{_cmps(speed)}_blind_8s_rmse_mm"] = _blind_end_rmse_mm(own, "ekf")
    for group, outcomes, method in (("sim", simulated, "ekf"), ("mrclam", recorded, "ekf_camera_time")):
        if outcomes:
            inside = np.concatenate([part.nees for outcome in outcomes for part in _blind_parts(outcome, method)])
            found[f"{group}_blind_8s_nees_median"] = float(np.median(inside))
    return found


def _late_figures(outcomes: Sequence[Outcome]) -> dict[str, float | int]:
    found: dict[str, float | int] = {
        f"late_stamps_{method}_rmse_mm": rmse_mm([outcome.traces[method] for outcome in outcomes])
        for method in ("exponential", "ekf")
    }
    off_s = (abs(outcome.constants["delay_s"] - outcome.trial.camera.stamps_late_s) for outcome in outcomes)
    found["ekf_delay_error_max_ms"] = max(off_s) * 1e3
    return found


def _consistency_figures(simulated: Sequence[Outcome], recorded: Sequence[Outcome]) -> dict[str, float | int]:
    """NEES over x, y and yaw; 3 is right. A simulated run counts as one sample of a band's width, a minute of a recording as
    another: how much these scatter says how many independent errors each is worth."""
    drives = [outcome.traces["ekf"].nees for outcome in simulated]
    minutes = [block.nees for outcome in recorded for block in _blocks(outcome.traces["ekf_camera_time"])]
    found: dict[str, float | int] = {}
    for key, blocks in (("ekf_nees", drives + minutes), ("sim_ekf_nees", drives), ("mrclam_ekf_nees", minutes)):
        if len(blocks) >= 2:
            found |= _band(key, consistency(blocks, 3))
    return found


def _band(key: str, honest: Consistency) -> Mapping[str, float]:
    return {
        f"{key}_mean": honest.mean,
        f"{key}_low": honest.low,
        f"{key}_high": honest.high,
        f"{key}_independent": honest.independent,
    }


def _blocks(trace: Trace) -> list[Trace]:
    starts = np.arange(SETTLED_S, float(trace.seconds[-1]) - 0.5 * _BLOCK_S, _BLOCK_S)
    blocks = [trace.within(float(start), float(start) + _BLOCK_S) for start in starts]
    return [block for block in blocks if len(block.seconds)]


def _blind_parts(outcome: Outcome, method: str) -> list[Trace]:
    delay_s = outcome.trial.camera.delay_s
    parts = [outcome.traces[method].within(since, until + delay_s) for since, until in outcome.blind]
    return [part for part in parts if len(part.seconds)]


def _blind_max_mm(outcomes: Sequence[Outcome], method: str) -> float:
    parts = [part for outcome in outcomes for part in _blind_parts(outcome, method)]
    if not parts:
        raise UsageError("the runs are too short for 8 s of blindness")
    return max(float(part.distances_m.max()) for part in parts) * 1e3


def _blind_end_rmse_mm(outcomes: Sequence[Outcome], method: str) -> float:
    ends = [part.distances_m[-1] for outcome in outcomes for part in _blind_parts(outcome, method)]
    return float(np.sqrt(np.mean(np.square(ends)))) * 1e3


def _name(outcome: Outcome) -> str:
    assert isinstance(outcome.trial.source, Recording)
    return outcome.trial.source.name


def _speed(outcome: Outcome) -> float:
    assert isinstance(outcome.trial.source, float)
    return outcome.trial.source


def _cmps(speed_mps: float) -> str:
    return f"{round(speed_mps * 100)}_cmps"
