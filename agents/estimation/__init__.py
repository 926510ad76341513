"""Pose estimation on the robot: odometry and the cameras' delayed poses become one pose in the map frame. Pure."""

from agents.estimation.consistency import NisReport, NisWatch, mean_nis_band
from agents.estimation.ekf import EkfEstimator
from agents.estimation.ekf_config import EkfConfig, Reference
from agents.estimation.ekf_noise import NoiseConfig
from agents.estimation.estimator import Estimate, Localization, PoseEstimator
from agents.estimation.exponential import ExponentialConfig, ExponentialFilter
from agents.estimation.history import OdometryHistory
from agents.estimation.registry import DEFAULT_ESTIMATOR, ESTIMATORS

__all__ = [
    "DEFAULT_ESTIMATOR",
    "ESTIMATORS",
    "EkfConfig",
    "EkfEstimator",
    "Estimate",
    "ExponentialConfig",
    "ExponentialFilter",
    "Localization",
    "NisReport",
    "NisWatch",
    "NoiseConfig",
    "OdometryHistory",
    "PoseEstimator",
    "Reference",
    "mean_nis_band",
]
