"""Whether covariances are honest: the normalised estimation error squared and the band that its mean must lie in
(Bar-Shalom et al. 2001, sec. 5.4.2)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Consistency:
    """`mean` is that of the NEES over all samples, weighed by room; `low` and `high` bound where honest covariances put it with
    95 %; `independent` is how many independent errors a room is worth."""

    mean: float
    low: float
    high: float
    independent: float


def nees(errors: Array, covariances: Array) -> Array:
    """e^T P^-1 e of errors (N, d) with covariances (N, d, d): (N,), chi-square with d degrees of freedom when P is right."""
    return np.einsum("ni,ni->n", errors, np.linalg.solve(covariances, errors[..., None])[..., 0])


def consistency(rooms: Sequence[Array], dimension: int) -> Consistency:
    """From the NEES of every room's samples. ValueError with less than two rooms: nothing then tells how samples hang together.

    The errors within a room share one calibration, so its many samples are worth few independent ones. How many is taken from
    how much the rooms' means m scatter: a mean of n independent NEES of dimension d has a relative variance of 2 / (d n), hence
    n = 2 mean(m)^2 / (d var(m)) (Satterthwaite 1946). The scatter is taken relative to the mean: covariances that are too
    small by a factor, which raise both alike, do not widen the band. The sum over R rooms is then chi-square with d n R degrees
    of freedom.
    """
    if len(rooms) < 2:
        raise ValueError("the spread over rooms needs at least two rooms")
    means = np.array([float(np.mean(room)) for room in rooms])
    mean = float(means.mean())
    independent = 2.0 * mean**2 / (dimension * float(means.var(ddof=1)))
    freedom = dimension * independent * len(rooms)
    low, high = (float(chi2.ppf(q, freedom)) * dimension / freedom for q in (0.025, 0.975))
    return Consistency(mean, low, high, independent)
