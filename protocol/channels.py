"""The channel table: everything that is said while the system runs, at what rate, and how old it may get.

A channel has instances (a camera, a robot, ...). Its newest message per instance is kept in a Redis hash and published to
subscribers; health is derived from the ages in those hashes. `EVERY` channels are capped streams instead: nothing is
skipped.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, TypeVar

from msgspec import Struct
from pydantic import BaseModel

from protocol.messages import (
    CalibrationRun,
    CameraState,
    Command,
    EmergencyStop,
    Event,
    FloorRaster,
    FloorTagSighting,
    FrameDetections,
    GroundTruth,
    GuidanceState,
    IntakeState,
    ManualDrive,
    ProcessState,
    Registration,
    Response,
    Status,
    TrackedPose,
)

M = TypeVar("M", bound=BaseModel | Struct)


class Delivery(StrEnum):
    """LATEST: only the newest counts, losing one is normal. EVERY: each one must arrive, in order."""

    LATEST = "latest"
    EVERY = "every"


class Instances(StrEnum):
    """What a channel has one instance of."""

    CAMERA = "camera"
    VEHICLE = "vehicle"
    PROCESS = "process"
    LAB = "lab"


@dataclass(frozen=True, slots=True)
class Channel(Generic[M]):
    """`rate_hz` is the expected rate per instance (0: only when something happens); a LATEST message older than
    `stale_after_s` counts as missing (0: it never goes stale). `producer` is a name of the process table."""

    name: str
    message: type[M]
    per: Instances
    producer: str
    rate_hz: float
    stale_after_s: float
    delivery: Delivery = Delivery.LATEST


DETECTIONS = Channel("detections", FrameDetections, Instances.CAMERA, "camera", 15.0, 1.0)
CAMERA_STATES = Channel("camera_states", CameraState, Instances.CAMERA, "camera", 2.0, 2.0)
RASTERS = Channel("rasters", FloorRaster, Instances.CAMERA, "camera", 7.5, 1.0)
POSES = Channel("poses", TrackedPose, Instances.VEHICLE, "tracker", 15.0, 0.5)
OBSTACLES = Channel("obstacles", FloorRaster, Instances.LAB, "mapper", 10.0, 1.0)
COMMANDS = Channel("commands", Command, Instances.VEHICLE, "guidance", 10.0, 0.5)
GUIDANCE = Channel("guidance", GuidanceState, Instances.VEHICLE, "guidance", 10.0, 0.5)
REGISTRATIONS = Channel("registrations", Registration, Instances.VEHICLE, "agent", 0.2, 60.0)
STATUSES = Channel("statuses", Status, Instances.VEHICLE, "agent", 10.0, 1.0)
MANUAL = Channel("manual", ManualDrive, Instances.VEHICLE, "server", 0.0, 0.0)
SIGHTINGS = Channel("sightings", FloorTagSighting, Instances.CAMERA, "camera", 0.0, 0.0)
CALIBRATION_RUNS = Channel("calibration_runs", CalibrationRun, Instances.LAB, "calibrator", 0.0, 0.0)
EMERGENCY_STOP = Channel("emergency_stop", EmergencyStop, Instances.LAB, "server", 0.0, 0.0)
INTAKE = Channel("intake", IntakeState, Instances.LAB, "intake", 1.0, 5.0)
PROCESSES = Channel("processes", ProcessState, Instances.PROCESS, "launcher", 1.0, 5.0)
GROUND_TRUTH = Channel("ground_truth", GroundTruth, Instances.LAB, "lab", 50.0, 1.0)
RESPONSES = Channel("responses", Response, Instances.VEHICLE, "agent", 0.0, 0.0, Delivery.EVERY)
EVENTS = Channel("events", Event, Instances.LAB, "server", 0.0, 0.0, Delivery.EVERY)

CHANNELS: tuple[Channel[Any], ...] = (
    DETECTIONS,
    CAMERA_STATES,
    RASTERS,
    POSES,
    OBSTACLES,
    COMMANDS,
    GUIDANCE,
    REGISTRATIONS,
    STATUSES,
    MANUAL,
    SIGHTINGS,
    CALIBRATION_RUNS,
    EMERGENCY_STOP,
    INTAKE,
    PROCESSES,
    GROUND_TRUTH,
    RESPONSES,
    EVENTS,
)
LAB_INSTANCE = "lab"
"""The instance name of channels with one instance for the whole lab."""
