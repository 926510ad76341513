"""The lab description: one YAML file that says what exists (design, "The lab description").

`load_lab` reads a file and raises `LabFileError`, every problem with its line; unknown keys are refused.
"""

from protocol.lab.description import Lab
from protocol.lab.devices import (
    Area,
    CameraSpec,
    FloorTags,
    Intrinsics,
    Limits,
    ObstacleBox,
    Ports,
    VehicleSpec,
    VehicleTag,
    ZoneSpec,
)
from protocol.lab.loader import load_lab, parse_lab
from protocol.lab.simulation import (
    SimulatedDrive,
    SimulatedImage,
    SimulatedMount,
    SimulatedNetwork,
    SimulatedSurvey,
    Simulation,
)

__all__ = [
    "Area",
    "CameraSpec",
    "FloorTags",
    "Intrinsics",
    "Lab",
    "Limits",
    "ObstacleBox",
    "Ports",
    "SimulatedDrive",
    "SimulatedImage",
    "SimulatedMount",
    "SimulatedNetwork",
    "SimulatedSurvey",
    "Simulation",
    "VehicleSpec",
    "VehicleTag",
    "ZoneSpec",
    "load_lab",
    "parse_lab",
]
