"""Runs compared as the reports do: tables with percent change, box plots, time graphs (GulliView 2024 and 2025, sec. 3.1.4,
4.1)."""

from launcher.timing_report.comparison import Comparison, LabelledRun, compare
from launcher.timing_report.plots import draw_boxes, draw_graph
from launcher.timing_report.published import PUBLISHED, PublishedBox
from launcher.timing_report.table import as_figures, as_table, published_figures

__all__ = [
    "PUBLISHED",
    "Comparison",
    "LabelledRun",
    "PublishedBox",
    "as_figures",
    "as_table",
    "compare",
    "draw_boxes",
    "draw_graph",
    "published_figures",
]
