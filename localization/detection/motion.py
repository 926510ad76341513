"""Where something moves that nobody follows: a newcomer is looked at as soon as it comes, while the rest of the picture waits for
its turn (spec localization, "What the reports ask for next": newcomers)."""

import math
from collections.abc import Sequence
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.detection.detector import TagDetector
from localization.detection.observation import (
    Box,
    Image,
    TagObservation,
    is_whole_in,
    to_grey,
    without_duplicates,
)
from localization.detection.tiles import Level

_SAMPLES_PER_SIDE = 4
_CHANGED = 25
"""Grey levels between two frames; black and white differ by a hundred and more, noise by a few."""
_LEAST_SAMPLES = 12
"""Of a patch, after it was grown by one sample all round: one noisy sample alone makes nine."""
_MOST_PATCHES = 4
"""Larger patches take turns; people's arms and lights are such patches too."""
_MOST_MS = 1.2
_OWN_SIDES = 2.0
"""Around a tag that was found so many of its sides are its own vehicle's."""


class MotionSearch:
    """Compares every frame, thinned out, with the one before, and searches one changed patch."""

    def __init__(self, detector: TagDetector) -> None:
        self._detector = detector
        self._levels: tuple[Level, ...] = ()
        self._every_px = 8
        self._before: NDArray[np.int16] | None = None
        self._turn = 0

    def aim(self, levels: Sequence[Level]) -> None:
        """Looks for the tags of these levels from now on."""
        self._levels = tuple(levels)
        self._every_px = max(2, int(min((level.least_px for level in levels), default=32.0) / _SAMPLES_PER_SIDE))
        self._before = None

    def find(self, image: Image, found: Sequence[TagObservation]) -> list[TagObservation]:
        """Tags in a patch that changed and does not belong to the tags `found` already; a part of the picture each time."""
        patch = self._patch(image, found)
        if patch is None:
            return []
        seen: list[TagObservation] = []
        for level in self._levels:
            part = _part(patch, level, image.shape[1], image.shape[0])
            grey = to_grey(part.of(image))
            tags = self._detector.detect(grey, level.decimation, (part.left, part.top))
            seen += [tag for tag in tags if is_whole_in(tag, part)]
        return without_duplicates(seen)

    def _patch(self, image: Image, found: Sequence[TagObservation]) -> Box | None:
        every = self._every_px
        thin = image[every // 2 :: every, every // 2 :: every]
        now = (thin if thin.ndim == 2 else thin[..., 1]).astype(np.int16)
        before, self._before = self._before, now
        if before is None or before.shape != now.shape:
            return None
        change = now - before
        change -= np.int16(round(float(change.mean())))  # the light or the exposure, everywhere
        changed = (np.abs(change) > _CHANGED).astype(np.uint8)
        for tag in found:
            reach = _OWN_SIDES * tag.side_px
            x, y = (float(value) for value in tag.centre)
            low_x, low_y = max(0, int((x - reach) / every)), max(0, int((y - reach) / every))
            changed[low_y : int((y + reach) / every) + 1, low_x : int((x + reach) / every) + 1] = 0
        if not changed.any():
            return None
        grown = cv2.dilate(changed, np.ones((3, 3), np.uint8))
        _, _, stats, _ = cv2.connectedComponentsWithStats(grown)
        patches = stats[1:][stats[1:, cv2.CC_STAT_AREA] >= _LEAST_SAMPLES]
        if len(patches) == 0:
            return None
        largest = patches[np.argsort(-patches[:, cv2.CC_STAT_AREA], kind="stable")][:_MOST_PATCHES]
        self._turn += 1
        left, top, width, height, _ = cast("list[int]", largest[self._turn % len(largest)].tolist())
        return Box(left * every, top * every, (left + width) * every, (top + height) * every)


def _part(patch: Box, level: Level, width: int, height: int) -> Box:
    """The patch and one tag around it, or its middle where that is too much to be searched in a moment."""
    most = max(2 * level.footprint_px, math.isqrt(int(_MOST_MS / level.nominal_ms(1))))
    x, y = (patch.left + patch.right) // 2, (patch.top + patch.bottom) // 2
    reach_x = min(most, patch.right - patch.left + level.footprint_px) // 2
    reach_y = min(most, patch.bottom - patch.top + level.footprint_px) // 2
    return Box(max(0, x - reach_x), max(0, y - reach_y), min(width, x + reach_x), min(height, y + reach_y))
