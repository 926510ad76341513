"""The picture of the obstacles experiment: reaction times by who watched, and how near robots came."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from launcher.experiments.obstacle_trials import Trial, Watcher

_COLOURS = {Watcher.CAMERA: "tab:orange", Watcher.SCANNER: "tab:blue", Watcher.BOTH: "tab:green"}


def plot_obstacles(trials: Sequence[Trial], path: Path) -> None:
    """Writes a PNG; its folder is made when there is none. OSError when it cannot be written."""
    figure = Figure(figsize=(9.0, 9.0), layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1)
    _draw_reactions(above, trials)
    _draw_gaps(below, trials)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=90)


def _draw_reactions(axes: Axes, trials: Sequence[Trial]) -> None:
    """The share of stops that took no longer than so long."""
    groups = [(str(w), _COLOURS[w], "-", [t for t in trials if t.watcher is w and t.kind != "drop"]) for w in Watcher]
    people = [t for t in trials if t.watcher is Watcher.SCANNER and t.kind == "person"]
    groups[list(Watcher).index(Watcher.SCANNER)] = ("scanner, people", _COLOURS[Watcher.SCANNER], "-", people)
    groups.append(("scanner, drops", "tab:blue", ":", [t for t in trials if t.kind == "drop"]))
    for label, colour, style, group in groups:
        reactions = sorted(trial.reaction_s for trial in group if trial.reaction_s is not None)
        if reactions:
            shares = np.arange(1, len(reactions) + 1) / len(reactions)
            axes.step(
                reactions, shares, where="post", color=colour, linestyle=style, label=f"{label} ({len(reactions)})"
            )
    axes.axhline(0.95, color="0.6", linewidth=0.8)
    axes.set(title="from the thing in the field to wheels that stand", xlabel="time (s)", ylabel="share of the stops")
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)


def _draw_gaps(axes: Axes, trials: Sequence[Trial]) -> None:
    for watcher in Watcher:
        own = [trial for trial in trials if trial.watcher is watcher and trial.kind != "drop"]
        axes.plot(
            [trial.speed_mps for trial in own],
            [trial.gap_m for trial in own],
            ".",
            color=_COLOURS[watcher],
            label=str(watcher),
        )
    axes.axhline(0.0, color="tab:red", linewidth=0.8)
    axes.set(title="least distance from the thing", xlabel="commanded speed (m/s)", ylabel="distance (m)")
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
