"""The extended Kalman filter on SE(2) under the name `ekf` (spec gpss, "Better than the report").

Odometry moves the state on; a camera's pose is applied at its capture time: the filter goes back to the node before it,
corrects, and drives the later nodes again (rewind and replay), in whatever order poses arrive. What odometry's way and turn
are wrong by, by how much capture stamps are late, and how large the noises are, is estimated on the way.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from agents.drivers.driver import OdometryReading
from agents.estimation.consistency import NisReport, NisWatch
from agents.estimation.ekf_belief import Belief, innovation
from agents.estimation.ekf_chain import Chain
from agents.estimation.ekf_config import EkfConfig, Reference
from agents.estimation.ekf_gate import GATE_NIS, Recovery, Refused
from agents.estimation.ekf_model import LINEAR, Sight, velocity
from agents.estimation.ekf_noise import NoiseModel
from agents.estimation.ekf_odometry import motion_around, odometry_at
from agents.estimation.estimator import Estimate, Localization
from agents.estimation.history import OdometryHistory, is_another_session, is_jump
from agents.estimation.plausible import is_plausible_odometry, is_plausible_pose
from geometry import SE2
from protocol.messages import TrackedPose

Array = NDArray[np.float64]

_HORIZON_NS = 2_000_000_000
"""A pose may be so old against the newest odometry."""
_STAMPS_KNOWN = 512
_FLAWLESS = (1.0, 1.0, 0.0, 0.0)
"""Linear, angular, curvature and delay of odometry and stamps that do not lie."""


class EkfEstimator:
    """One robot's. `noise` holds the scales it has learned."""

    def __init__(self, config: EkfConfig | None = None) -> None:
        self._config = config or EkfConfig()
        self.noise = NoiseModel(self._config.noise)
        self._history = OdometryHistory(span_s=_HORIZON_NS / 1e9)
        self._chain = Chain(self.noise)
        self._constants: Array = np.array(_FLAWLESS)
        self._constants_covariance: Array = np.diag(self.noise.constants())
        self._recovery = Recovery()
        self._watch = NisWatch()
        self._stamps: deque[int] = deque(maxlen=_STAMPS_KNOWN)
        self._camera_stamp_ns: int | None = None
        self._last_pose: SE2 | None = None
        self._told: tuple[int, Estimate] | None = None

    @property
    def constants(self) -> dict[str, float]:
        """What is thought of odometry and stamps: `linear`, `angular` (factors), `curvature_radpm`, `delay_s`."""
        newest = self._chain.newest
        mean = self._constants if newest is None else newest.belief.mean[LINEAR:]
        linear, angular, curvature, delay = (float(value) for value in mean)
        return {"linear": linear, "angular": angular, "curvature_radpm": curvature, "delay_s": delay}

    def consistency(self) -> NisReport | None:
        return self._watch.report()

    def add_odometry(self, reading: OdometryReading) -> None:
        if not is_plausible_odometry(reading):
            return
        self._told = None
        newest = self._history.newest
        if newest is not None:
            if is_another_session(newest, reading) or is_jump(newest, reading):
                self._lose()
            elif reading.stamp_ns <= newest.stamp_ns:
                return
        self._history.add(reading)
        self._insert(reading.stamp_ns, reading.pose)
        self._chain.forget(reading.stamp_ns - _HORIZON_NS)

    def add_camera_pose(self, pose: TrackedPose) -> bool:
        if not is_plausible_pose(pose) or pose.stamp_ns in self._stamps:
            return False
        delay_s = self.constants["delay_s"]
        at_ns = pose.stamp_ns - round(delay_s * 1e9)
        T_odom_robot, before = self._history.at(at_ns), self._chain.before(at_ns)
        if T_odom_robot is None or (before is None and self._chain.newest is not None):
            return False
        self._told = None
        self._stamps.append(pose.stamp_ns)
        seen, covariance = np.array([pose.x, pose.y, pose.yaw]), _full(pose.covariance)
        if before is None:
            self._begin(at_ns, T_odom_robot, seen, covariance)
            self._camera_stamp_ns = pose.stamp_ns
            return True
        belief = self._chain.driven(before, at_ns, T_odom_robot)
        moves = velocity(belief.mean, motion_around(self._history, at_ns, T_odom_robot))
        sight = Sight(seen, covariance, delay_s, moves)
        found = innovation(belief, sight, self.noise)
        if not found.nis <= GATE_NIS:
            return self._refuse(Refused(at_ns, T_odom_robot, seen, covariance), pose.stamp_ns)
        self._watch.add_used(found.nis)
        self._recovery.clear()
        self.noise.learn(found.difference, found.covariance, found.difference_slopes, found.slopes)
        self._insert(at_ns, T_odom_robot, sight)
        self._camera_stamp_ns = max(pose.stamp_ns, self._camera_stamp_ns or pose.stamp_ns)
        return True

    def estimate(self, now_ns: int) -> Estimate:
        if self._told is None or self._told[0] != now_ns:
            self._told = (now_ns, self._estimate(now_ns))
        return self._told[1]

    def _estimate(self, now_ns: int) -> Estimate:
        config = self._config
        early_ns = round(self.constants["delay_s"] * 1e9) if config.reference is Reference.CAMERA else 0
        at_ns = now_ns - early_ns
        node = self._chain.last_before(at_ns)
        if node is None or self._camera_stamp_ns is None:
            state = Localization.NEVER if self._last_pose is None else Localization.LOST
            return Estimate(state, self._last_pose, None)
        T_odom_robot, unknown = odometry_at(self._history, at_ns, node.T_odom_robot, config)
        belief = self._chain.driven(node, at_ns, T_odom_robot)
        covariance = belief.covariance[:3, :3] + unknown
        if config.reference is Reference.CAMERA:
            # The moment looked up in odometry is as uncertain as the delay.
            moves = velocity(belief.mean, motion_around(self._history, at_ns, T_odom_robot))
            sees = Sight(belief.mean[:3], covariance, 0.0, moves).jacobian()
            covariance = sees @ belief.covariance @ sees.T + unknown
        x, y, yaw = (float(value) for value in belief.mean[:3])
        self._last_pose = SE2(x, y, yaw)
        xx, xy, xt, yy, yt, tt = (float(value) for value in covariance[np.triu_indices(3)])
        silent_s = (now_ns - self._camera_stamp_ns) / 1e9
        lost = silent_s > config.lost_after_s or max(xx, yy) > config.lost_m**2 or tt > config.lost_rad**2
        return Estimate(
            Localization.LOST if lost else Localization.ALIGNED,
            self._last_pose,
            self._camera_stamp_ns,
            (xx, xy, xt, yy, yt, tt),
        )

    def _begin(self, stamp_ns: int, T_odom_robot: SE2, pose: Array, covariance: Array) -> None:
        """A new chain from a camera's pose, with all that odometry has measured since."""
        belief = Belief.at(pose, self.noise.of_camera(covariance), self._constants, self._constants_covariance)
        self._chain.begin(stamp_ns, T_odom_robot, belief)
        self._recovery.clear()
        for reading in self._history.after(stamp_ns):
            self._insert(reading.stamp_ns, reading.pose)

    def _refuse(self, refused: Refused, stamp_ns: int) -> bool:
        """Whether it is not refused after all: enough of its like say that the filter is wrong."""
        self._watch.add_refused()
        if not self._recovery.add(refused):
            return False
        self._keep_constants(doubted=True)
        self._begin(refused.stamp_ns, refused.T_odom_robot, refused.pose, refused.covariance)
        self._camera_stamp_ns = stamp_ns
        return True

    def _insert(self, stamp_ns: int, T_odom_robot: SE2, sight: Sight | None = None) -> None:
        """Into the chain. A belief that is none any more is given up, with all that was learned of odometry."""
        self._chain.insert(stamp_ns, T_odom_robot, sight)
        newest = self._chain.newest
        if newest is not None and not newest.belief.is_sound:
            self._constants = np.array(_FLAWLESS)
            self._constants_covariance = np.diag(self.noise.constants())
            self._chain.clear()
            self._lose()

    def _lose(self) -> None:
        """Odometry's frame is another one from now on; what was learned of the base and the cameras stays."""
        newest = self._chain.newest
        if newest is not None:
            x, y, yaw = (float(value) for value in newest.belief.mean[:3])
            self._last_pose = SE2(x, y, yaw)
            self._keep_constants(doubted=False)
        self._history.clear()
        self._chain.clear()
        self._recovery.clear()
        self._stamps.clear()
        self._camera_stamp_ns = None

    def _keep_constants(self, *, doubted: bool) -> None:
        """For the next chain; `doubted` when something was wrong, perhaps these."""
        newest = self._chain.newest
        if newest is None:
            return
        self._constants = newest.belief.mean[LINEAR:].copy()
        self._constants_covariance = newest.belief.covariance[LINEAR:, LINEAR:].copy()
        if doubted:
            held = np.diag(self._constants_covariance)
            self._constants_covariance = np.diag(np.minimum(4.0 * held, self.noise.constants()))


def _full(covariance: tuple[float, float, float, float, float, float]) -> Array:
    """The symmetric matrix (3, 3) of an upper triangle."""
    xx, xy, xt, yy, yt, tt = covariance
    return np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])
