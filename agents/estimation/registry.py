"""The pose estimators by name."""

from collections.abc import Callable

from agents.estimation.ekf import EkfEstimator
from agents.estimation.estimator import PoseEstimator
from agents.estimation.exponential import ExponentialFilter

ESTIMATORS: dict[str, Callable[[], PoseEstimator]] = {
    "ekf": EkfEstimator,
    "exponential": ExponentialFilter,
}
DEFAULT_ESTIMATOR = "ekf"
