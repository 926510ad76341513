"""Which floor tags to believe: a tag that was entered wrongly, or kicked, must not bend the cameras.

What is grossly wrong (ids swapped, numbers of another room) is found first: each pair of a camera's tags gives a pose, and the
pair counts that most of the camera's tags agree with (RANSAC, Fischler and Bolles 1981, with every sample there is). A tag that
is wrong by less is found by trying: the adjustment is repeated with one suspect's measured place given up (its corners go on
tying cameras together), or with one camera's sight of a tag taken out. What makes the rest agree far better, and lies where no
hand-measuring error reaches, is left out.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, SE3, angle_difference
from localization.calibration.adjustment import Adjusted, Adjustment, SeenTags
from localization.calibration.extrinsics import MIN_TAGS, ExtrinsicsError, initial_pose, reprojection_px, rms_px
from localization.tags import tag_corners
from protocol.lab import Accuracy

Array = NDArray[np.float64]

_OUTLIER_M = 0.010
"""A floor tag further than this from where the others want it is wrong, not just measured by hand."""
_GROSS_M = 0.040
"""And this far off it is wrong even when others are wrong as well and the rest does not agree yet."""
_SIGMAS = 5.0
_GAIN = 0.25
"""Leaving an outlier out must at least halve the (root mean square) error of the rest."""
_SUSPECT = 0.5
"""Tags are tried from this share of the limits on: the estimate before trying is only linear."""
_MISREAD_PX = 1.0
"""Cameras that see one tag further than this apart do not see the same tag."""
_MOST_CANDIDATES = 12
_LEVER_M_PER_RAD = 0.1
"""A tag's heading error counts by what it does to its corners."""


@dataclass(frozen=True, slots=True, eq=False)
class Consensus:
    """The adjustment that the floor tags agree on. `free` are tags whose measured places were given up; `dropped` are
    (camera, tag) sights that were taken out."""

    adjusted: Adjusted
    cameras: tuple[SeenTags, ...]
    free: frozenset[int]
    dropped: frozenset[tuple[str, int]]


def agree(cameras: Sequence[SeenTags], measured: Mapping[int, SE2], size_m: float, accuracy: Accuracy) -> Consensus:
    """Adjusts one connected group of cameras with as many of its floor tags as agree. ExtrinsicsError when there is no pose."""
    hypothesis = _Hypothesis(tuple(cameras), measured, size_m, accuracy)
    best = hypothesis.solved(*hypothesis.gross())
    best = hypothesis.without_false_suspicions(best)
    while True:
        better = hypothesis.better_than(best)
        if better is None:
            return best
        best = better


@dataclass(frozen=True, slots=True, eq=False)
class _Hypothesis:
    cameras: tuple[SeenTags, ...]
    measured: Mapping[int, SE2]
    size_m: float
    accuracy: Accuracy

    def solved(self, free: frozenset[int], dropped: frozenset[tuple[str, int]]) -> Consensus:
        cameras = tuple(_without(camera, dropped) for camera in self.cameras)
        start = {camera.camera: self._start(camera, free) for camera in cameras}
        try:
            adjusted = Adjustment(cameras, self.measured, self.size_m, self.accuracy, free).solve(start)
        except np.linalg.LinAlgError:
            raise ExtrinsicsError("the floor tags seen leave the cameras' places open") from None
        for camera, pose in adjusted.room.poses.items():
            if pose.translation[2] <= 0:
                raise ExtrinsicsError(
                    f"the floor tags put camera {camera} below the floor; are their ids and yaws right?"
                )
        return Consensus(adjusted, cameras, free, dropped)

    def gross(self) -> tuple[frozenset[int], frozenset[tuple[str, int]]]:
        """Tags that no camera finds anywhere near where they were measured, and sights of tags that other cameras find there."""
        agreeing = {camera.camera: self._agreeing(camera) for camera in self.cameras}
        confirmed = frozenset[int]().union(*agreeing.values())
        seen = {(camera.camera, tag) for camera in self.cameras for tag in camera.tags}
        free = frozenset(tag for _, tag in seen if tag not in confirmed)
        dropped = frozenset((name, tag) for name, tag in seen if tag in confirmed and tag not in agreeing[name])
        return (free, dropped) if self._enough(free, dropped) else (frozenset[int](), frozenset[tuple[str, int]]())

    def without_false_suspicions(self, best: Consensus) -> Consensus:
        """With the tags believed again that the adjustment puts where they were measured after all."""
        places = best.adjusted.room.tags
        off_m = {tag: _off_m(_difference(self.measured[tag], places[tag])) for tag in best.free}
        wrong = frozenset(tag for tag in best.free if off_m[tag] >= _OUTLIER_M)
        return best if wrong == best.free else self.solved(wrong, best.dropped)

    def _agreeing(self, camera: SeenTags) -> frozenset[int]:
        """The tags of the largest set that one pose explains, to within what is not grossly wrong."""
        square = tag_corners(self.size_m)
        expected = {tag: self.measured[tag].apply(square) for tag in camera.tags}
        corners, best = camera.corners, (frozenset[int](), np.inf)
        for tags in (camera.tags, *combinations(camera.tags, MIN_TAGS)):
            try:
                pose = initial_pose(camera.model, corners, expected, tags)
            except ExtrinsicsError:
                continue
            off_m = {
                tag: px * self.size_m / _side_px(corners[tag])
                for tag, px in reprojection_px(camera.model, pose, corners, expected).items()
            }
            near = frozenset(tag for tag in camera.tags if off_m[tag] < _GROSS_M)
            total = sum(off_m[tag] for tag in near)
            if (len(near), -total) > (len(best[0]), -best[1]):
                best = (near, total)
            if len(near) == len(camera.tags):
                break
        return best[0]

    def _start(self, camera: SeenTags, free: frozenset[int]) -> SE3:
        square = tag_corners(self.size_m)
        expected = {tag: self.measured[tag].apply(square) for tag in camera.tags}
        believed = [tag for tag in camera.tags if tag not in free]
        tags = believed if len(believed) >= MIN_TAGS else camera.tags
        try:
            return initial_pose(camera.model, camera.corners, expected, tags)
        except ExtrinsicsError as error:
            raise ExtrinsicsError(f"camera {camera.camera}: {error}") from None

    def better_than(self, best: Consensus) -> Consensus | None:
        """The best of the hypotheses that believe one thing less, if it is worth it."""
        candidates: list[tuple[Consensus, int]] = []
        for tag in self._suspects(best):
            free = best.free | {tag}
            if self._enough(free, best.dropped):
                self._try(candidates, free, best.dropped, tag)
        for camera, tag in self._misread(best):
            dropped = best.dropped | {(camera, tag)}
            if self._enough(best.free, dropped):
                self._try(candidates, best.free, dropped, tag)
        if not candidates:
            return None
        chosen, tag = min(candidates, key=lambda item: item[0].adjusted.cost)
        return chosen if self._worth(best, chosen, tag) else None

    def _try(
        self,
        candidates: list[tuple[Consensus, int]],
        free: frozenset[int],
        dropped: frozenset[tuple[str, int]],
        tag: int,
    ) -> None:
        try:
            candidates.append((self.solved(free, dropped), tag))
        except ExtrinsicsError:
            return  # what is left gives no pose

    def _suspects(self, best: Consensus) -> list[int]:
        """Believed tags that the others want far off, the most improbable first: leave-one-out, linearized (with the measure S
        taken out of the posterior P, the information P^-1 - S^-1 is left)."""
        information = np.linalg.inv(self._measured_covariance())
        odd: dict[int, float] = {}
        for tag, place in best.adjusted.room.tags.items():
            if tag in best.free:
                continue
            posterior = np.linalg.inv(best.adjusted.tag_covariances[tag])
            try:
                offset: Array = np.linalg.solve(
                    posterior - information, posterior @ _difference(self.measured[tag], place)
                ).astype(np.float64)
            except np.linalg.LinAlgError:
                continue  # nothing but its own measure says where this tag is
            cost = float(offset @ information @ offset)
            if _off_m(offset) > _SUSPECT * _OUTLIER_M and cost > (_SUSPECT * _SIGMAS) ** 2:
                odd[tag] = cost
        return sorted(odd, key=lambda tag: -odd[tag])[:_MOST_CANDIDATES]

    def _misread(self, best: Consensus) -> list[tuple[str, int]]:
        """Sights that the room does not explain, the worst first."""
        room, square = best.adjusted.room, tag_corners(self.size_m)
        off: dict[tuple[str, int], float] = {}
        for camera in best.cameras:
            pose, lens = room.poses[camera.camera], room.lenses[camera.camera]
            for tag, corners in camera.corners.items():
                place = {tag: room.tags[tag].apply(square)}
                off[camera.camera, tag] = rms_px(lens, pose, {tag: corners}, place, [tag])
        worst = sorted((sight for sight, px in off.items() if px > _MISREAD_PX), key=lambda sight: -off[sight])
        return worst[:_MOST_CANDIDATES]

    def _measured_covariance(self) -> Array:
        """Of x, y, yaw of a floor tag as measured, (3, 3)."""
        return np.diag([self.accuracy.floor_tag_m**2] * 2 + [self.accuracy.floor_tag_rad**2])

    def _enough(self, free: frozenset[int], dropped: frozenset[tuple[str, int]]) -> bool:
        """Whether every camera keeps enough tags that it believes or shares, and the group enough that it believes."""
        cameras = [_without(camera, dropped) for camera in self.cameras]
        seen = [tag for camera in cameras for tag in camera.tags]
        believed = set(seen) - free
        if len(believed) < MIN_TAGS or 2 * len(believed) < len(set(seen)):
            return False
        shared = {tag for tag in seen if seen.count(tag) > 1}
        return all(len([tag for tag in camera.tags if tag in believed | shared]) >= MIN_TAGS for camera in cameras)

    def _worth(self, best: Consensus, chosen: Consensus, tag: int) -> bool:
        cost, left = best.adjusted.cost, chosen.adjusted.cost
        if chosen.dropped != best.dropped:
            return left < _GAIN * cost
        offset = _difference(self.measured[tag], chosen.adjusted.room.tags[tag])
        off_m = _off_m(offset)
        spread = chosen.adjusted.tag_covariances[tag] + self._measured_covariance()
        sigmas = float(np.sqrt(offset @ np.linalg.solve(spread, offset)))
        if off_m < _OUTLIER_M or sigmas < _SIGMAS:
            return False
        return left < _GAIN * cost or (off_m > _GROSS_M and left < cost)


def _without(camera: SeenTags, dropped: frozenset[tuple[str, int]]) -> SeenTags:
    kept = tuple(tag for tag in camera.tags if (camera.camera, tag) not in dropped)
    if len(kept) == len(camera.tags):
        return camera
    image = np.concatenate([camera.corners[tag] for tag in kept]) if kept else np.empty((0, 2))
    return replace(camera, tags=kept, image=image)


def _side_px(corners: Array) -> float:
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).mean())


def _difference(measured: SE2, place: SE2) -> Array:
    """How far a tag lies from where it was measured: x, y (m), heading (rad)."""
    return np.array([place.x - measured.x, place.y - measured.y, angle_difference(place.yaw, measured.yaw)])


def _off_m(offset: Array) -> float:
    """The size of such a difference (m)."""
    return float(np.hypot(np.hypot(offset[0], offset[1]), offset[2] * _LEVER_M_PER_RAD))
