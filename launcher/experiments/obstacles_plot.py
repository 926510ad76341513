"""The picture of the obstacles experiment: reaction times by who watched, how near robots came, and some of their detours."""

from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from launcher.experiments.detour_scenes import CLEARANCE_M, outline_of
from launcher.experiments.detour_trials import DetourTrial
from launcher.experiments.obstacle_trials import Trial, Watcher
from protocol.lab import Lab

_COLOURS = {Watcher.CAMERA: "tab:orange", Watcher.SCANNER: "tab:blue", Watcher.BOTH: "tab:green"}


def plot_obstacles(lab: Lab, trials: Sequence[Trial], detours: Sequence[DetourTrial], path: Path) -> None:
    """Writes a PNG; its folder is made when there is none. OSError when it cannot be written."""
    figure = Figure(figsize=(12.0, 13.0), layout="constrained")
    FigureCanvasAgg(figure)
    (reactions, gaps), (clearances, first), (second, third) = figure.subplots(3, 2)
    _draw_reactions(reactions, trials)
    _draw_gaps(gaps, trials)
    _draw_clearances(clearances, detours)
    for axes, trial in zip_longest((first, second, third), _to_show(detours)[:3]):
        if trial is None:
            axes.set_axis_off()
        else:
            _draw_floor(axes, lab, trial)
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


def _to_show(detours: Sequence[DetourTrial]) -> list[DetourTrial]:
    """Two detours around the most pallets, and one scene without a way; or what there is."""
    by_count = sorted(detours, key=lambda trial: len(trial.things), reverse=True)
    around = [trial for trial in by_count if trial.way]
    return [*around[:2], *[trial for trial in by_count if not trial.way][:1], *around[2:]]


def _draw_clearances(axes: Axes, detours: Sequence[DetourTrial]) -> None:
    clearances = [trial.clearance_m for trial in detours if trial.clearance_m is not None]
    axes.hist(clearances, bins=np.arange(0.0, 0.65, 0.02).tolist(), color="tab:green")
    axes.axvline(CLEARANCE_M, color="tab:red", linewidth=0.8)
    found = sum(trial.arrived for trial in detours if trial.way)
    title = f"{found} of {sum(trial.way for trial in detours)} detours driven: least distance from pallets"
    axes.set(title=title, xlabel="distance (m)", ylabel="detours")
    axes.grid(alpha=0.3)


def _draw_floor(axes: Axes, lab: Lab, trial: DetourTrial) -> None:
    for area in lab.areas:
        axes.fill(*zip(*area.outline, strict=True), facecolor="0.95", edgecolor="0.6")
    for thing in trial.things:
        axes.fill(*np.asarray(outline_of(thing).exterior.coords).T, color="tab:brown")
    axes.plot(*zip(*trial.points, strict=True), "--", color="tab:blue", label="route")
    axes.plot(*zip(*trial.track, strict=True), color="tab:green", label="driven")
    axes.plot(*trial.points[-1], "o", color="tab:blue", markersize=4)
    what = "arrived" if trial.arrived else "waits"
    axes.set(title=f"scene {trial.seed}: {what}", aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.legend(fontsize="small")
