"""Freke (spec mapping, "Freke, 2006"): two driven wheels of 20 cm in front, a castor behind, coarse encoders, a wheel base that
wobbles, so that a turn of 90 degrees comes out as 86 to 94."""

import math
from collections import deque

import numpy as np

from geometry import SE2
from lab.kinematics.differential import DifferentialDrive
from lab.kinematics.kinematics import Chance, Measured, Motion, Wander
from protocol.lab import SimulatedDrive, VehicleSpec

TRACK_M = 0.453
PULSE_M = (0.008591, 0.008651)
"""Way of the left and the right wheel per pulse: 75 pulses a turn."""
_WOBBLE_PER_SLIP_M = 1.0
"""The wheel base wobbles by the report's 2 cm where wheels slip by 2 %: one knob makes the base worse or perfect."""
_WOBBLE_TIME_S = 2.0
_RATE_WINDOW_S = 0.1
"""Speeds are those of the last tenth of a second: fewer pulses than that say little."""


class Freke:
    """A differential drive that counts pulses."""

    def __init__(self, spec: VehicleSpec, drive: SimulatedDrive, rng: np.random.Generator) -> None:
        self._wheels = DifferentialDrive(spec, drive, TRACK_M / 2.0)
        self._wobble_m = min(0.5 * TRACK_M, _WOBBLE_PER_SLIP_M * drive.slip)
        self._wander = Wander(rng, _WOBBLE_TIME_S)
        self._rolled = [0.0, 0.0]
        self._pulses = [0, 0]
        self._recent: deque[tuple[float, float, float]] = deque()

    def plan(self, pose: SE2, target: tuple[float, float], chance: Chance, step_s: float) -> Motion:
        track = TRACK_M + self._wobble_m * (2.0 * self._wander.step(step_s) - 1.0)
        return self._wheels.plan(pose, target, chance, step_s, TRACK_M / track)

    def commit(self, motion: Motion, step_s: float) -> Measured:
        left, right = (self._counted(wheel, way_m) for wheel, way_m in enumerate(motion.encoders))
        way, turn = (left + right) / 2.0, (right - left) / TRACK_M
        self._recent.append((step_s, way, turn))
        while sum(step for step, _, _ in self._recent) > _RATE_WINDOW_S + step_s / 2.0:
            self._recent.popleft()
        span_s = sum(step for step, _, _ in self._recent)
        return Measured(
            way, turn, sum(w for _, w, _ in self._recent) / span_s, sum(t for _, _, t in self._recent) / span_s
        )

    def stall(self) -> None:
        self._wheels.stall()
        self._recent.clear()

    def _counted(self, wheel: int, way_m: float) -> float:
        """Whole pulses of this step, as metres."""
        self._rolled[wheel] += way_m
        pulses = math.floor(self._rolled[wheel] / PULSE_M[wheel])
        new, self._pulses[wheel] = pulses - self._pulses[wheel], pulses
        return new * PULSE_M[wheel]
