"""How much noise there is: that of odometry from what it measures, and how the scales of all noises are learned from the
innovations.

Three scales (factors on variances) are learned: of the way's noise, of the turn's, and of the camera's. Each innovation has a
likelihood that depends on them through the filter's covariance; its slope and its Fisher information, by the covariance's
derivatives that run along with it, make a recursive maximum likelihood estimate (Ljung and Soederstrom 1983, ch. 3; the terms
are those of Mehra 1970). A scale is thus right when innovations are as large as predicted.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.estimation.ekf_model import LINEAR, Motion

Array = NDArray[np.float64]

WAY, TURN, CAMERA = range(3)
SCALES = 3
_SHORTEST_S = 1e-3
_FARTHEST_LOG = math.log(3000.0)
_LONGEST_STEP = 0.3


@dataclass(frozen=True, slots=True)
class NoiseConfig:
    """What is assumed before anything is learned. Wheels slip: the way is wrong by `way_share` of itself, sideways by
    `aside_share` of the way, the turn by `turn_share` of itself and `turn_per_m` for each metre, all about constant for
    `holds_s` and then anew. `rest_m`, `rest_rad`: what moves without wheels noticing, per root second.

    `linear_sigma` to `delay_sigma_s`: how far off the constants of the state may be at the start; their `_walk`s are how
    much they change per root second of driving. `camera_floor_*`: errors that all poses of a place share and that no
    averaging removes. `scale_sigma`: of the logarithms of the scales before learning, (way, turn, camera). Wheels differ that
    much: the commands of the recorded runs need 150 to 200 times the noise assumed here for the way and 16 to 25 times for
    the turn, the simulated bases 0.05 and 0.12 times (docs/results.md, "Fusion"); good wheels tell of themselves slowly,
    as the camera drowns them, and a narrower belief would hold their noise up. `memory` is the number of poses that learning
    reaches back.
    """

    way_share: float = 0.02
    aside_share: float = 0.005
    turn_share: float = 0.05
    turn_per_m: float = 0.05
    holds_s: float = 0.5
    rest_m: float = 0.0005
    rest_rad: float = 0.001
    linear_sigma: float = 0.05
    angular_sigma: float = 0.08
    curvature_sigma_radpm: float = 0.05
    delay_sigma_s: float = 0.12
    linear_walk: float = 0.0005
    angular_walk: float = 0.001
    curvature_walk_radpm: float = 0.0005
    delay_walk_s: float = 0.0002
    camera_floor_m: float = 0.0005
    camera_floor_rad: float = 0.0005
    scale_sigma: tuple[float, float, float] = (3.0, 3.0, 0.3)
    memory: int = 600


class NoiseModel:
    """The noises of one robot with the scales learned so far."""

    def __init__(self, config: NoiseConfig) -> None:
        self.config = config
        self.scales: Array = np.ones(SCALES)
        self._log: Array = np.zeros(SCALES)
        self._prior: Array = np.diag(1.0 / np.square(config.scale_sigma))
        self._information: Array = np.zeros((SCALES, SCALES))
        self._keep = 1.0 - 1.0 / config.memory
        self._ceiling = np.square(
            [config.linear_sigma, config.angular_sigma, config.curvature_sigma_radpm, config.delay_sigma_s]
        )
        self._walk = np.square(
            [config.linear_walk, config.angular_walk, config.curvature_walk_radpm, config.delay_walk_s]
        )

        self._at_rest = np.square([config.rest_m, config.rest_m, config.rest_rad])

    def constants(self) -> Array:
        """Variances (4,) of linear, angular, curvature and delay at the start."""
        return self._ceiling.copy()

    def of_motion(self, motion: Motion, by_twist: Array) -> tuple[Array, Array]:
        """Covariance (3, 3) that a step adds to the pose, and its parts (2, 3, 3) by the scales of way and turn."""
        config = self.config
        # A relative error that holds for T is a random walk with the variance share^2 v^2 T per second.
        lasting = config.holds_s / max(motion.dt_s, _SHORTEST_S)
        way = motion.forward_m**2 + motion.left_m**2
        of_way = self.scales[WAY] * lasting * way
        of_turn = self.scales[TURN] * lasting
        variances = np.zeros((2, 3))
        variances[WAY, :2] = of_way * config.way_share**2, of_way * config.aside_share**2
        variances[TURN, 2] = of_turn * (config.turn_per_m**2 * way + (config.turn_share * motion.turn_rad) ** 2)
        parts = (by_twist * variances[:, None, :]) @ by_twist.T
        added = parts[WAY] + parts[TURN]
        added[range(3), range(3)] += self._at_rest * motion.dt_s
        return added, parts

    def of_constants(self, motion: Motion, covariance: Array) -> Array:
        """Variances (4,) that a step adds to linear, angular, curvature and delay: only while wheels turn, and never beyond
        what was assumed at the start."""
        if motion.forward_m == 0.0 and motion.turn_rad == 0.0:
            return np.zeros(4)
        held = covariance.diagonal()[LINEAR:]
        return np.clip(self._ceiling - held, 0.0, self._walk * motion.dt_s)

    def of_camera(self, covariance: Array) -> Array:
        """The covariance (3, 3) to reckon with where the camera claims this one."""
        floor = np.square([self.config.camera_floor_m, self.config.camera_floor_m, self.config.camera_floor_rad])
        return self.scales[CAMERA] * covariance + np.diag(floor)

    def learn(self, difference: Array, covariance: Array, difference_slopes: Array, slopes: Array) -> None:
        """From an innovation (3,) and its covariance (3, 3), with their derivatives by the scales' logarithms, (3, 3) and
        (3, 3, 3)."""
        inverse = np.linalg.inv(covariance)
        whitened = inverse @ difference
        shares = inverse @ slopes
        score = 0.5 * (np.einsum("i,kij,j->k", whitened, slopes, whitened) - np.einsum("kii->k", shares))
        score -= difference_slopes @ whitened
        fisher = 0.5 * np.einsum("kij,lji->kl", shares, shares) + difference_slopes @ inverse @ difference_slopes.T
        self._information = self._keep * self._information + fisher
        score -= (1.0 - self._keep) * self._prior @ self._log
        step = np.linalg.solve(self._information + self._prior, score)
        self._log = np.clip(self._log + np.clip(step, -_LONGEST_STEP, _LONGEST_STEP), -_FARTHEST_LOG, _FARTHEST_LOG)
        self.scales = np.exp(self._log)
