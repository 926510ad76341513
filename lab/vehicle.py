"""A simulated vehicle with its faults: limits, late motors, slipping wheels, odometry that lies, a watchdog.

The base holds a twist until the next one; without a set-point for `WATCHDOG_S` it stops. What its motors make of the twist,
and what the encoders say of it, is its kind's (`lab.kinematics`). So truth and odometry part ways as they do on a real robot
(docs/architecture.md, "The simulated base").
"""

import math
from collections import deque

import numpy as np
from shapely import affinity
from shapely.geometry import Polygon

from geometry import SE2
from lab.kinematics import KINEMATICS, Motion, rolled
from lab.kinematics.kinematics import Chance, wandered
from protocol.lab import SimulatedDrive, VehicleSpec

WATCHDOG_S = 0.3
"""A base without a set-point for this long stops."""
_IDLE_DRAIN_PER_S = 1.0 / (8 * 3600)
_DRAIN_PER_M = 1.0 / 8000
_EXCHANGE_S = 60.0
"""Somebody puts a full battery into a vehicle that stands with a flat one for a minute, so that a lab may run for months."""


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
        self._target = (0.0, 0.0)
        self._pending: deque[tuple[float, float, float]] = deque()
        self._heard_s = -math.inf
        self._flat_s = 0.0
        self._slip = (0.5, 0.5)
        # A stream of its own: the chance of wheels and sensors is the same whatever the kind draws.
        self._kinematics = KINEMATICS[spec.kind](spec, drive, rng.spawn(1)[0])
        self.outline = np.asarray(spec.footprint, dtype=np.float64)
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
        self._hear(now_s)
        return self._kinematics.plan(self.pose, self._target, self._draw(step_s), step_s)

    def commit(self, motion: Motion, step_s: float) -> None:
        """The way was free."""
        measured = self._kinematics.commit(motion, step_s)
        self.pose = motion.pose
        self.linear_mps, self.angular_radps = motion.way_m / step_s, motion.turn_rad / step_s
        self.odometry = rolled(self.odometry, measured.way_m, measured.turn_rad)
        self.measured_linear_mps, self.measured_angular_radps = measured.linear_mps, measured.angular_radps
        self._drain(motion.rolled_m, step_s)

    def stall(self) -> None:
        """Something stands in the way: the base stands still and its wheels with it."""
        self.linear_mps = self.angular_radps = 0.0
        self.measured_linear_mps = self.measured_angular_radps = 0.0
        self._kinematics.stall()

    def _drain(self, rolled_m: float, step_s: float) -> None:
        self.battery = max(0.0, self.battery - _IDLE_DRAIN_PER_S * step_s - _DRAIN_PER_M * rolled_m)
        self._flat_s = self._flat_s + step_s if self.battery <= self.spec.battery.empty and rolled_m == 0.0 else 0.0
        if self._flat_s > _EXCHANGE_S:
            self.battery = 1.0

    def _hear(self, now_s: float) -> None:
        """Takes the set-points that have passed the motors' delay; the watchdog."""
        while self._pending and self._pending[0][0] <= now_s:
            _, linear, angular = self._pending.popleft()
            self._target = (linear, angular)
        if now_s - self._heard_s > WATCHDOG_S:
            self._pending.clear()
            self._target = (0.0, 0.0)

    def _draw(self, step_s: float) -> Chance:
        """Slip of both wheels (a share that wanders within 0 and the described slip), noise of both encoders and of the
        range sensor."""
        draw = self._rng.standard_normal(5)
        self._slip = (
            wandered(self._slip[0], float(draw[0]), step_s),
            wandered(self._slip[1], float(draw[1]), step_s),
        )
        self.range_noise = float(draw[4])
        return Chance(self._slip, (float(draw[2]), float(draw[3])))
