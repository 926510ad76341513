"""Statistics of the reports' box plots, defined once (GulliView 2024, sec. 3.1.4; Tukey, Exploratory Data Analysis, 1977).

- quartiles: linear interpolation between the order statistics (Hyndman and Fan 1996, definition 7; numpy's and matplotlib's
  default);
- whiskers: the smallest and largest value within 1.5 interquartile ranges of the box; these are the tables' min and max
  (without outliers);
- outliers: everything beyond the whiskers;
- percent change: of a value against the same of the first run.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

WHISKER_IQR = 1.5


@dataclass(frozen=True, slots=True)
class Box:
    """A box plot's numbers, in the unit of the values: `low` and `high` are the whiskers, `outliers` how many values lie beyond
    them, `p99` the 99 % quantile of all."""

    count: int
    low: float
    q1: float
    median: float
    q3: float
    high: float
    mean: float
    p99: float
    outliers: int


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """Values over time, thinned out: `seconds` (n,) since the start asked for, the bins' centres; the `median` and `highest`
    (n,) of what falls into each."""

    seconds: NDArray[np.float64]
    median: NDArray[np.float64]
    highest: NDArray[np.float64]


def box(values: NDArray[np.floating]) -> Box | None:
    """Of values (n,), of which NaN do not count; None when there are none."""
    known = _known(values)
    if known.size == 0:
        return None
    q1, median, q3, p99 = (float(value) for value in np.percentile(known, [25, 50, 75, 99]))
    low, high = _whiskers(known, q1, q3)
    beyond = int(np.count_nonzero((known < low) | (known > high)))
    return Box(known.size, low, q1, median, q3, high, float(known.mean()), p99, beyond)


def outliers(values: NDArray[np.floating], of: Box, most: int) -> NDArray[np.float64]:
    """The values beyond the whiskers, ascending; at most so many, evenly spread over their ranks, extremes included."""
    known = _known(values)
    beyond = np.sort(known[(known < of.low) | (known > of.high)])
    if beyond.size <= most:
        return beyond
    return beyond[np.linspace(0, beyond.size - 1, most).round().astype(int)]


def downsample(stamps_ns: NDArray[np.int64], values: NDArray[np.floating], start_ns: int, points: int) -> Series:
    """At most so many points over the time that the stamps (n,) span; the values (n,) that are NaN do not count."""
    known = ~np.isnan(values)
    order = np.argsort(stamps_ns[known], kind="stable")
    seconds = (stamps_ns[known][order] - start_ns) * 1e-9
    ordered = values[known][order].astype(np.float64)
    if seconds.size == 0:
        empty = np.empty(0)
        return Series(empty, empty, empty)
    edges = np.linspace(seconds[0], seconds[-1], points + 1)
    cuts = np.searchsorted(seconds, edges[1:-1])
    bins = [
        ((edges[n] + edges[n + 1]) / 2, float(np.median(part)), float(part.max()))
        for n, part in enumerate(np.split(ordered, cuts))
        if part.size
    ]
    at, median, highest = (np.array(column) for column in zip(*bins, strict=True))
    return Series(at, median, highest)


def change_percent(value: float, reference: float) -> float | None:
    """By how much the value differs from the reference; None when that is zero."""
    return None if reference == 0.0 else 100.0 * (value - reference) / reference


def _known(values: NDArray[np.floating]) -> NDArray[np.float64]:
    known = values.astype(np.float64)
    return known[~np.isnan(known)]


def _whiskers(known: NDArray[np.float64], q1: float, q3: float) -> tuple[float, float]:
    reach = WHISKER_IQR * (q3 - q1)
    inside = known[(known >= q1 - reach) & (known <= q3 + reach)]
    # Between two far values the interpolated quartile may lie beyond every value within reach: the whisker ends at the box.
    low = min(float(inside.min()), q1) if inside.size else q1
    high = max(float(inside.max()), q3) if inside.size else q3
    return low, high
