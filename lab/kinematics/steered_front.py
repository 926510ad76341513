"""A tricycle: one wheel in front that drives and steers, a fixed axle behind (the AGV of spec gpss). Its rotation centre is the
middle of the rear axle, the steered wheel stands the wheelbase L ahead of it:

    v = u cos(delta),  w = u sin(delta) / L

with the wheel's speed u and its steering angle delta, -90..90 degrees. Any twist has such a pair, turning on the spot
included (delta = 90 degrees), but the wheel must be turned there first, at a limited rate. While it is, the firmware
drives only as much as already points the right way.
"""

import math

import numpy as np

from geometry import SE2
from lab.kinematics.kinematics import Chance, Measured, Motion, approached, rolled
from protocol.lab import SimulatedDrive, VehicleSpec

WHEELBASE_SHARE = 0.8
"""The wheelbase as a share of how far the outline reaches ahead of the rotation centre."""
_STANDS_MPS = 1e-6


def wheelbase_of(spec: VehicleSpec) -> float:
    """Metres from the rear axle to the steered wheel."""
    return WHEELBASE_SHARE * max(x for x, _ in spec.footprint)


class SteeredFront:
    """Readings: the way of the wheel (m) and its steering angle (rad), which is read with a small constant error."""

    def __init__(self, spec: VehicleSpec, drive: SimulatedDrive, rng: np.random.Generator) -> None:
        self.wheelbase_m = wheelbase_of(spec)
        self.wheel_mps = 0.0
        self.steering_rad = 0.0
        self._limits = spec.limits
        self._drive = drive
        self._steering_offset_rad = drive.slip * 0.25 * float(np.clip(rng.standard_normal(), -2.0, 2.0))

    def plan(self, pose: SE2, target: tuple[float, float], chance: Chance, step_s: float) -> Motion:
        self._follow(target, step_s)
        wheel = self.wheel_mps * step_s
        true_wheel = wheel * (1.0 - self._drive.slip * chance.slip[0])
        way = true_wheel * math.cos(self.steering_rad)
        turn = true_wheel * math.sin(self.steering_rad) / self.wheelbase_m
        read = wheel * self._drive.left_scale * (1.0 + self._drive.noise * chance.noise[0])
        return Motion(rolled(pose, way, turn), way, turn, abs(true_wheel), (read, self.steering_rad))

    def commit(self, motion: Motion, step_s: float) -> Measured:
        wheel, steering = motion.encoders
        steering += self._steering_offset_rad
        way, turn = wheel * math.cos(steering), wheel * math.sin(steering) / self.wheelbase_m
        return Measured(way, turn, way / step_s, turn / step_s)

    def stall(self) -> None:
        self.wheel_mps = 0.0

    def _follow(self, target: tuple[float, float], step_s: float) -> None:
        v, w = target
        across = w * self.wheelbase_m
        wanted_mps = math.hypot(v, across)
        if wanted_mps > _STANDS_MPS:  # a wheel that is to stand keeps its angle
            backwards = v < 0.0 or (v == 0.0 and self.steering_rad * across < 0.0)
            wanted_rad = math.atan2(-across, -v) if backwards else math.atan2(across, v)
            wanted_mps = -wanted_mps if backwards else wanted_mps
            self._steer(wanted_rad, step_s)
            wanted_mps *= max(0.0, math.cos(wanted_rad - self.steering_rad)) ** 2
        limits = self._limits
        self.wheel_mps = approached(
            self.wheel_mps, wanted_mps, limits.acceleration_mps2 * step_s, limits.braking_mps2 * step_s
        )

    def _steer(self, wanted_rad: float, step_s: float) -> None:
        """At the steering rate, and never so far that the vehicle turned faster than it may at the wheel's speed."""
        most_across = self._limits.yaw_rate_radps * self.wheelbase_m
        if abs(self.wheel_mps) > most_across:
            most_rad = math.asin(most_across / abs(self.wheel_mps))
            wanted_rad = min(max(wanted_rad, -most_rad), most_rad)
        reach = self._drive.steering_rate_radps * step_s
        self.steering_rad += min(max(wanted_rad - self.steering_rad, -reach), reach)
