"""A differential-drive vehicle with its faults: limits, late motors, slipping wheels, odometry that lies, a watchdog.

The base holds a twist until the next one; without a set-point for `WATCHDOG_S` it stops. What the wheels do (`v`, `w`) is
limited; what the floor makes of it is less by the slip; what the encoders report is scaled and noisy. So truth and odometry
part ways as they do on a real robot (docs/architecture.md, "The simulated base").
"""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from shapely import affinity
from shapely.geometry import Polygon

from geometry import SE2
from protocol.lab import SimulatedDrive, VehicleSpec

WATCHDOG_S = 0.3
"""A base without a set-point for this long stops."""
_SLIP_TIME_CONSTANT_S = 0.5
"""How long a wheel keeps slipping about as much as it does now."""
_IDLE_DRAIN_PER_S = 1.0 / (8 * 3600)
_DRAIN_PER_M = 1.0 / 8000
_WHEEL_INSET = 0.9
"""Half the track width as a share of half the footprint's width."""


@dataclass(frozen=True, slots=True)
class Motion:
    """What one step would do: the true pose it leads to, and the way of each wheel on the ground and by its motor (m)."""

    pose: SE2
    left_m: float
    right_m: float
    left_wheel_m: float
    right_wheel_m: float


class SimulatedVehicle:
    """The state of one base. The world asks it to `plan` a step, then either `commit`s it or lets it `stall`."""

    def __init__(self, spec: VehicleSpec, drive: SimulatedDrive, pose: SE2, rng: np.random.Generator) -> None:
        self.spec = spec
        self.pose = pose
        self.linear_mps = 0.0
        self.angular_radps = 0.0
        self.odometry = SE2.identity()
        self.measured_linear_mps = 0.0
        self.measured_angular_radps = 0.0
        self.battery = 1.0
        self.range_noise = 0.0
        self._drive = drive
        self._rng = rng
        self._wheel_v = 0.0
        self._wheel_w = 0.0
        self._target = (0.0, 0.0)
        self._pending: deque[tuple[float, float, float]] = deque()
        self._heard_s = -math.inf
        self._slip = np.array([0.5, 0.5])
        self._half_track_m = _WHEEL_INSET * max(abs(y) for _, y in spec.footprint)
        self._footprint = Polygon(spec.footprint)
        self.radius_m = max(math.hypot(x, y) for x, y in spec.footprint)

    def footprint_at(self, pose: SE2) -> Polygon:
        """The footprint on the map (m) with the rotation centre at `pose`."""
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        return affinity.affine_transform(self._footprint, [c, -s, s, c, pose.x, pose.y])

    def set_drive(self, linear_mps: float, angular_radps: float, now_s: float) -> None:
        """Takes a twist to hold, clipped to the limits; the motors follow after their delay. ValueError unless finite."""
        if not (math.isfinite(linear_mps) and math.isfinite(angular_radps)):
            raise ValueError(f"a twist must be finite, got ({linear_mps}, {angular_radps})")
        limits = self.spec.limits
        linear = min(max(linear_mps, -limits.speed_mps), limits.speed_mps)
        angular = min(max(angular_radps, -limits.yaw_rate_radps), limits.yaw_rate_radps)
        self._pending.append((now_s + self._drive.delay_s, linear, angular))
        self._heard_s = now_s

    def plan(self, now_s: float, step_s: float) -> Motion:
        """Moves the motors on by one step and says where that leads. Draws the same amount of chance every step."""
        self._follow_target(now_s, step_s)
        slip, noise = self._draw(step_s)
        v, w, half = self._wheel_v, self._wheel_w, self._half_track_m
        left, right = (v - w * half) * step_s, (v + w * half) * step_s
        true_left, true_right = left * (1.0 - slip[0]), right * (1.0 - slip[1])
        return Motion(
            _rolled(self.pose, true_left, true_right, half),
            true_left,
            true_right,
            left * self._drive.left_scale * (1.0 + noise[0]),
            right * self._drive.right_scale * (1.0 + noise[1]),
        )

    def commit(self, motion: Motion, step_s: float) -> None:
        """The way was free."""
        width = 2.0 * self._half_track_m
        self.pose = motion.pose
        self.linear_mps = (motion.left_m + motion.right_m) / 2.0 / step_s
        self.angular_radps = (motion.right_m - motion.left_m) / width / step_s
        self.odometry = _rolled(self.odometry, motion.left_wheel_m, motion.right_wheel_m, self._half_track_m)
        self.measured_linear_mps = (motion.left_wheel_m + motion.right_wheel_m) / 2.0 / step_s
        self.measured_angular_radps = (motion.right_wheel_m - motion.left_wheel_m) / width / step_s
        way = (abs(motion.left_m) + abs(motion.right_m)) / 2.0
        self.battery = max(0.0, self.battery - _IDLE_DRAIN_PER_S * step_s - _DRAIN_PER_M * way)

    def stall(self) -> None:
        """Something stands in the way: the base stands still and its wheels with it."""
        self.linear_mps = self.angular_radps = 0.0
        self.measured_linear_mps = self.measured_angular_radps = 0.0
        self._wheel_v = self._wheel_w = 0.0

    def _follow_target(self, now_s: float, step_s: float) -> None:
        while self._pending and self._pending[0][0] <= now_s:
            _, linear, angular = self._pending.popleft()
            self._target = (linear, angular)
        if now_s - self._heard_s > WATCHDOG_S:
            self._pending.clear()
            self._target = (0.0, 0.0)
        limits = self.spec.limits
        self._wheel_v = _approached(
            self._wheel_v, self._target[0], limits.acceleration_mps2 * step_s, limits.braking_mps2 * step_s
        )
        turn = limits.yaw_acceleration_radps2 * step_s
        self._wheel_w = _approached(self._wheel_w, self._target[1], turn, turn)

    def _draw(self, step_s: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Slip of both wheels (a share that wanders within 0 and the described slip) and noise of both encoders."""
        draw = self._rng.standard_normal(5)
        keep = math.exp(-step_s / _SLIP_TIME_CONSTANT_S)
        self._slip = np.clip(0.5 + keep * (self._slip - 0.5) + 0.3 * math.sqrt(1.0 - keep * keep) * draw[:2], 0.0, 1.0)
        self.range_noise = float(draw[4])
        share, noise = self._drive.slip, self._drive.noise
        return (
            (share * float(self._slip[0]), share * float(self._slip[1])),
            (noise * float(draw[2]), noise * float(draw[3])),
        )


def _rolled(pose: SE2, left_m: float, right_m: float, half_track_m: float) -> SE2:
    """The pose after both wheels rolled that far, along the chord at the heading of mid-step."""
    way, turn = (left_m + right_m) / 2.0, (right_m - left_m) / (2.0 * half_track_m)
    heading = pose.yaw + turn / 2.0
    return SE2(pose.x + way * math.cos(heading), pose.y + way * math.sin(heading), pose.yaw + turn)


def _approached(current: float, target: float, faster: float, slower: float) -> float:
    """One step towards the target: at most `faster` when gaining speed, at most `slower` when losing it; a change of
    direction passes through standstill."""
    if current * target < 0.0:
        target = 0.0
    limit = slower if abs(target) < abs(current) else faster
    return current + min(max(target - current, -limit), limit)
