"""The learned floor: what each sample of a camera's view looks like when nothing stands there, and how much it varies.

Samples are learned one by one from consecutive frames that agree (`LEARN_FRAMES`), so floor that a robot uncovers later is
learned then. Frames are compared after dividing out the exposure: the median ratio of floor to background over what is known
and free. What matches is followed slowly; what deviates is never learned.

Known weakness: what stands still on the floor while it is learned is floor from then on, and the place shows as occupied
when it leaves. Backgrounds are therefore kept across restarts (`localization.floor.store`).
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

LEARN_FRAMES = 6
"""Consecutive frames that must agree before a sample counts as known: about a second at the observer's rate."""
_FOLLOW_S = 20.0
"""Time constant with which the background follows slow changes of the light."""
_SIGMAS = 6.0
_GREY_LEVELS, _SHARE = 8.0, 0.12
"""A sample deviates when it differs by more than so many grey levels plus this share of the background, and by more than
six standard deviations of its noise."""
_DARK = 12.0
"""Samples darker than this say nothing about the exposure."""
_BLIND_GAIN = 0.3
"""Exposure relative to the background below which the camera is not believed."""
_BLACK = 4.0
"""A floor whose median is darker is not seen at all."""


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """A frame against the background; arrays have the view's shape. `difference` is relative to the threshold: above 1 a
    sample deviates. `gain` is the frame's exposure over the background's, None when nothing is known to compare with."""

    known: NDArray[np.bool_]
    difference: NDArray[np.float32]
    normalised: NDArray[np.float32]
    gain: float | None
    black: bool

    @property
    def deviating(self) -> NDArray[np.bool_]:
        """Known samples that do not look like the floor."""
        return self.known & (self.difference > 1.0)

    @property
    def blind(self) -> bool:
        """Whether the frame is so dark (lights out, lens covered) that it says nothing."""
        return self.black or (self.gain is not None and self.gain < _BLIND_GAIN)


class Background:
    """Mean and noise variance of each sample, shape (R, C) or (R, C, 3), grey levels; `count` (R, C) of frames learned."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.mean = np.zeros(shape, np.float32)
        self.variance = np.zeros(shape, np.float32)
        self.count = np.zeros(shape[:2], np.int32)
        self._noise: NDArray[np.float32] | None = None

    @property
    def known(self) -> NDArray[np.bool_]:
        """Which samples are learned, shape (R, C)."""
        return self.count >= LEARN_FRAMES

    def compare(self, floor: NDArray[np.float32], trusted: NDArray[np.bool_]) -> Comparison:
        """The sampled floor (shape of the background) against what is known; the exposure is measured on `trusted` samples."""
        known = self.known
        gain = self._gain(floor, known & trusted)
        # Compared at the frame's own exposure: what a grey level means there is what its noise and contrast are made of.
        exposure = np.float32(1.0 if gain is None else max(gain, 0.01))
        expected = self.mean * exposure
        noise = self._noise_limit() * max(np.float32(1.0), exposure)
        limit = np.maximum(noise, _GREY_LEVELS + np.float32(_SHARE) * expected)
        difference = (np.abs(floor - expected) / limit).astype(np.float32, copy=False)
        if difference.ndim == 3:
            difference = difference.max(axis=2)
        black = trusted.any() and float(np.median(floor[trusted])) < _BLACK
        return Comparison(known, difference, floor / exposure, gain, bool(black))

    def learn(self, floor: NDArray[np.float32], free: NDArray[np.bool_]) -> None:
        """Counts a frame for the `free` samples that are not known yet; one that disagrees with what was gathered so far
        starts the sample anew."""
        young = free & ~self.known
        if not young.any():
            return
        sample, mean = floor[young], self.mean[young]
        limit = _GREY_LEVELS + _SHARE * mean
        agrees = np.abs(sample - mean) <= limit
        if agrees.ndim == 2:
            agrees = agrees.all(axis=1)
        agrees &= self.count[young] > 0
        count = np.where(agrees, self.count[young] + 1, 1)
        per_value = count if sample.ndim == 1 else count[:, None]
        kept = agrees if sample.ndim == 1 else agrees[:, None]
        before = np.where(kept, mean, sample)
        after = before + (sample - before) / per_value
        # Welford's update, with the variance kept divided by the count.
        spread = np.where(kept, self.variance[young], 0.0)
        self.variance[young] = spread + ((sample - before) * (sample - after) - spread) / per_value
        self.mean[young] = after
        self.count[young] = count
        self._noise = None

    def follow(self, comparison: Comparison, free: NDArray[np.bool_], elapsed_s: float) -> None:
        """Moves the known, free samples towards the frame, and all of them towards its exposure (what lies under an obstacle
        is lit by the same lamps)."""
        if comparison.gain is None:
            return
        rate = np.float32(min(1.0, max(0.0, elapsed_s) / _FOLLOW_S))
        matched = free & comparison.known & (comparison.difference <= 1.0)
        step = np.zeros_like(self.mean)
        np.subtract(comparison.normalised, self.mean, out=step, where=_spread(matched, step))
        self.mean += rate * step
        self.variance += np.where(_spread(matched, step), rate * (step * step - self.variance), np.float32(0.0))
        self.mean *= np.float32(1.0 + float(rate) * (comparison.gain - 1.0))
        self._noise = None

    def forget(self, samples: NDArray[np.bool_]) -> None:
        """Makes the samples (R, C) unknown, to be learned anew."""
        self.count[samples] = 0
        self._noise = None

    def _gain(self, floor: NDArray[np.float32], usable: NDArray[np.bool_]) -> float | None:
        mean, seen = (self.mean, floor) if floor.ndim == 2 else (self.mean.mean(axis=2), floor.mean(axis=2))
        usable = usable & (mean > _DARK)
        if np.count_nonzero(usable) < 20:
            return None
        return float(np.median(seen[usable] / mean[usable]))

    def _noise_limit(self) -> NDArray[np.float32]:
        """Six standard deviations of each sample's noise, grey levels."""
        if self._noise is None:
            # The variance of a few frames is itself noisy: neighbours are averaged, and none is below the typical one.
            smooth = np.asarray(cv2.blur(self.variance, (3, 3)), dtype=np.float32)
            known = self.known
            typical = np.float32(np.median(self.variance[known])) if known.any() else np.float32(0.0)
            self._noise = np.float32(_SIGMAS) * np.sqrt(np.maximum(smooth, typical))
        return self._noise


def _spread(samples: NDArray[np.bool_], like: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(R, C) to the shape of an image with or without a colour axis."""
    return samples if like.ndim == 2 else np.broadcast_to(samples[..., None], like.shape)
