"""The kinematics by a vehicle's `kind`."""

from collections.abc import Callable

import numpy as np

from lab.kinematics.differential import DifferentialDrive, half_track_of
from lab.kinematics.freke import Freke
from lab.kinematics.kinematics import Kinematics
from lab.kinematics.skid_steer import SkidSteer
from lab.kinematics.steered_front import SteeredFront
from protocol.lab import SimulatedDrive, VehicleSpec


def _differential(spec: VehicleSpec, drive: SimulatedDrive, rng: np.random.Generator) -> Kinematics:  # noqa: ARG001
    return DifferentialDrive(spec, drive, half_track_of(spec))


KINEMATICS: dict[str, Callable[[VehicleSpec, SimulatedDrive, np.random.Generator], Kinematics]] = {
    "wifibot": SkidSteer,
    "turtlebot": _differential,
    "agv": SteeredFront,
    "freke": Freke,
}
