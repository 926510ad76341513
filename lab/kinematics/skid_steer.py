"""Four driven wheels that cannot steer (WifiBot): a turn drags all of them sideways over the floor.

The dragged wheels act as if they stood farther apart than they do: the base's firmware turns them with an effective track
width, and so do its encoders. What the floor makes of a turn is still less than that, by a share that changes from place to
place; no encoder sees it.
"""

import numpy as np

from geometry import SE2
from lab.kinematics.differential import DifferentialDrive, half_track_of
from lab.kinematics.kinematics import Chance, Measured, Motion, Wander
from protocol.lab import SimulatedDrive, VehicleSpec

EFFECTIVE_TRACK = 1.5
"""Effective over geometric track width; published values for four-wheel bases of this shape lie between 1.3 and 2."""
TURN_SLIP = 3.0
"""The share of a turn that may be lost, as a multiple of the described slip of a wheel."""


class SkidSteer:
    """Readings as of a differential drive with the effective track."""

    def __init__(self, spec: VehicleSpec, drive: SimulatedDrive, rng: np.random.Generator) -> None:
        self._wheels = DifferentialDrive(spec, drive, EFFECTIVE_TRACK * half_track_of(spec))
        self._most_lost = min(0.5, TURN_SLIP * drive.slip)
        self._lost = Wander(rng)

    def plan(self, pose: SE2, target: tuple[float, float], chance: Chance, step_s: float) -> Motion:
        return self._wheels.plan(pose, target, chance, step_s, 1.0 - self._most_lost * self._lost.step(step_s))

    def commit(self, motion: Motion, step_s: float) -> Measured:
        return self._wheels.commit(motion, step_s)

    def stall(self) -> None:
        self._wheels.stall()
