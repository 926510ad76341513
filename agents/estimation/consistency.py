"""Whether a filter is as good as it thinks: the mean of its latest normalised innovations squared (Bar-Shalom et al. 2001,
sec. 5.4.2). It needs no truth, so it can be watched on the robot."""

import math
from collections import deque
from dataclasses import dataclass

_DIMENSION = 3
_FEWEST = 30
_QUANTILE = 3.290527
"""Of the normal distribution, at 99.95 %."""


@dataclass(frozen=True, slots=True)
class NisReport:
    """`mean` of the latest `count` NIS of a pose (3 when covariances are right), `low` and `high` around 99.9 % of such means,
    and how many poses were used and refused by the gate since the start."""

    mean: float
    low: float
    high: float
    count: int
    used: int
    refused: int

    @property
    def is_consistent(self) -> bool:
        """Within the band; True as long as there are too few to tell."""
        return self.count < _FEWEST or self.low <= self.mean <= self.high

    def __str__(self) -> str:
        verdict = "consistent" if self.is_consistent else "NOT consistent"
        return (
            f"{verdict}, mean NIS {self.mean:.2f} over {self.count} poses (99.9 % within {self.low:.2f} to {self.high:.2f}), "
            f"{self.used} poses used and {self.refused} refused so far"
        )


class NisWatch:
    """Remembers the latest `window` values; those that the gate refused are only counted."""

    def __init__(self, window: int = 200) -> None:
        self._values: deque[float] = deque(maxlen=window)
        self._used = self._refused = 0

    def add_used(self, nis: float) -> None:
        self._values.append(nis)
        self._used += 1

    def add_refused(self) -> None:
        self._refused += 1

    def report(self) -> NisReport:
        count = len(self._values)
        mean = sum(self._values) / count if count else 0.0
        low, high = mean_nis_band(count) if count else (0.0, math.inf)
        return NisReport(mean, low, high, count, self._used, self._refused)


def mean_nis_band(count: int, dimension: int = _DIMENSION) -> tuple[float, float]:
    """Where the mean of `count` independent NIS lies with 99.9 %: chi-square quantiles by Wilson and Hilferty (1931)."""
    freedom = count * dimension
    spread = math.sqrt(2.0 / (9.0 * freedom))
    low, high = (dimension * (1.0 - spread**2 + sign * _QUANTILE * spread) ** 3 for sign in (-1.0, 1.0))
    return max(0.0, low), high
