"""Mathematics every part shares: angles, rigid transforms, camera data. No I/O, no image processing."""

from geometry.angles import angle_difference, mean_angle, wrap_angle
from geometry.camera import CameraModel
from geometry.se2 import SE2
from geometry.se3 import SE3

__all__ = ["SE2", "SE3", "CameraModel", "angle_difference", "mean_angle", "wrap_angle"]
