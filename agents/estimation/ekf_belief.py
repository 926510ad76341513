"""The Kalman filter's two steps on one belief: prediction by odometry and correction by a camera (Joseph form). Pure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.estimation.ekf_model import LINEAR, SIZE, Motion, Sight, corrected, motion_jacobians, moved
from agents.estimation.ekf_noise import CAMERA, SCALES, NoiseModel

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """State (7,), its covariance (7, 7), and the derivatives of both by the logarithms of the noises' scales, (3, 7) and
    (3, 7, 7)."""

    mean: Array
    covariance: Array
    mean_slopes: Array
    slopes: Array

    @classmethod
    def at(cls, pose: Array, covariance: Array, constants: Array, constants_covariance: Array) -> "Belief":
        """Around a pose (3,) with its covariance (3, 3); linear, angular, curvature and delay (4,) with theirs (4, 4)."""
        whole = np.zeros((SIZE, SIZE))
        whole[:3, :3] = covariance
        whole[LINEAR:, LINEAR:] = constants_covariance
        return cls(np.concatenate([pose, constants]), whole, np.zeros((SCALES, SIZE)), np.zeros((SCALES, SIZE, SIZE)))

    @property
    def is_sound(self) -> bool:
        """Whether it is still a belief: finite, no negative variance."""
        return bool(
            np.isfinite(self.mean).all()
            and np.isfinite(self.covariance).all()
            and (np.diag(self.covariance) >= 0.0).all()
        )


def predicted(belief: Belief, motion: Motion, noise: NoiseModel) -> Belief:
    """The belief after the motion."""
    by_state, by_twist = motion_jacobians(belief.mean, motion)
    added, parts = noise.of_motion(motion, by_twist)
    covariance = by_state @ belief.covariance @ by_state.T
    covariance[:3, :3] += added
    constants = noise.of_constants(motion, belief.covariance)
    covariance[range(LINEAR, SIZE), range(LINEAR, SIZE)] += constants
    slopes = by_state @ belief.slopes @ by_state.T
    slopes[: len(parts), :3, :3] += parts
    return Belief(moved(belief.mean, motion), _symmetric(covariance), belief.mean_slopes @ by_state.T, slopes)


@dataclass(frozen=True, slots=True, eq=False)
class Innovation:
    """What a sight says against a belief: the difference (3,), its covariance (3, 3), and the slopes of both by the scales,
    (3, 3) and (3, 3, 3); `nis` is the normalised innovation squared, chi-square with 3 degrees of freedom when all is well."""

    difference: Array
    covariance: Array
    difference_slopes: Array
    slopes: Array
    nis: float


def innovation(belief: Belief, sight: Sight, noise: NoiseModel) -> Innovation:
    """Without any change to the belief."""
    sees = sight.jacobian()
    camera = noise.of_camera(sight.covariance)
    covariance = _symmetric(sees @ belief.covariance @ sees.T + camera)
    slopes = sees @ belief.slopes @ sees.T
    slopes[CAMERA] += noise.scales[CAMERA] * sight.covariance
    difference = sight.innovation(belief.mean)
    nis = float(difference @ np.linalg.solve(covariance, difference))
    return Innovation(difference, covariance, -belief.mean_slopes @ sees.T, slopes, nis)


def updated(belief: Belief, sight: Sight, noise: NoiseModel) -> Belief:
    """The belief after the sight."""
    sees = sight.jacobian()
    camera = noise.of_camera(sight.covariance)
    covariance = _symmetric(sees @ belief.covariance @ sees.T + camera)
    gain = np.linalg.solve(covariance, sees @ belief.covariance).T
    keeps = np.eye(SIZE) - gain @ sees
    difference = sight.innovation(belief.mean)
    weighed = np.linalg.solve(covariance, difference)
    claimed = noise.scales[CAMERA] * sight.covariance
    # The gain's own slope: K = P H^T S^-1, hence dK = ((I - K H) dP H^T - K dR) S^-1.
    mean_slopes = belief.mean_slopes @ keeps.T + (keeps @ belief.slopes @ sees.T) @ weighed
    mean_slopes[CAMERA] -= gain @ claimed @ weighed
    slopes = keeps @ belief.slopes @ keeps.T
    slopes[CAMERA] += gain @ claimed @ gain.T
    return Belief(
        corrected(belief.mean, gain @ difference),
        _symmetric(keeps @ belief.covariance @ keeps.T + gain @ camera @ gain.T),
        mean_slopes,
        slopes,
    )


def _symmetric(matrix: Array) -> Array:
    return 0.5 * (matrix + matrix.T)
