"""What crosses a process boundary.

Low-rate messages are pydantic models (unknown fields refused); those on the way of a frame are msgspec structs. Both are
JSON on the wire; `protocol.codec` turns either into bytes and back. Stamps are nanoseconds since the epoch, positions
metres in the map frame, angles radians counter-clockwise.
"""

from protocol.messages.calibration import (
    CalibratedCamera,
    CalibratedFloorTag,
    Calibration,
    CalibrationProposal,
    CalibrationRun,
    CameraComparison,
    FloorTagComparison,
    FloorTagSighting,
    RunState,
)
from protocol.messages.fleet import (
    Assignment,
    AssignmentState,
    Command,
    EmergencyStop,
    Leg,
    ManualDrive,
    Mode,
    Movement,
    Outcome,
    Reason,
    ReasonCode,
    Registration,
    Response,
    RobotSettings,
    Route,
    Status,
    Target,
    Waypoint,
)
from protocol.messages.guidance import Blockage, GuidanceState
from protocol.messages.sight import (
    CameraExtrinsics,
    CameraState,
    Detection,
    FloorRaster,
    FrameDetections,
    TrackedPose,
)
from protocol.messages.simulated import DriveSetpoint, GroundTruth, Odometry, SimulatedObject, TruePose
from protocol.messages.system import Event, EventLevel, ProcessState

__all__ = [
    "Assignment",
    "AssignmentState",
    "Blockage",
    "CalibratedCamera",
    "CalibratedFloorTag",
    "Calibration",
    "CalibrationProposal",
    "CalibrationRun",
    "CameraComparison",
    "CameraExtrinsics",
    "CameraState",
    "Command",
    "Detection",
    "DriveSetpoint",
    "EmergencyStop",
    "Event",
    "EventLevel",
    "FloorRaster",
    "FloorTagComparison",
    "FloorTagSighting",
    "FrameDetections",
    "GroundTruth",
    "GuidanceState",
    "Leg",
    "ManualDrive",
    "Mode",
    "Movement",
    "Odometry",
    "Outcome",
    "ProcessState",
    "Reason",
    "ReasonCode",
    "Registration",
    "Response",
    "RobotSettings",
    "Route",
    "RunState",
    "SimulatedObject",
    "Status",
    "Target",
    "TrackedPose",
    "TruePose",
    "Waypoint",
]
