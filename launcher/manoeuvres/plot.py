"""The picture of a traffic situation: delays by scenario, as the report's figure 5.5, and the speeds of one run of each."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from launcher.manoeuvres.table import PUBLISHED_MEAN, Row

_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red")


def plot_situation(situation: str, rows: Sequence[Row], path: Path) -> None:
    """Writes a PNG; its folder is made when there is none. OSError when it cannot be written."""
    figure = Figure(figsize=(11.0, 3.2 + 2.0 * len(rows)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(rows) + 1, 1, squeeze=False)[:, 0]
    places = np.arange(len(rows))
    bars = (
        ("the report's algorithm", [row.reported.fk for row in rows], "tab:orange"),
        ("ours", [row.ours.fk for row in rows], "tab:blue"),
        ("optimum within the zones", [row.zones.fk for row in rows], "0.6"),
        ("optimum of the bodies", [row.bodies.fk for row in rows], "0.8"),
    )
    for index, (label, heights, colour) in enumerate(bars):
        axes[0].bar(places + 0.2 * (index - 1.5), np.array(heights) - 1, 0.19, bottom=1, color=colour, label=label)
    axes[0].axhline(PUBLISHED_MEAN[situation], color="tab:red", linestyle="--", label="published mean")
    axes[0].set_xticks(places, [row.scenario.name for row in rows])
    axes[0].set(
        ylabel="FK",
        ylim=(1.0, max(max(heights) for _, heights, _ in bars) + 0.15),
        title=f"{situation}: time through by time alone",
    )
    axes[0].legend(fontsize="small", ncols=3)
    for row, below in zip(rows, axes[1:], strict=True):
        for style, method in (("-", row.ours), ("--", row.reported)):
            for colour, (robot, trace) in zip(_COLOURS, sorted(method.last.traces.items()), strict=False):
                times, _, speeds = zip(*trace, strict=True)
                label = f"{robot}, {'ours' if style == '-' else 'the report'}"
                below.plot(times, speeds, style, color=colour, linewidth=1.2, label=label)
        below.set(ylabel="m/s", title=f"{row.scenario.name}: speeds of one run")
        below.grid(alpha=0.3)
        below.legend(fontsize="x-small", ncols=4)
    axes[-1].set_xlabel("time (s)")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80)
