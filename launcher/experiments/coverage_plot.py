"""Heat maps of the floor: how far off poses are in each cell, and how many of the tags in view gave one."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from launcher.experiments.coverage_samples import Placements, grid
from protocol.lab import Lab

Array = NDArray[np.float64]


def plot_coverage(lab: Lab, placements: Placements, cell_m: float, path: Path) -> None:
    """Writes a PNG; its folder is made when there is none. OSError when it cannot be written."""
    edges = grid(lab, cell_m)
    figure = Figure(figsize=(9.0, 10.0), layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1)
    tracked = placements.tracked
    errors_mm = np.hypot(*placements.errors[:, :2].T) * 1e3
    median = _by_cell(placements.places[tracked], errors_mm[tracked], edges)
    _heat_map(above, edges, median, "median position error (mm)", "viridis", 0.0, float(np.nanmax(median)))
    seen = placements.visible > 0
    shares = placements.found[seen] / placements.visible[seen]
    share = _by_cell(placements.places[seen], shares, edges, mean=True)
    _heat_map(below, edges, share, "share of the tags in view that gave a pose", "RdYlGn", 0.9, 1.0)
    for axes in (above, below):
        _draw_room(axes, lab)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=100)


def _by_cell(places: Array, values: Array, edges: tuple[Array, Array], *, mean: bool = False) -> Array:
    """The median (or mean) of the values (N,) in each cell, (rows, columns); NaN where there is none."""
    xs, ys = edges
    columns = np.clip(np.searchsorted(xs, places[:, 0], side="right") - 1, 0, len(xs) - 2)
    rows = np.clip(np.searchsorted(ys, places[:, 1], side="right") - 1, 0, len(ys) - 2)
    cells = np.full((len(ys) - 1, len(xs) - 1), np.nan)
    for row, column in set(zip(rows.tolist(), columns.tolist(), strict=True)):
        inside = values[(rows == row) & (columns == column)]
        cells[row, column] = float(np.mean(inside) if mean else np.median(inside))
    return cells


def _heat_map(
    axes: Axes, edges: tuple[Array, Array], cells: Array, title: str, colours: str, low: float, high: float
) -> None:
    mesh = axes.pcolormesh(*edges, np.ma.masked_invalid(cells), cmap=colours, vmin=low, vmax=high)
    figure = axes.get_figure()
    assert figure is not None
    figure.colorbar(mesh, ax=axes, shrink=0.8)
    axes.set(title=title, xlabel="x (m)", ylabel="y (m)", aspect="equal", facecolor="0.85")


def _draw_room(axes: Axes, lab: Lab) -> None:
    """Areas, floor tags and where the cameras hang."""
    for area in lab.areas:
        outline = np.array([*area.outline, area.outline[0]])
        axes.plot(outline[:, 0], outline[:, 1], color="black", linewidth=1)
    tags = np.array([pose[:2] for pose in lab.floor_tags.poses.values()])
    axes.plot(tags[:, 0], tags[:, 1], "s", color="white", markeredgecolor="black", markersize=6, label="floor tags")
    mounts = np.array([lab.simulation.mounts[camera.id].position[:2] for camera in lab.cameras])
    axes.plot(mounts[:, 0], mounts[:, 1], "^", color="black", markersize=7, label="cameras")
    axes.legend(loc="upper center", ncols=2, fontsize="small")
