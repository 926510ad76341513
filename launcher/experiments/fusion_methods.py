"""The methods that the fusion experiment compares, behind one interface."""

from collections.abc import Callable
from typing import Protocol

from msgspec.structs import replace

from agents.drivers import OdometryReading
from agents.estimation import (
    EkfConfig,
    EkfEstimator,
    Estimate,
    ExponentialFilter,
    Localization,
    NoiseConfig,
    PoseEstimator,
    Reference,
)
from geometry import SE2, angle_difference
from protocol.messages import TrackedPose

_REPORT_WEIGHT = 0.35
_NO_DELAY = EkfConfig(noise=NoiseConfig(delay_sigma_s=0.0, delay_walk_s=0.0))


class Method(Protocol):
    """Told of odometry and of each camera pose at the moment it arrives, asked for the pose at the moment of asking."""

    def odometry(self, reading: OdometryReading, /) -> None: ...

    def camera(self, pose: TrackedPose, now_ns: int, /) -> None: ...

    def estimate(self, now_ns: int, /) -> Estimate: ...


class OdometryOnly:
    """Dead reckoning from the true pose at the start."""

    def __init__(self, start: SE2) -> None:
        self._start = start
        self._first: SE2 | None = None
        self._newest: SE2 | None = None

    def odometry(self, reading: OdometryReading) -> None:
        self._first = self._first or reading.pose
        self._newest = reading.pose

    def camera(self, _pose: TrackedPose, _now_ns: int) -> None:
        pass

    def estimate(self, _now_ns: int) -> Estimate:
        if self._first is None or self._newest is None:
            return Estimate(Localization.NEVER, None, None)
        return Estimate(Localization.ALIGNED, self._start @ self._first.between(self._newest), None)


class CameraOnly:
    """The pose captured last, as it is."""

    def __init__(self) -> None:
        self._newest: TrackedPose | None = None

    def odometry(self, _reading: OdometryReading) -> None:
        pass

    def camera(self, pose: TrackedPose, _now_ns: int) -> None:
        if self._newest is None or pose.stamp_ns > self._newest.stamp_ns:
            self._newest = pose

    def estimate(self, _now_ns: int) -> Estimate:
        pose = self._newest
        if pose is None:
            return Estimate(Localization.NEVER, None, None)
        return Estimate(Localization.ALIGNED, SE2(pose.x, pose.y, pose.yaw), pose.stamp_ns)


class Reported:
    """The report's filter to the letter (GPSS report 3.1.3.1, 3.1.3.2, 3.1.3.5): each camera pose is moved on by velocity times
    age, along the heading by the wheels' speed, the yaw by their yaw rate, and S = 0.35 camera + 0.65 odometry."""

    def __init__(self) -> None:
        self._pose: SE2 | None = None
        self._reading: OdometryReading | None = None
        self._stamp_ns: int | None = None

    def odometry(self, reading: OdometryReading) -> None:
        if self._pose is not None and self._reading is not None:
            self._pose = self._pose @ self._reading.pose.between(reading.pose)
        self._reading = reading

    def camera(self, pose: TrackedPose, now_ns: int) -> None:
        if self._reading is None or (self._stamp_ns is not None and pose.stamp_ns <= self._stamp_ns):
            return
        self._stamp_ns = pose.stamp_ns
        age_s = (now_ns - pose.stamp_ns) / 1e9
        twist = self._reading.twist
        seen = SE2(pose.x, pose.y, pose.yaw) @ SE2.exp(twist.linear_mps * age_s, 0.0, twist.angular_radps * age_s)
        if self._pose is None:
            self._pose = seen
            return
        x, y, yaw = self._pose.x, self._pose.y, self._pose.yaw
        self._pose = SE2(
            x + _REPORT_WEIGHT * (seen.x - x),
            y + _REPORT_WEIGHT * (seen.y - y),
            yaw + _REPORT_WEIGHT * angle_difference(seen.yaw, yaw),
        )

    def estimate(self, _now_ns: int) -> Estimate:
        return Estimate(Localization.NEVER if self._pose is None else Localization.ALIGNED, self._pose, self._stamp_ns)


class Fused:
    """An estimator of the agents; with `compensated` False it is told that each pose was captured when it arrived."""

    def __init__(self, estimator: PoseEstimator, *, compensated: bool = True) -> None:
        self.estimator = estimator
        self._compensated = compensated

    def odometry(self, reading: OdometryReading) -> None:
        self.estimator.add_odometry(reading)

    def camera(self, pose: TrackedPose, now_ns: int) -> None:
        self.estimator.add_camera_pose(pose if self._compensated else replace(pose, stamp_ns=now_ns))

    def estimate(self, now_ns: int) -> Estimate:
        return self.estimator.estimate(now_ns)


MAKERS: dict[str, Callable[[SE2], Method]] = {
    "odometry": OdometryOnly,
    "camera": lambda _: CameraOnly(),
    "report": lambda _: Reported(),
    "exponential": lambda _: Fused(ExponentialFilter()),
    "ekf": lambda _: Fused(EkfEstimator()),
    "ekf_camera_time": lambda _: Fused(EkfEstimator(EkfConfig(reference=Reference.CAMERA))),
    "ekf_uncompensated": lambda _: Fused(EkfEstimator(_NO_DELAY), compensated=False),
}
"""How each method is made for a run that starts at a pose. `ekf_camera_time` takes the camera's clock for right where the
streams disagree; `ekf_uncompensated` knows neither capture times nor an estimate of the delay."""
