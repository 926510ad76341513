"""What each recorded camera saw of the floor tags: frames from all over the recording, corners averaged (spec localization,
"Better than the reports").

A vehicle that hides a tag for a while, a shadow or a wrong reading spoils some frames, so corners far from the median of
all frames are left out of the mean. Of a camera that was moved while recording only the time before counts.
"""

from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.calibration import FloorSighting
from localization.detection import FullSearch, TagDetector, TagObservation
from localization.offline.frames import Grey, RecordedCamera
from localization.sources import BrokenFrameError
from localization.tags import KnownTags, TagKey

Array = NDArray[np.float64]

FRAMES = 32
_FIRST_FRAMES = 5
"""They say where the camera hung at the beginning."""
_MOVED_RAD = 0.0015
"""Corners this far, seen from the camera, from where they were at the beginning are of a camera that was moved: 1.7 px in
Full HD, 4.5 mm on a floor 3 m away."""
_OUTLIER_RAD = 0.0009
_LEAST_SHARE = 0.1
"""A tag must be seen in this share of the frames."""


@dataclass(frozen=True, slots=True, eq=False)
class FloorLook:
    """`sighting` is None when no floor tag was seen; `moved_ns` is the capture time of the first frame looked at in which the
    camera hung elsewhere than at the beginning, None when it stayed."""

    camera: str
    sighting: FloorSighting | None
    moved_ns: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """The floor tags in one frame: id -> corners (4, 2), pixels; a tag seen twice is left out."""

    stamp_ns: int
    corners: dict[int, Array]


def look_at_floor(camera: RecordedCamera, known: KnownTags, frames: int = FRAMES) -> FloorLook:
    """Searches `frames` frames, evenly spread over the recording."""
    samples = sampled(camera, known, frames)
    focal_px = camera.spec.model().fx
    return averaged_look(camera.spec.id, samples, focal_px)


def look_at_floors(cameras: Sequence[RecordedCamera], known: KnownTags, executor: Executor) -> list[FloorLook]:
    """All cameras, in their order, as many at once as the executor has workers."""
    return list(executor.map(look_at_floor, cameras, [known] * len(cameras)))


def sampled(camera: RecordedCamera, known: KnownTags, frames: int) -> list[Sample]:
    """The floor tags in frames spread evenly over the recording, in the order of time; broken frames give none."""
    detector = TagDetector(known.families(), frozenset(known.floor))
    finest, search = FullSearch(detector, side_px=1.0), FullSearch(detector, side_px=1.0)
    total = len(camera.stamps_ns)
    chosen = set(np.linspace(0, total - 1, min(frames, total)).round().astype(int).tolist())
    samples: list[Sample] = []
    reader = camera.open()
    try:
        for index in range(total):
            stamp_ns = reader.next_ns
            if stamp_ns is None:
                break
            if index not in chosen:
                reader.skip()
                continue
            try:
                image = reader.read()
            except BrokenFrameError:
                continue
            if image is None:
                break
            first = len(samples) < 2  # later frames are searched only as finely as the tags seen in these ask for
            found = _floor_tags(finest if first else search, image, frozenset(known.floor))
            if first and found:
                search.side_px = min(tag.side_px for tag in found)
            samples.append(Sample(stamp_ns, {tag.tag_id: tag.corners for tag in found}))
    finally:
        reader.close()
    return samples


def averaged_look(camera: str, samples: Sequence[Sample], focal_px: float) -> FloorLook:
    """The mean corners of samples in the order of time."""
    count, moved_ns = _before_a_move(samples, _MOVED_RAD * focal_px)
    steady = samples[:count]
    by_tag: dict[int, list[Array]] = {}
    for sample in steady:
        for tag, corners in sample.corners.items():
            by_tag.setdefault(tag, []).append(corners)
    means: dict[int, Array] = {}
    spreads: list[float] = []
    for tag, seen in sorted(by_tag.items()):
        if len(seen) < max(1.0, _LEAST_SHARE * len(steady)):
            continue
        kept = _without_outliers(np.array(seen), _OUTLIER_RAD * focal_px)
        means[tag] = kept.mean(axis=0)
        if len(kept) > 1:
            spreads.append(float(np.sqrt(kept.var(axis=0, ddof=1).mean())))
    if not means:
        return FloorLook(camera, None)
    noise_px = float(np.median(spreads)) if spreads else 0.0
    return FloorLook(camera, FloorSighting(camera, steady[-1].stamp_ns, len(steady), means, noise_px), moved_ns)


def _floor_tags(search: FullSearch, image: Grey, floor: Collection[TagKey]) -> list[TagObservation]:
    found = [tag for tag in search.find(image) if tag.key in floor]
    ids = [tag.tag_id for tag in found]
    return [tag for tag in found if ids.count(tag.tag_id) == 1]


def _before_a_move(samples: Sequence[Sample], far_px: float) -> tuple[int, int | None]:
    """How many samples come before the camera moved for good, and the stamp of the first one after; all and None when it
    stayed. A single odd frame at the end is no move."""
    start = _median_corners(samples[:_FIRST_FRAMES])
    near = [_distance_px(sample.corners, start) <= far_px for sample in samples]
    last = max((index for index, is_near in enumerate(near) if is_near), default=len(samples) - 1)
    if last >= len(samples) - 2:
        return len(samples), None
    return last + 1, samples[last + 1].stamp_ns


def _median_corners(samples: Sequence[Sample]) -> dict[int, Array]:
    tags = {tag for sample in samples for tag in sample.corners}
    return {
        tag: np.asarray(np.median([s.corners[tag] for s in samples if tag in s.corners], axis=0), dtype=np.float64)
        for tag in tags
    }


def _distance_px(corners: Mapping[int, Array], reference: Mapping[int, Array]) -> float:
    """Median over the common tags of how far they moved; 0 when there is none to tell."""
    moved = [float(np.linalg.norm(corners[tag] - reference[tag], axis=1).mean()) for tag in corners if tag in reference]
    return float(np.median(moved)) if moved else 0.0


def _without_outliers(seen: Array, far_px: float) -> Array:
    """Corners (N, 4, 2) whose every corner is near the median; the nearest one when none is."""
    off = np.linalg.norm(seen - np.median(seen, axis=0), axis=2).max(axis=1)
    kept = seen[off <= far_px]
    return kept if len(kept) else seen[[int(off.argmin())]]
