"""The lab description: one YAML file that says what exists (design, "The lab description").

`load_lab` reads a file and raises `LabFileError`, every problem with its line; unknown keys are refused.
"""

from protocol.lab.basis import camera_basis, floor_basis
from protocol.lab.control import ControlSpec, FrenetControl, GoToGoalControl, GpssControl
from protocol.lab.description import Lab
from protocol.lab.devices import (
    GPSS_DRIVER,
    ROS2_DRIVER,
    Accuracy,
    Area,
    CameraSpec,
    Detours,
    FloorTags,
    GulliViewLayout,
    GulliViewOutput,
    Intrinsics,
    Limits,
    ObstacleBox,
    Output,
    Outputs,
    Ports,
    Ros2Base,
    Ros2Output,
    SpeedZoneSpec,
    VehicleSpec,
    VehicleTag,
    ZoneSpec,
)
from protocol.lab.loader import load_lab, parse_lab
from protocol.lab.protection import BatterySpec, ProtectiveFieldSpec, ScannerSpec
from protocol.lab.simulation import (
    SimulatedDrive,
    SimulatedImage,
    SimulatedMount,
    SimulatedNetwork,
    SimulatedScanner,
    SimulatedSurvey,
    Simulation,
)

__all__ = [
    "GPSS_DRIVER",
    "ROS2_DRIVER",
    "Accuracy",
    "Area",
    "BatterySpec",
    "CameraSpec",
    "ControlSpec",
    "Detours",
    "FloorTags",
    "FrenetControl",
    "GoToGoalControl",
    "GpssControl",
    "GulliViewLayout",
    "GulliViewOutput",
    "Intrinsics",
    "Lab",
    "Limits",
    "ObstacleBox",
    "Output",
    "Outputs",
    "Ports",
    "ProtectiveFieldSpec",
    "Ros2Base",
    "Ros2Output",
    "ScannerSpec",
    "SimulatedDrive",
    "SimulatedImage",
    "SimulatedMount",
    "SimulatedNetwork",
    "SimulatedScanner",
    "SimulatedSurvey",
    "Simulation",
    "SpeedZoneSpec",
    "VehicleSpec",
    "VehicleTag",
    "ZoneSpec",
    "camera_basis",
    "floor_basis",
    "load_lab",
    "parse_lab",
]
