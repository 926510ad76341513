"""The pose estimators by name."""

from collections.abc import Callable

from agents.estimation.estimator import PoseEstimator
from agents.estimation.exponential import ExponentialFilter

ESTIMATORS: dict[str, Callable[[], PoseEstimator]] = {
    "exponential": ExponentialFilter,
}
DEFAULT_ESTIMATOR = "exponential"
