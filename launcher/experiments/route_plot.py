"""The picture of the route experiment: where vehicles drove, how far beside the line, and how fast."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from launcher.experiments.route_drive import Track
from launcher.experiments.route_score import SAMPLE_M, offsets

_COLOURS = {"gpss": "tab:red", "go_to_goal": "tab:orange", "frenet": "tab:blue"}
_GAP_M = 1.2


def plot_route(tracks: Sequence[Track], path: Path) -> None:
    """Writes a PNG with a row for each vehicle: the courses side by side, the offsets' distribution, and the speed on one
    course; of the first seed. Its folder is made when there is none. OSError when it cannot be written."""
    kinds = list(dict.fromkeys(track.trial.vehicle.id for track in tracks))
    figure = Figure(figsize=(15.0, 5.2 * len(kinds)), layout="constrained")
    FigureCanvasAgg(figure)
    rows = figure.subfigures(len(kinds), 1, squeeze=False)[:, 0]
    for kind, row in zip(kinds, rows, strict=True):
        own = [track for track in tracks if track.trial.vehicle.id == kind]
        first = [track for track in own if track.trial.seed == own[0].trial.seed]
        axes = row.subplot_mosaic([["floor", "floor"], ["spread", "speed"]], height_ratios=(1.25, 1.0))
        _draw_floor(axes["floor"], first, kind)
        _draw_spread(axes["spread"], own)
        _draw_speed(axes["speed"], first)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80)


def _draw_floor(axes: Axes, tracks: Sequence[Track], kind: str) -> None:
    right_m = 0.0
    for name in dict.fromkeys(track.trial.course.name for track in tracks):
        own = [track for track in tracks if track.trial.course.name == name]
        line = np.array(own[0].trial.course.points)
        shift = right_m - line[:, 0].min()
        axes.plot(line[:, 0] + shift, line[:, 1], color="0.75", linewidth=3.0)
        for track in own:
            controller = track.trial.controller
            axes.plot(track.poses[:, 0] + shift, track.poses[:, 1], color=_COLOURS[controller], linewidth=0.8)
        axes.text(right_m, -0.8, name, fontsize="small")
        right_m += float(np.ptp(line[:, 0])) + _GAP_M
    axes.set(title=kind, ylabel="m", aspect="equal", ylim=(-1.1, 3.1))


def _draw_spread(axes: Axes, tracks: Sequence[Track]) -> None:
    """The share of the way with at most this offset."""
    for controller in dict.fromkeys(track.trial.controller for track in tracks):
        own = [track for track in tracks if track.trial.controller == controller]
        found = np.sort(
            np.concatenate([offsets(track.poses[:, :2], np.array(track.trial.course.points)) for track in own])
        )
        axes.semilogx(
            np.maximum(found * 1e3, 0.1),
            np.linspace(0.0, 1.0, len(found)),
            color=_COLOURS[controller],
            label=controller,
        )
    axes.axhline(0.95, color="0.6", linewidth=0.6)
    axes.set(
        xlabel="offset from the line (mm)", ylabel=f"share of the way (each {SAMPLE_M * 100:.0f} cm)", xlim=(0.5, 500)
    )
    axes.legend(fontsize="small", loc="upper left")


def _draw_speed(axes: Axes, tracks: Sequence[Track]) -> None:
    name = "corners" if any(track.trial.course.name == "corners" for track in tracks) else tracks[0].trial.course.name
    for track in tracks:
        if track.trial.course.name == name:
            axes.plot(track.seconds, track.twists[:, 0], color=_COLOURS[track.trial.controller], linewidth=0.8)
    axes.set(title=name, xlabel="time (s)", ylabel="speed (m/s)")
