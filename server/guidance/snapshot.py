"""What goes into one cycle of guidance and what comes out of it: plain data, so that the core needs neither Redis nor time."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from geometry import SE2
from protocol.channels import POSES, STATUSES
from protocol.messages import (
    Assignment,
    Command,
    EmergencyStop,
    Event,
    FloorRaster,
    GuidanceState,
    ManualDrive,
    RobotSettings,
    Route,
    SpeedZone,
    TrackedPose,
    Waypoint,
)


class Heard(Protocol):
    """What guidance reads of a robot's Status."""

    @property
    def stamp_ns(self) -> int: ...
    @property
    def linear_mps(self) -> float: ...
    @property
    def angular_radps(self) -> float: ...
    @property
    def battery(self) -> float | None: ...
    @property
    def command_order(self) -> tuple[int, int] | None: ...


LONGEST_MANUAL_LEASE_S = 2.0
"""A lease that runs longer comes from a clock that is wrong and would let a robot drive on for as long."""
_REST_MPS, _REST_RADPS = 0.01, 0.03


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Everything guidance reads, at one instant. `now_ns` is wall-clock time, `now_s` monotonic."""

    now_ns: int
    now_s: float
    poses: Mapping[str, TrackedPose] = field(default_factory=dict[str, TrackedPose])
    statuses: Mapping[str, Heard] = field(default_factory=dict[str, Heard])
    manual: Mapping[str, ManualDrive] = field(default_factory=dict[str, ManualDrive])
    emergency_stop: EmergencyStop | None = None
    obstacles: FloorRaster | None = None
    waypoints: Mapping[str, Waypoint] = field(default_factory=dict[str, Waypoint])
    routes: Mapping[str, Route] = field(default_factory=dict[str, Route])
    assignments: Mapping[str, Assignment] = field(default_factory=dict[str, Assignment])
    settings: Mapping[str, RobotSettings] = field(default_factory=dict[str, RobotSettings])
    speed_zones: Mapping[str, SpeedZone] = field(default_factory=dict[str, SpeedZone])

    def age_s(self, stamp_ns: int) -> float:
        """How far a stamp lies from now; one from the future is as wrong as one from the past."""
        return abs(self.now_ns - stamp_ns) / 1e9

    def fresh_pose(self, robot: str) -> TrackedPose | None:
        """The robot's pose unless it is missing or older than its channel's limit."""
        pose = self.poses.get(robot)
        return pose if pose is not None and self.age_s(pose.stamp_ns) <= POSES.stale_after_s else None

    def connected(self, robot: str) -> bool:
        """Whether the robot itself was heard lately."""
        status = self.statuses.get(robot)
        return status is not None and self.age_s(status.stamp_ns) <= STATUSES.stale_after_s

    def at_rest(self, robot: str) -> bool:
        """Whether the robot says that it neither drives nor turns."""
        status = self.statuses.get(robot)
        return status is not None and abs(status.linear_mps) < _REST_MPS and abs(status.angular_radps) < _REST_RADPS

    def hand(self, robot: str) -> ManualDrive | None:
        """The hand on the robot's stick while its lease counts."""
        manual = self.manual.get(robot)
        if manual is None:
            return None
        left_s = (manual.expires_ns - self.now_ns) / 1e9
        return manual if 0 < left_s <= LONGEST_MANUAL_LEASE_S else None

    def former_hand(self, robot: str, within_s: float) -> ManualDrive | None:
        """The hand whose lease ended at most `within_s` ago, let go of or lost."""
        manual = self.manual.get(robot)
        if manual is None:
            return None
        return manual if 0 <= self.now_ns - manual.expires_ns < within_s * 1e9 else None


@dataclass(frozen=True, slots=True)
class AssignmentChange:
    """An assignment to be replaced, provided that nobody else changed it meanwhile."""

    before: Assignment
    after: Assignment


@dataclass(frozen=True, slots=True)
class Outcome:
    """What one cycle says: a command and a state for every vehicle of the lab, changes of assignments, events."""

    commands: Mapping[str, Command]
    states: Mapping[str, GuidanceState]
    changes: tuple[AssignmentChange, ...]
    events: tuple[Event, ...]


def extrapolated(pose: TrackedPose, seconds: float) -> SE2:
    """Where the vehicle is `seconds` after the pose if it keeps its twist (constant velocity and yaw rate)."""
    return SE2(pose.x + pose.vx * seconds, pose.y + pose.vy * seconds, pose.yaw + pose.yaw_rate * seconds)


def position_sigma_m(pose: TrackedPose) -> float:
    """One standard deviation of the position: the larger axis is at most the root of the trace."""
    return math.sqrt(max(0.0, pose.covariance[0]) + max(0.0, pose.covariance[3]))
