"""The interface of pose estimators: odometry and delayed camera poses in, the pose in the map frame out; no I/O, no clock."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from agents.drivers.driver import OdometryReading
from agents.estimation.consistency import NisReport
from geometry import SE2
from protocol.messages import TrackedPose


class Localization(StrEnum):
    """NEVER: no camera has seen the robot since the start. LOST: odometry and the map frame do not belong together any
    more (the base restarted, or the cameras were silent for long), the next camera pose aligns them again. ALIGNED: the
    pose is to be trusted as far as its age allows."""

    NEVER = "never"
    LOST = "lost"
    ALIGNED = "aligned"


@dataclass(frozen=True, slots=True)
class Estimate:
    """T_map_robot, None while the robot was never localized; when LOST it is the last one known. `camera_stamp_ns` is the
    capture time of the newest camera pose that went in. `covariance` is the upper triangle, row by row, of that of x, y (m) and
    yaw (rad) in the map frame; None where the estimator has none."""

    localization: Localization
    pose: SE2 | None
    camera_stamp_ns: int | None
    covariance: tuple[float, float, float, float, float, float] | None = None


class PoseEstimator(Protocol):
    """One per robot. Camera poses are those of the tracker: the rotation centre in the map frame, with the marker's offset
    rotated out already, at the capture time."""

    def add_odometry(self, reading: OdometryReading) -> None:
        """The newest reading; repeated and older ones change nothing."""
        ...

    def add_camera_pose(self, pose: TrackedPose) -> bool:
        """Whether the pose was used. False for one that was given before, at a time that odometry does not reach, with
        numbers that are none, or that cannot be right; estimators that cannot go back also refuse those captured before
        the newest used one."""
        ...

    def estimate(self, now_ns: int) -> Estimate:
        """What is known for the moment `now_ns`."""
        ...

    def consistency(self) -> NisReport | None:
        """How well its covariances agree with what cameras say; None where it has none."""
        ...
