"""What the extended Kalman filter is told about a robot and its cameras before it has seen either."""

from dataclasses import dataclass, field
from enum import StrEnum

from agents.estimation.ekf_noise import NoiseConfig


class Reference(StrEnum):
    """Whose stamps tell the time of the estimate where camera and odometry disagree. ODOMETRY: the camera's stamps are late
    (it stamps what it has received). CAMERA: odometry is early; right for bases that report what they were told to do."""

    ODOMETRY = "odometry"
    CAMERA = "camera"


@dataclass(frozen=True, slots=True)
class EkfConfig:
    """`noise`: what is assumed of it. The estimate is LOST once it is worse than `lost_m` or `lost_rad` (one standard
    deviation), or after `lost_after_s` without a camera, when the robot may have been carried. Accelerations are unknown
    where odometry ends; `acceleration_*` is their standard deviation."""

    noise: NoiseConfig = field(default_factory=NoiseConfig)
    reference: Reference = Reference.ODOMETRY
    lost_m: float = 1.0
    lost_rad: float = 0.8
    lost_after_s: float = 30.0
    acceleration_mps2: float = 0.5
    acceleration_radps2: float = 1.5
