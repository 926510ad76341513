"""The picture of the fusion experiment: errors over time, by speed, and while no camera sees the robot."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from launcher.experiments.fusion_runs import Recording
from launcher.experiments.fusion_score import Trace, rmse_mm
from launcher.experiments.fusion_trials import BLIND_S, PLAIN, Outcome

_COLOURS = {
    "odometry": "0.6",
    "camera": "tab:orange",
    "report": "tab:red",
    "exponential": "tab:purple",
    "ekf": "tab:blue",
}
_SHOWN_S = (20.0, 110.0)


def plot_fusion(outcomes: Sequence[Outcome], path: Path) -> None:
    """Writes a PNG; its folder is made when there is none. OSError when it cannot be written."""
    figure = Figure(figsize=(9.0, 10.5), layout="constrained")
    FigureCanvasAgg(figure)
    over_time, by_speed, blind = figure.subplots(3, 1)
    shown = next((o for o in outcomes if o.trial.group == "mrclam"), None)
    _draw_time(over_time, shown or next(o for o in outcomes if o.trial.group == "sim"))
    _draw_speeds(by_speed, [o for o in outcomes if o.trial.group == "sim"])
    _draw_blind(blind, [o for o in outcomes if o.blind])
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=90)


def _draw_time(axes: Axes, outcome: Outcome) -> None:
    source = outcome.trial.source
    ekf = "ekf_camera_time" if isinstance(source, Recording) else "ekf"
    for name in ("camera", "report", "exponential", ekf):
        trace = outcome.traces[name].within(*_SHOWN_S)
        label = "ekf" if name == ekf else name
        axes.semilogy(trace.seconds, trace.distances_m * 1e3, color=_COLOURS[label], linewidth=0.8, label=label)
    trace = outcome.traces[ekf].within(*_SHOWN_S)
    axes.semilogy(trace.seconds, 2.0 * _sigma_mm(trace), "k--", linewidth=0.8, label="ekf, 2 sigma claimed")
    title = source.name if isinstance(source, Recording) else f"simulated, {source:g} m/s"
    axes.set(title=f"{title}: outliers and gaps", xlabel="time (s)", ylabel="position error (mm)", ylim=(0.5, 3000))
    axes.legend(fontsize="small", ncols=5, loc="upper center")


def _draw_speeds(axes: Axes, outcomes: Sequence[Outcome]) -> None:
    speeds = sorted({float(o.trial.source) for o in outcomes if not isinstance(o.trial.source, Recording)})
    methods = (*PLAIN, "ekf")
    for place, method in enumerate(methods):
        heights = [rmse_mm([o.traces[method] for o in outcomes if o.trial.source == speed]) for speed in speeds]
        at = np.arange(len(speeds)) + (place - 2) * 0.16
        bars = axes.bar(at, heights, 0.15, color=_COLOURS[method], label=method)
        axes.bar_label(bars, fmt="%.0f", fontsize="x-small")
    axes.set(
        title="simulated, all cameras",
        ylabel="RMS position error (mm)",
        yscale="log",
        xticks=range(len(speeds)),
        ylim=(1, 2e4),
    )
    axes.set_xticklabels([f"{speed:g} m/s" for speed in speeds])
    axes.legend(fontsize="small", ncols=5, loc="upper center")


def _draw_blind(axes: Axes, outcomes: Sequence[Outcome]) -> None:
    """Each interval's error from its beginning, and twice the standard deviation that is claimed, on average."""
    sources = {
        "recorded runs": ("tab:green", [o for o in outcomes if isinstance(o.trial.source, Recording)]),
        "simulated, 0.3 m/s": ("tab:blue", [o for o in outcomes if o.trial.source == 0.3]),
        "simulated, 0.5 m/s": ("tab:cyan", [o for o in outcomes if o.trial.source == 0.5]),
    }
    grid = np.arange(0.0, BLIND_S, 0.05)
    for name, (colour, own) in sources.items():
        claimed: list[np.ndarray] = []
        for outcome in own:
            method = "ekf_camera_time" if "ekf_camera_time" in outcome.traces else "ekf"
            for since, until in outcome.blind:
                part = outcome.traces[method].within(since, until)
                if len(part.seconds) > 1:
                    axes.plot(part.seconds - since, part.distances_m * 1e3, color=colour, linewidth=0.4, alpha=0.5)
                    claimed.append(np.interp(grid, part.seconds - since, _sigma_mm(part)))
        if claimed:
            axes.plot(
                grid,
                2.0 * np.mean(claimed, axis=0),
                "--",
                color=colour,
                linewidth=1.8,
                label=f"{name}: 2 sigma claimed",
            )
    axes.axhline(250.0, color="black", linewidth=0.8)
    axes.set(
        title="no camera",
        xlabel="time since the last capture (s)",
        ylabel="position error (mm)",
        xlim=(0, BLIND_S),
        ylim=(0, 500),
    )
    axes.legend(fontsize="small", loc="upper left")


def _sigma_mm(trace: Trace) -> np.ndarray:
    """The larger axis of the claimed position covariance (N,)."""
    return np.sqrt(np.linalg.eigvalsh(trace.covariances[:, :2, :2])[:, 1]) * 1e3
