"""Box plots and time graphs as PNG, one panel per stage."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from launcher.timing_report.comparison import Comparison, LabelledRun
from launcher.timing_report.published import PublishedBox
from protocol.timings import downsample, outliers

_COLUMNS = 4
_MOST_OUTLIERS, _MOST_POINTS = 300, 400
_COLORS = ("#1164b1", "#d9730d", "#2a9d5c", "#9c36b5", "#c92a2a", "#6a7280")
_PUBLISHED_COLOR = "#4a515e"
_HEADROOM = 2.5
"""The axis ends at this many times the highest whisker: a single frame of seconds must not flatten the boxes."""


def draw_boxes(
    path: Path, comparisons: Sequence[Comparison], runs: Sequence[LabelledRun], published: Sequence[PublishedBox] = ()
) -> None:
    """Boxes from Q1 to Q3 with the median, whiskers to the last value within 1.5 IQR, outliers as points (thinned out when
    there are very many), the reports' printed boxes in grey beside them. An arrow says how high outliers go that are above
    the axis."""
    figure, panels = _panels(len(comparisons), f"Stage timings, {_names(runs)}")
    for axes, comparison in zip(panels, comparisons, strict=True):
        stats: list[dict[str, Any]] = []
        colors: list[str] = []
        for index, (each, found) in enumerate(zip(runs, comparison.boxes, strict=True)):
            if found is not None:
                beyond = outliers(each.run.values(comparison.kind, comparison.stage)[1], found, _MOST_OUTLIERS)
                stats.append(
                    _drawn(each.label, found.low, found.q1, found.median, found.q3, found.high, beyond.tolist())
                )
                colors.append(_COLORS[index % len(_COLORS)])
        for printed in published:
            if (printed.kind, printed.stage) == (comparison.kind, comparison.stage):
                low, q1, q3, high = (printed.median if v is None else v for v in _edges(printed))
                stats.append(_drawn(f"{printed.label}\n(published)", low, q1, printed.median, q3, high, []))
                colors.append(_PUBLISHED_COLOR)
        drawn = axes.bxp(stats, patch_artist=True, widths=0.55, flierprops={"markersize": 2.5, "alpha": 0.4})
        for patch, color in zip(drawn["boxes"], colors, strict=True):
            patch.set(facecolor=color, alpha=0.55)
        for line in drawn["medians"]:
            line.set(color="black", linewidth=1.4)
        axes.set_title(f"{comparison.kind}: {comparison.stage}", fontsize=10)
        axes.set_ylabel("ms")
        _scale(axes, stats)
        axes.tick_params(axis="x", labelrotation=20, labelsize=7)
        axes.grid(axis="y", alpha=0.3)
    figure.savefig(path, dpi=110)


def draw_graph(path: Path, comparisons: Sequence[Comparison], runs: Sequence[LabelledRun]) -> None:
    """Each stage over the time since the run's first frame: the median of each short while, and its highest value as a thin
    line."""
    figure, panels = _panels(len(comparisons), f"Stage timings over time, {_names(runs)}")
    starts = [each.run.span_ns[0] for each in runs]
    for axes, comparison in zip(panels, comparisons, strict=True):
        for index, (each, start_ns) in enumerate(zip(runs, starts, strict=True)):
            stamps, values = each.run.values(comparison.kind, comparison.stage)
            if values.size:
                series = downsample(stamps, values, start_ns, _MOST_POINTS)
                color = _COLORS[index % len(_COLORS)]
                axes.plot(series.seconds, series.highest, color=color, linewidth=0.5, alpha=0.5)
                axes.plot(series.seconds, series.median, color=color, linewidth=1.3, label=each.label)
        axes.set_title(f"{comparison.kind}: {comparison.stage}", fontsize=10)
        axes.set_ylabel("ms")
        axes.set_xlabel("s")
        axes.set_ylim(bottom=0)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=7)
    figure.savefig(path, dpi=110)


def _scale(axes: Axes, stats: Sequence[dict[str, Any]]) -> None:
    top = _HEADROOM * max(stat["whishi"] for stat in stats)
    axes.set_ylim(bottom=0)
    if top <= 0.0 or top >= axes.get_ylim()[1]:
        return
    axes.set_ylim(top=top)
    for place, stat in enumerate(stats, 1):
        highest = max(stat["fliers"], default=0.0)
        if highest > top:
            axes.annotate(f"↑ {highest:.3g}", (place, top), ha="center", va="top", fontsize=7)


def _panels(count: int, title: str) -> tuple[Figure, list[Axes]]:
    columns = min(_COLUMNS, max(1, count))
    rows = -(-count // columns)
    figure = Figure(figsize=(3.6 * columns, 3.3 * rows + 0.4), layout="constrained")
    figure.suptitle(title, fontsize=11)
    return figure, [figure.add_subplot(rows, columns, number + 1) for number in range(count)]


def _names(runs: Sequence[LabelledRun]) -> str:
    return " and ".join(each.label for each in runs)


def _edges(printed: PublishedBox) -> tuple[float | None, float | None, float | None, float | None]:
    return printed.low, printed.q1, printed.q3, printed.high


def _drawn(
    label: str, low: float, q1: float, median: float, q3: float, high: float, fliers: list[float]
) -> dict[str, Any]:
    return {"label": label, "whislo": low, "q1": q1, "med": median, "q3": q3, "whishi": high, "fliers": fliers}
