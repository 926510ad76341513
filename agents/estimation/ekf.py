"""The extended Kalman filter on SE(2) under the name `ekf` (spec gpss, "Better than the report").

Odometry moves the state on; a camera's pose is applied at its capture time: the filter goes back to the node before it,
corrects, and drives the later nodes again (rewind and replay), in whatever order poses arrive. What odometry's way and turn
are wrong by, by how much capture stamps are late, and how large the noises are, is estimated on the way.
"""

import math
from bisect import bisect_right
from collections import deque
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from agents.drivers.driver import OdometryReading
from agents.estimation.consistency import NisReport, NisWatch
from agents.estimation.ekf_belief import Belief, innovation, predicted, updated
from agents.estimation.ekf_gate import GATE_NIS, Recovery, Refused
from agents.estimation.ekf_model import LINEAR, Motion, Sight, velocity
from agents.estimation.ekf_noise import NoiseConfig, NoiseModel
from agents.estimation.estimator import Estimate, Localization
from agents.estimation.history import OdometryHistory
from agents.estimation.plausible import is_plausible_odometry, is_plausible_pose
from geometry import SE2
from protocol.messages import TrackedPose

Array = NDArray[np.float64]

_CLOCK_SET_BACK_NS = 1_000_000_000
"""Odometry that is older than the last by more than this: the machine's clock was set back."""
_JUMP_M = 0.5
_JUMP_MPS = 20.0
"""A base that moves further at once did not drive: its frame is another one."""
_HORIZON_NS = 2_000_000_000
_MOST_NODES = 1500
_STAMPS_KNOWN = 512
_AROUND_NS = 30_000_000
"""The velocity at a moment is taken from this much before and after it."""
_HOLD_S = 0.5
"""Without odometry the last twist is believed for this long."""


class Reference(StrEnum):
    """Whose stamps tell the time of the estimate where camera and odometry disagree. ODOMETRY: the camera's stamps are late
    (it stamps what it has received). CAMERA: odometry is early; right for bases that report what they were told to do."""

    ODOMETRY = "odometry"
    CAMERA = "camera"


@dataclass(frozen=True, slots=True)
class EkfConfig:
    """`noise`: what is assumed of it. The estimate is LOST once it is worse than `lost_m` or `lost_rad` (one standard
    deviation), or after `lost_after_s` without a camera, when the robot may have been carried. Accelerations are unknown
    where odometry ends; `acceleration_*` is their standard deviation."""

    noise: NoiseConfig = field(default_factory=NoiseConfig)
    reference: Reference = Reference.ODOMETRY
    lost_m: float = 1.0
    lost_rad: float = 0.8
    lost_after_s: float = 30.0
    acceleration_mps2: float = 0.5
    acceleration_radps2: float = 1.5


@dataclass(slots=True)
class _Node:
    """A moment of the chain: a reading of odometry, or a sight that was used."""

    stamp_ns: int
    T_odom_robot: SE2
    belief: Belief
    sight: Sight | None = None


class EkfEstimator:
    """One robot's. `noise` holds the scales it has learned."""

    def __init__(self, config: EkfConfig | None = None) -> None:
        self._config = config or EkfConfig()
        self.noise = NoiseModel(self._config.noise)
        self._history = OdometryHistory(span_s=_HORIZON_NS / 1e9)
        self._nodes: list[_Node] = []
        self._constants: Array = np.array([1.0, 1.0, 0.0, 0.0])
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
        mean = self._nodes[-1].belief.mean[LINEAR:] if self._nodes else self._constants
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
            if _another_frame(newest, reading):
                self._lose()
            elif reading.stamp_ns <= newest.stamp_ns:
                return
        self._history.add(reading)
        if self._nodes:
            self._insert(_Node(reading.stamp_ns, reading.pose, self._nodes[0].belief))
            self._forget(reading.stamp_ns - _HORIZON_NS)

    def add_camera_pose(self, pose: TrackedPose) -> bool:
        if not is_plausible_pose(pose) or pose.stamp_ns in self._stamps:
            return False
        delay_s = self.constants["delay_s"]
        at_ns = pose.stamp_ns - round(delay_s * 1e9)
        T_odom_robot = self._history.at(at_ns)
        if T_odom_robot is None or (self._nodes and at_ns < self._nodes[0].stamp_ns):
            return False
        self._told = None
        self._stamps.append(pose.stamp_ns)
        seen, covariance = np.array([pose.x, pose.y, pose.yaw]), _full(pose.covariance)
        if not self._nodes:
            self._begin(at_ns, T_odom_robot, seen, covariance)
            self._camera_stamp_ns = pose.stamp_ns
            return True
        before = self._nodes[max(0, bisect_right(self._nodes, at_ns, key=_stamp) - 1)]
        belief = self._driven(before, at_ns, T_odom_robot)
        sight = Sight(seen, covariance, delay_s, velocity(belief.mean, self._motion_around(at_ns, T_odom_robot)))
        found = innovation(belief, sight, self.noise)
        if not found.nis <= GATE_NIS:
            return self._refuse(Refused(at_ns, T_odom_robot, seen, covariance), pose.stamp_ns)
        self._watch.add_used(found.nis)
        self._recovery.clear()
        self.noise.learn(found.difference, found.covariance, found.difference_slopes, found.slopes)
        self._insert(_Node(at_ns, T_odom_robot, belief, sight))
        self._camera_stamp_ns = max(pose.stamp_ns, self._camera_stamp_ns or pose.stamp_ns)
        return True

    def estimate(self, now_ns: int) -> Estimate:
        if self._told is None or self._told[0] != now_ns:
            self._told = (now_ns, self._estimate(now_ns))
        return self._told[1]

    def _estimate(self, now_ns: int) -> Estimate:
        if not self._nodes or self._camera_stamp_ns is None:
            state = Localization.NEVER if self._last_pose is None else Localization.LOST
            return Estimate(state, self._last_pose, None)
        early_ns = round(self.constants["delay_s"] * 1e9) if self._config.reference is Reference.CAMERA else 0
        at_ns = now_ns - early_ns
        node = self._nodes[max(0, bisect_right(self._nodes, at_ns, key=_stamp) - 1)]
        T_odom_robot, unknown = self._odometry_at(at_ns, node)
        belief = self._driven(node, at_ns, T_odom_robot)
        covariance = belief.covariance[:3, :3] + unknown
        if self._config.reference is Reference.CAMERA:
            moves = velocity(belief.mean, self._motion_around(at_ns, T_odom_robot))
            sees = Sight(belief.mean[:3], covariance, 0.0, moves).jacobian()
            covariance = sees @ belief.covariance @ sees.T + unknown
        x, y, yaw = (float(value) for value in belief.mean[:3])
        self._last_pose = SE2(x, y, yaw)
        xx, xy, xt, yy, yt, tt = (float(value) for value in covariance[np.triu_indices(3)])
        silent_s = (now_ns - self._camera_stamp_ns) / 1e9
        config = self._config
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
        self._nodes = [_Node(stamp_ns, T_odom_robot, belief)]
        self._recovery.clear()
        for reading in self._history.after(stamp_ns):
            self._insert(_Node(reading.stamp_ns, reading.pose, belief))

    def _refuse(self, refused: Refused, stamp_ns: int) -> bool:
        """Whether it is not refused after all: enough of its like say that the filter is wrong."""
        self._watch.add_refused()
        if not self._recovery.add(refused):
            return False
        self._keep_constants(doubted=True)
        self._begin(refused.stamp_ns, refused.T_odom_robot, refused.pose, refused.covariance)
        self._camera_stamp_ns = stamp_ns
        return True

    def _insert(self, node: _Node) -> None:
        """Puts the node in its place and drives it and all later ones anew."""
        place = bisect_right(self._nodes, node.stamp_ns, key=_stamp)
        if place == 0:
            return
        self._nodes.insert(place, node)
        for before, after in zip(self._nodes[place - 1 :], self._nodes[place:], strict=False):
            belief = self._driven(before, after.stamp_ns, after.T_odom_robot)
            after.belief = belief if after.sight is None else updated(belief, after.sight, self.noise)
        if not self._nodes[-1].belief.is_sound:
            self._constants = np.array([1.0, 1.0, 0.0, 0.0])
            self._constants_covariance = np.diag(self.noise.constants())
            self._nodes.clear()
            self._lose()

    def _driven(self, node: _Node, stamp_ns: int, T_odom_robot: SE2) -> Belief:
        dt_s = (stamp_ns - node.stamp_ns) / 1e9
        if dt_s <= 0.0:
            return node.belief
        return predicted(node.belief, Motion.between(node.T_odom_robot, T_odom_robot, dt_s), self.noise)

    def _motion_around(self, stamp_ns: int, T_odom_robot: SE2) -> Motion:
        """What odometry says of the moment; standing where it says nothing."""
        before = self._history.at(stamp_ns - _AROUND_NS) or T_odom_robot
        after = self._history.at(stamp_ns + _AROUND_NS) or T_odom_robot
        return Motion.between(before, after, 2 * _AROUND_NS / 1e9)

    def _odometry_at(self, stamp_ns: int, node: _Node) -> tuple[SE2, Array]:
        """T_odom_robot at that moment, and the covariance (3, 3) of what has happened since odometry was last heard."""
        newest = self._history.newest
        if newest is None or stamp_ns <= newest.stamp_ns:
            return self._history.at(stamp_ns) or node.T_odom_robot, np.zeros((3, 3))
        silent_s = (stamp_ns - newest.stamp_ns) / 1e9
        held_s, beyond_s = min(silent_s, _HOLD_S), min(max(silent_s - _HOLD_S, 0.0), 3600.0)
        linear, angular = newest.twist.linear_mps, newest.twist.angular_radps
        ahead = SE2.exp(held_s * linear, 0.0, held_s * angular)
        gained_s2 = 0.5 * held_s**2
        way = math.hypot(self._config.acceleration_mps2 * gained_s2, linear * beyond_s)
        turn = math.hypot(self._config.acceleration_radps2 * gained_s2, angular * beyond_s)
        return newest.pose @ ahead, np.diag([way**2, way**2, turn**2])

    def _forget(self, before_ns: int) -> None:
        """Drops the nodes that no pose can go back to; the newest of them stays as the ground that the others stand on."""
        keep_from = max(bisect_right(self._nodes, before_ns, key=_stamp) - 1, len(self._nodes) - _MOST_NODES, 0)
        del self._nodes[:keep_from]

    def _lose(self) -> None:
        """Odometry's frame is another one from now on; what was learned of the base and the cameras stays."""
        if self._nodes:
            x, y, yaw = (float(value) for value in self._nodes[-1].belief.mean[:3])
            self._last_pose = SE2(x, y, yaw)
            self._keep_constants(doubted=False)
        self._history.clear()
        self._nodes.clear()
        self._recovery.clear()
        self._stamps.clear()
        self._camera_stamp_ns = None

    def _keep_constants(self, *, doubted: bool) -> None:
        """For the next chain; `doubted` when something was wrong, perhaps these."""
        belief = self._nodes[-1].belief
        self._constants = belief.mean[LINEAR:].copy()
        self._constants_covariance = belief.covariance[LINEAR:, LINEAR:].copy()
        if doubted:
            held = np.diag(self._constants_covariance)
            self._constants_covariance = np.diag(np.minimum(4.0 * held, self.noise.constants()))


def _another_frame(before: OdometryReading, after: OdometryReading) -> bool:
    """Whether the base restarted, said so or not, or the clock was set back."""
    if after.session != before.session or after.stamp_ns < before.stamp_ns - _CLOCK_SET_BACK_NS:
        return True
    dt_s = max(0.0, (after.stamp_ns - before.stamp_ns) / 1e9)
    return before.pose.distance_to(after.pose) > _JUMP_M + _JUMP_MPS * dt_s


def _full(covariance: tuple[float, float, float, float, float, float]) -> Array:
    """The symmetric matrix (3, 3) of an upper triangle."""
    xx, xy, xt, yy, yt, tt = covariance
    return np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])


def _stamp(node: _Node) -> int:
    return node.stamp_ns
