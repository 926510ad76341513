"""The report's filter under the name `exponential` (spec gpss, "The robot's side"; GPSS report 3.1.3.1, 3.1.3.2, 3.1.3.5)."""

from dataclasses import dataclass

from agents.drivers.driver import OdometryReading
from agents.estimation.consistency import NisReport
from agents.estimation.estimator import Estimate, Localization
from agents.estimation.history import OdometryHistory, is_another_session
from agents.estimation.plausible import is_plausible_odometry, is_plausible_pose
from geometry import SE2, angle_difference
from protocol.messages import TrackedPose


@dataclass(frozen=True, slots=True)
class ExponentialConfig:
    """`camera_weight`: the camera's share of a new position (report: 35 %; odometry has the other 65 %). After
    `realign_after_s` without a camera pose the robot may have been carried elsewhere: the next one then counts whole."""

    camera_weight: float = 0.35
    realign_after_s: float = 2.0


class ExponentialFilter:
    """Single exponential smoothing between odometry and camera, S = w camera + (1 - w) odometry.

    The first camera pose gives T_map_odom, the offset between the two frames in position and yaw. Each later one is
    compared with what odometry says *of its capture time*; the weighted mean of both corrects T_map_odom, and everything
    that odometry has measured since the capture is on top of it. That makes up for the camera's delay with the way really
    gone, where the report adds velocity times age. The yaw is weighted along the shorter arc.
    """

    def __init__(self, config: ExponentialConfig | None = None) -> None:
        self._config = config or ExponentialConfig()
        self._history = OdometryHistory()
        self._T_map_odom: SE2 | None = None
        self._last_pose: SE2 | None = None
        self._camera_stamp_ns: int | None = None

    def add_odometry(self, reading: OdometryReading) -> None:
        if not is_plausible_odometry(reading):
            return
        newest = self._history.newest
        if newest is not None and is_another_session(newest, reading):
            if self._T_map_odom is not None:
                self._last_pose = self._T_map_odom @ newest.pose
            self._history.clear()
            self._T_map_odom = self._camera_stamp_ns = None
        self._history.add(reading)

    def add_camera_pose(self, pose: TrackedPose) -> bool:
        if not is_plausible_pose(pose):
            return False
        previous_ns = self._camera_stamp_ns
        if previous_ns is not None and pose.stamp_ns <= previous_ns:
            return False
        T_odom_robot = self._history.at(pose.stamp_ns)
        if T_odom_robot is None:
            return False
        T_map_robot = SE2(pose.x, pose.y, pose.yaw)
        silent_ns = 0 if previous_ns is None else pose.stamp_ns - previous_ns
        if self._T_map_odom is not None and silent_ns <= self._config.realign_after_s * 1e9:
            T_map_robot = self._smoothed(self._T_map_odom @ T_odom_robot, T_map_robot)
        self._T_map_odom = T_map_robot @ T_odom_robot.inverse()
        self._last_pose = T_map_robot
        self._camera_stamp_ns = pose.stamp_ns
        return True

    def estimate(self, now_ns: int) -> Estimate:
        if self._T_map_odom is None or self._camera_stamp_ns is None:
            state = Localization.NEVER if self._last_pose is None else Localization.LOST
            return Estimate(state, self._last_pose, None)
        newest = self._history.newest
        T_odom_robot = self._history.at(now_ns) or (newest.pose if newest else None)
        if T_odom_robot is not None:
            self._last_pose = self._T_map_odom @ T_odom_robot
        silent_ns = now_ns - self._camera_stamp_ns
        lost = silent_ns > self._config.realign_after_s * 1e9
        return Estimate(Localization.LOST if lost else Localization.ALIGNED, self._last_pose, self._camera_stamp_ns)

    def consistency(self) -> NisReport | None:
        """None: it has no covariances."""
        return None

    def _smoothed(self, odometry: SE2, camera: SE2) -> SE2:
        weight = self._config.camera_weight
        return SE2(
            odometry.x + weight * (camera.x - odometry.x),
            odometry.y + weight * (camera.y - odometry.y),
            odometry.yaw + weight * angle_difference(camera.yaw, odometry.yaw),
        )
