"""Where cameras hang and how their lenses are (spec localization, "Better than the reports"; GulliView 2025, 3.1.2)."""

from localization.calibration.boards import BoardError, BoardSpec
from localization.calibration.extrinsics import ExtrinsicsError
from localization.calibration.intrinsics import IntrinsicsError, IntrinsicsEstimate, calibrate_intrinsics
from localization.calibration.joint import JointCalibration, refine_jointly
from localization.calibration.per_tag import NoPoseError, PerTagAverage
from localization.calibration.self_calibration import SelfCalibration
from localization.calibration.sighting import FloorSighting

__all__ = [
    "BoardError",
    "BoardSpec",
    "ExtrinsicsError",
    "FloorSighting",
    "IntrinsicsError",
    "IntrinsicsEstimate",
    "JointCalibration",
    "NoPoseError",
    "PerTagAverage",
    "SelfCalibration",
    "calibrate_intrinsics",
    "refine_jointly",
]
