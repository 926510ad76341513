"""Pose estimation on the robot: odometry and the cameras' delayed poses become one pose in the map frame. Pure."""

from agents.estimation.estimator import Estimate, Localization, PoseEstimator
from agents.estimation.exponential import ExponentialConfig, ExponentialFilter
from agents.estimation.history import OdometryHistory
from agents.estimation.registry import DEFAULT_ESTIMATOR, ESTIMATORS

__all__ = [
    "DEFAULT_ESTIMATOR",
    "ESTIMATORS",
    "Estimate",
    "ExponentialConfig",
    "ExponentialFilter",
    "Localization",
    "OdometryHistory",
    "PoseEstimator",
]
