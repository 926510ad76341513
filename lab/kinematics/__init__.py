"""How the kinds of simulated vehicles move: one module each (docs/architecture.md, "The simulated base")."""

from lab.kinematics.kinematics import Kinematics, Measured, Motion, rolled
from lab.kinematics.registry import KINEMATICS

__all__ = ["KINEMATICS", "Kinematics", "Measured", "Motion", "rolled"]
