"""Whether a camera still hangs where it was calibrated: its floor tags are compared with where they were in the image.

The comparison is between pictures, not with the lab description: what was measured wrongly by hand stays the same and does
not count, so a few millimetres suffice. A camera that moves takes all its tags along; one tag that moves alone was kicked.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from localization.calibration.extrinsics import MIN_TAGS
from localization.calibration.sighting import FloorSighting

Array = NDArray[np.float64]

_MOVED_M = 0.003
"""On the floor: a tilt of 0.06 degrees, three metres up."""
_DESCRIBED_M = 0.015
"""Tags that were not seen when the camera was calibrated are compared with the description, as good as that is."""
_SIGMAS = 6.0
_IN_A_ROW = 3
_PATIENCE = 5
"""Looks in a row without the floor tags after which there is no hurry to find them again."""


class DriftWatch:
    """Judges looks at the floor tags. `described` (tag id -> (4, 2), pixels) says where tags should be that `reference` does
    not have."""

    def __init__(self, reference: FloorSighting, described: Mapping[int, Array], size_m: float) -> None:
        self._size_m = size_m
        self._places = {**described, **reference.corners}
        self._m_per_px = {tag: size_m / _side_px(corners) for tag, corners in self._places.items()}
        self._limit_m = {
            tag: max(_MOVED_M, _SIGMAS * reference.corner_noise_px * self._m_per_px[tag])
            if tag in reference.corners
            else _DESCRIBED_M
            for tag in self._places
        }
        self._suspicions = 0
        self._misses = 0
        self._kicks: dict[int, int] = {}
        self._off_m: dict[int, float] = {}

    @property
    def suspicious(self) -> bool:
        """Whether another look should be taken at once, and at the whole picture."""
        return self._suspicions > 0 or 0 < self._misses < _PATIENCE

    @property
    def displaced_m(self) -> dict[int, float]:
        """Floor tags that no longer lie where they did, though the camera stands still: by how much (m)."""
        return {tag: self._off_m[tag] for tag, count in sorted(self._kicks.items()) if count >= _IN_A_ROW}

    def moved_m(self, seen: Mapping[int, Array]) -> float | None:
        """Takes the corners of one complete look at the floor tags; how far the camera's picture of the floor moved (m, median
        over tags) once that is sure, else None."""
        common = sorted(set(seen) & set(self._places))
        self._misses = self._misses + 1 if len(common) < MIN_TAGS else 0
        off_m = {tag: _rms(seen[tag] - self._places[tag]) * self._m_per_px[tag] for tag in common}
        moved = [tag for tag in common if off_m[tag] > self._limit_m[tag]]
        # More than half: of two tags both must have moved.
        camera = len(common) >= MIN_TAGS and 2 * len(moved) > len(common)
        self._suspicions = self._suspicions + 1 if camera else 0
        if not camera and len(common) >= MIN_TAGS:
            for tag in common:
                self._kicks[tag] = self._kicks.get(tag, 0) + 1 if tag in moved else 0
            self._off_m.update(off_m)
        return float(np.median([off_m[tag] for tag in moved])) if self._suspicions >= _IN_A_ROW else None


def _side_px(corners: Array) -> float:
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).mean())


def _rms(offsets: Array) -> float:
    return float(np.sqrt(np.square(offsets).sum(axis=1).mean()))
