"""What one camera saw of the floor tags, averaged over frames: what calibrations are made from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Corners = dict[int, Array]
"""Tag id -> corners (4, 2), pixels."""


@dataclass(frozen=True, slots=True, eq=False)
class FloorSighting:
    """Mean corners of the floor tags (tag id -> (4, 2), pixels) over the last `frames` frames, of which the newest has
    `stamp_ns`. `corner_noise_px` is the standard deviation of a single frame's corner, per axis."""

    camera: str
    stamp_ns: int
    frames: int
    corners: Corners
    corner_noise_px: float


def averaged(camera: str, stamp_ns: int, samples: Sequence[Mapping[int, Array]]) -> FloorSighting:
    """The mean of the tags that at least half of the frames show; the noise is the median over tags."""
    by_tag: dict[int, list[Array]] = {}
    for sample in samples:
        for tag_id, corners in sample.items():
            by_tag.setdefault(tag_id, []).append(corners)
    steady = {tag: np.array(seen) for tag, seen in sorted(by_tag.items()) if 2 * len(seen) >= len(samples)}
    spreads = [float(np.sqrt(seen.var(axis=0, ddof=1).mean())) for seen in steady.values() if len(seen) > 1]
    return FloorSighting(
        camera=camera,
        stamp_ns=stamp_ns,
        frames=len(samples),
        corners={tag: seen.mean(axis=0) for tag, seen in steady.items()},
        corner_noise_px=float(np.median(spreads)) if spreads else 0.0,
    )
