"""A camera finds its own place: extrinsics from the floor tags at the start, and a watch over them afterwards.

Corners are averaged over several frames, so a floor tag's own detection noise hardly counts. A stored or adopted result is
used at once and checked against what is seen; a camera that was moved says so, gives no poses, and calibrates itself again.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, CameraModel
from localization.calibration.drift import DriftWatch
from localization.calibration.extrinsics import MIN_TAGS, ExtrinsicsError
from localization.calibration.joint import calibrate, plane_heights_m
from localization.calibration.sighting import Corners, FloorSighting, averaged
from localization.calibration_jacobians import calibration_jacobians
from localization.detection import TagObservation
from localization.projection import CameraView, PointsAtInfinityError, extrinsics_pose, undistort
from localization.tag_pose import PoseNoise, extrinsics_covariance
from localization.tags import KnownTags, tag_corners
from protocol.lab import Accuracy
from protocol.messages import CameraExtrinsics

Array = NDArray[np.float64]

_HOLDS_M = 0.003
_HOLDS_SIGMAS = 3.0
"""A calibration in force that puts the floor tags this near to where the camera itself would is kept: one of several cameras
knows better."""
_SHAKE_PX = 1.0
_LEAST_FLICKER_PX = 0.01
"""Measured on sharp rendered tags (0.009 px); what the detector has wrong besides is nearly the same for a tag's four corners
and cancels in its pose."""
_LEAST_NOISE_PX = 0.03
"""The detector's own limit on sharp tags; nothing is surer than that."""
_PATIENCE = 5
"""Full searches in a row without floor tags after which there is no hurry to calibrate."""


class SelfCalibration:
    """Watches one camera's floor tags and keeps its extrinsics. `stored` is a calibration to begin with; `accuracy` says how
    well the lab was measured."""

    def __init__(
        self,
        camera_id: str,
        model: CameraModel,
        known: KnownTags,
        *,
        frames: int = 10,
        stored: CameraExtrinsics | None = None,
        accuracy: Accuracy | None = None,
    ) -> None:
        self._camera_id, self._model, self._frames = camera_id, model, frames
        self._size_m, self._heights_m = known.floor_size_m, plane_heights_m(known)
        self._accuracy = accuracy or Accuracy()
        self._family = next((family for family, _ in known.floor), "")
        self._places: dict[int, SE2] = {tag: pose for (_, tag), pose in known.floor.items()}
        self._extrinsics: CameraExtrinsics | None = None
        self._view: CameraView | None = None
        self._samples: list[Corners] | None = []
        self._empty_searches = 0
        self._sighting: FloorSighting | None = None
        self._watch: DriftWatch | None = None
        self._calibration_px: float | None = None
        self.floor_tags_seen: tuple[int, ...] = ()
        self.problem: str | None = None
        if stored is not None:
            self._use(stored)

    @property
    def extrinsics(self) -> CameraExtrinsics | None:
        """What poses may be computed with; None before the first calibration and after the camera was moved."""
        return self._extrinsics

    @property
    def view(self) -> CameraView | None:
        """The camera with these extrinsics."""
        return self._view

    @property
    def sighting(self) -> FloorSighting | None:
        """The averaged sighting of the floor tags in the newest calibration or check of one."""
        return self._sighting

    @property
    def displaced_m(self) -> dict[int, float]:
        """Floor tags that no longer lie where they did, though the camera stands still: by how much (m)."""
        return self._watch.displaced_m if self._watch is not None else {}

    @property
    def notice(self) -> str | None:
        """What a person should see to, though poses are right: displaced floor tags, in a sentence."""
        off = [f"floor tag {tag} is {off_m * 1e3:.0f} mm off where it was" for tag, off_m in self.displaced_m.items()]
        return ", ".join(off) or None

    @property
    def noise(self) -> PoseNoise:
        """What limits poses from this camera: how much its floor tags' corners flicker from frame to frame, and how far off (px)
        the calibration puts a point of the floor by its own covariance."""
        default = PoseNoise()
        flicker_px = default.corner_px if self._sighting is None else self._sighting.corner_noise_px
        off_px = default.calibration_px if self._calibration_px is None else self._calibration_px
        return replace(
            default, corner_px=max(_LEAST_FLICKER_PX, flicker_px), calibration_px=max(_LEAST_NOISE_PX, off_px)
        )

    @property
    def eager(self) -> bool:
        """Whether the next frame should be searched for floor tags, without waiting for the next regular full search."""
        collecting = self._samples is not None and self._empty_searches < _PATIENCE
        return collecting or (self._watch is not None and self._watch.suspicious)

    def adopt(self, extrinsics: CameraExtrinsics, floor_tags: Mapping[int, SE2] | None = None) -> None:
        """Uses extrinsics from outside at once; `floor_tags` (T_map_tag) replace the places where floor tags are expected. What
        the newest sighting contradicts is checked again from fresh frames."""
        if floor_tags is not None:
            self._places.update(floor_tags)
        self.problem = None
        self._use(extrinsics)
        if self._sighting is None or not self._explains(self._sighting):
            self.look_again()
        else:
            self._watch = self._watching(self._sighting)

    def look_again(self) -> None:
        """Averages the floor tags over fresh frames. Poses go on with the calibration in force; it is replaced only when it does
        not hold."""
        self._samples, self._watch, self._empty_searches = [], None, 0

    def restart(self) -> None:
        """Forgets the calibration and makes a new one from fresh frames."""
        self._forget()

    def observe(self, tags: Iterable[TagObservation], stamp_ns: int) -> CameraExtrinsics | None:
        """Takes the tags of one complete look at the floor tags; returns extrinsics when there are new ones."""
        seen = self._floor_tags(tags)
        self.floor_tags_seen = tuple(sorted(seen))
        if self._samples is None:
            self._check(seen)
            return None
        self._empty_searches = 0 if len(seen) >= MIN_TAGS else self._empty_searches + 1
        if len(seen) < MIN_TAGS:
            if self._extrinsics is None:
                self.problem = f"not calibrated: sees {len(seen)} floor tags, needs {MIN_TAGS}"
            return None
        self._samples.append(seen)
        if len(self._samples) < self._frames:
            return None
        samples, self._samples = self._samples, []
        return self._calibrate(averaged(self._camera_id, stamp_ns, samples))

    def _floor_tags(self, tags: Iterable[TagObservation]) -> Corners:
        """Corners of the floor tags; a floor tag seen twice is believed in neither place."""
        seen: Corners = {}
        twice: set[int] = set()
        for tag in tags:
            if tag.family == self._family and tag.tag_id in self._places:
                if tag.tag_id in seen:
                    twice.add(tag.tag_id)
                seen[tag.tag_id] = tag.corners
        return {tag_id: corners for tag_id, corners in seen.items() if tag_id not in twice}

    def _calibrate(self, sighting: FloorSighting) -> CameraExtrinsics | None:
        if sighting.corner_noise_px > _SHAKE_PX:
            self.problem = f"not calibrated: the picture shakes, floor tags move by {sighting.corner_noise_px:.1f} px"
            return None
        name = self._camera_id
        try:
            found = calibrate(
                {name: self._model}, [sighting], self._places, self._size_m, self._accuracy, self._heights_m
            )
        except ExtrinsicsError as error:
            self.problem = f"not calibrated: {str(error).removeprefix(f'camera {name}: ')}"
            return None
        self._samples = None
        self.problem = None
        self._sighting = sighting
        extrinsics = found.extrinsics[name]
        old = self._extrinsics
        keep = old is not None and bool(old.covariance) and self._agrees(extrinsics, sighting)
        if not keep:
            self._use(extrinsics)
        self._watch = self._watching(sighting)
        return None if keep else extrinsics

    def _check(self, seen: Corners) -> None:
        if self._watch is None:
            return
        moved_m = self._watch.moved_m(seen)
        if moved_m is not None:
            self.problem = f"the camera moved: floor tags are {moved_m * 1e3:.0f} mm off; calibrating again"
            self._forget()

    def _forget(self) -> None:
        self._extrinsics, self._view, self._calibration_px = None, None, None
        self.look_again()

    def _use(self, extrinsics: CameraExtrinsics) -> None:
        self._extrinsics = extrinsics
        self._view = CameraView(self._model, extrinsics_pose(extrinsics))
        self._calibration_px = _calibration_px(self._view, extrinsics)

    def _watching(self, sighting: FloorSighting) -> DriftWatch:
        assert self._view is not None
        square, described = tag_corners(self._size_m), Corners()
        for tag, place in self._places.items():
            pixels, meant = self._view.project(np.column_stack([place.apply(square), np.zeros(4)]))
            if meant.all():
                described[tag] = pixels
        return DriftWatch(sighting, described, self._size_m)

    def _limit_m(self) -> float:
        return max(_HOLDS_M, _HOLDS_SIGMAS * self._accuracy.floor_tag_m)

    def _explains(self, sighting: FloorSighting) -> bool:
        """Whether most floor tags of the sighting lie where this calibration has them."""
        assert self._view is not None
        square = tag_corners(self._size_m)
        off: list[float] = []
        for tag in sorted(set(sighting.corners) & set(self._places)):
            floor = self._on_floor(self._view, sighting.corners[tag])
            off.append(math.inf if floor is None else _rms(floor - self._places[tag].apply(square)))
        return len(off) >= MIN_TAGS and float(np.median(off)) < self._limit_m()

    def _agrees(self, extrinsics: CameraExtrinsics, sighting: FloorSighting) -> bool:
        """Whether the calibration in use and another put the sighting's corners in the same places."""
        assert self._view is not None
        other = CameraView(self._model, extrinsics_pose(extrinsics))
        corners = np.concatenate([sighting.corners[tag] for tag in extrinsics.floor_tags])
        here, there = self._on_floor(self._view, corners), self._on_floor(other, corners)
        return here is not None and there is not None and _rms(here - there) < self._limit_m()

    def _on_floor(self, view: CameraView, pixels: Array) -> Array | None:
        try:
            return view.hits(undistort(self._model, pixels), 0.0).points
        except PointsAtInfinityError:
            return None


def _calibration_px(view: CameraView, extrinsics: CameraExtrinsics) -> float | None:
    """How far off (px, per axis) the calibration puts a point of the floor, over the image; None when it does not say."""
    covariance = extrinsics_covariance(extrinsics)
    if covariance is None:
        return None
    model = view.model
    grid = np.array([[u * model.width, v * model.height] for u in (0.1, 0.5, 0.9) for v in (0.1, 0.5, 0.9)])
    try:
        slopes = calibration_jacobians(view, grid, 0.0)
        per_pixel = view.hits(undistort(model, grid), 0.0).jacobians / np.array([model.fx, model.fy])
    except PointsAtInfinityError:
        return None
    spread_m2 = float(np.trace(np.einsum("aij,jk,alk->il", slopes, covariance, slopes))) / (2 * len(grid))
    m_per_px = math.sqrt(float(np.abs(np.linalg.det(per_pixel)).mean()))
    return math.sqrt(spread_m2) / m_per_px


def _rms(offsets: Array) -> float:
    return float(np.sqrt(np.square(offsets).sum(axis=1).mean()))
