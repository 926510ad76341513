"""Where cameras hang and how their lenses are (spec localization, "Better than the reports"; GulliView 2025, 3.1.2)."""

from localization.calibration.extrinsics import ExtrinsicsError
from localization.calibration.joint import JointCalibration, refine_jointly
from localization.calibration.per_tag import NoPoseError, PerTagAverage
from localization.calibration.self_calibration import SelfCalibration
from localization.calibration.sighting import FloorSighting

__all__ = [
    "ExtrinsicsError",
    "FloorSighting",
    "JointCalibration",
    "NoPoseError",
    "PerTagAverage",
    "SelfCalibration",
    "refine_jointly",
]
