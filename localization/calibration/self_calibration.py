"""A camera finds its own place: extrinsics from the floor tags at the start, and a watch over them afterwards.

Corners are averaged over several frames, so a floor tag's own detection noise hardly counts. A stored result is used at
once and checked against what is seen; a camera that was moved says so, gives no poses, and calibrates itself again.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, CameraModel
from localization.calibration.extrinsics import MIN_TAGS, ExtrinsicsError, estimate_extrinsics, reprojection_px
from localization.calibration.sighting import Corners, FloorSighting, averaged
from localization.detection import TagObservation
from localization.projection import CameraView, extrinsics_pose
from localization.tag_pose import PoseNoise
from localization.tags import KnownTags, tag_corners
from protocol.messages import CameraExtrinsics

Array = NDArray[np.float64]

_MOST_MISFIT_M = 0.015
"""An estimate that leaves the floor tags' corners further off than this is refused: an id, a yaw or a size is wrong."""
_MOVED_M = 0.006
"""Floor tags this far from where they should be mean that the camera moved; hand-measured tags are off by less."""
_MOVED_IN_A_ROW = 3
_SHAKE_PX = 1.0
_LEAST_NOISE_PX = 0.03
"""The detector's own limit on sharp tags; nothing is surer than that."""
_PATIENCE = 5
"""Full searches in a row without floor tags after which there is no hurry to calibrate."""


class SelfCalibration:
    """Watches one camera's floor tags and keeps its extrinsics."""

    def __init__(
        self,
        camera_id: str,
        model: CameraModel,
        known: KnownTags,
        *,
        frames: int = 10,
        stored: CameraExtrinsics | None = None,
    ) -> None:
        self._camera_id, self._model, self._frames = camera_id, model, frames
        self._size_m = known.floor_size_m
        self._family = next((family for family, _ in known.floor), "")
        self._expected: Corners = {key[1]: known.floor_corners(key) for key in known.floor}
        self._extrinsics: CameraExtrinsics | None = None
        self._view: CameraView | None = None
        self._samples: list[Corners] | None = []
        self._suspicions = 0
        self._empty_searches = 0
        self._corner_noise_px: float | None = None
        self._sighting: FloorSighting | None = None
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
        """The averaged sighting behind the newest calibration."""
        return self._sighting

    def adopt(self, extrinsics: CameraExtrinsics, floor_tags: Mapping[int, SE2] | None = None) -> None:
        """Uses extrinsics from outside at once; `floor_tags` (T_map_tag) replace the places where floor tags are expected."""
        if floor_tags is not None:
            square = tag_corners(self._size_m)
            self._expected = {tag: pose.apply(square) for tag, pose in floor_tags.items()}
        self.problem = None
        self._use(extrinsics)

    def restart(self) -> None:
        """Calibrates again from fresh frames."""
        self._samples, self._suspicions, self._empty_searches = [], 0, 0
        self._extrinsics, self._view = None, None

    def look_again(self) -> None:
        """Takes a new sighting of the floor tags from the next frames, while what is in use stays in use; it is replaced only
        when it does not hold any longer."""
        self._samples, self._suspicions, self._empty_searches = [], 0, 0

    @property
    def noise(self) -> PoseNoise:
        """What limits poses from this camera, measured on its own floor tags: how much their corners flicker from frame to
        frame, and how far off the extrinsics put them.

        n misplaced tags give 2n numbers, of which the pose takes 6 up: what is left of their error is (2n - 6) / 2n of its
        square, so the RMS distance r stands for r sqrt(n / (2n - 6)) per axis."""
        default = PoseNoise()
        flicker_px = default.corner_px if self._corner_noise_px is None else self._corner_noise_px
        off_px = default.calibration_px
        if self._extrinsics is not None:
            tags = len(self._extrinsics.floor_tags)
            off_px = self._extrinsics.reprojection_px * math.sqrt(tags / max(1, 2 * tags - 6))
        return replace(default, corner_px=max(_LEAST_NOISE_PX, flicker_px), calibration_px=max(_LEAST_NOISE_PX, off_px))

    @property
    def eager(self) -> bool:
        """Whether the next frame should be searched for floor tags, without waiting for the next regular full search."""
        collecting = self._samples is not None and self._empty_searches < _PATIENCE
        return collecting or self._suspicions > 0

    def observe(self, tags: Iterable[TagObservation], stamp_ns: int) -> CameraExtrinsics | None:
        """Takes the tags of a full search; returns extrinsics when there are new ones."""
        seen = self._floor_tags(tags)
        self.floor_tags_seen = tuple(sorted(seen))
        self._empty_searches = 0 if len(seen) >= MIN_TAGS else self._empty_searches + 1
        if self._samples is None:
            self._watch(seen)
            return None
        if len(seen) < MIN_TAGS:
            if self._extrinsics is None:
                self.problem = f"not calibrated: sees {len(seen)} floor tags, needs {MIN_TAGS}"
            return None
        self._samples.append(seen)
        if len(self._samples) < self._frames:
            return None
        samples, self._samples = self._samples, []
        return self._calibrate(samples, stamp_ns)

    def _floor_tags(self, tags: Iterable[TagObservation]) -> Corners:
        """Corners of the floor tags; a floor tag seen twice is believed in neither place."""
        seen: Corners = {}
        twice: set[int] = set()
        for tag in tags:
            if tag.family == self._family and tag.tag_id in self._expected:
                if tag.tag_id in seen:
                    twice.add(tag.tag_id)
                seen[tag.tag_id] = tag.corners
        return {tag_id: corners for tag_id, corners in seen.items() if tag_id not in twice}

    def _calibrate(self, samples: list[Corners], stamp_ns: int) -> CameraExtrinsics | None:
        sighting = averaged(self._camera_id, stamp_ns, samples)
        mean, shake_px = sighting.corners, sighting.corner_noise_px
        if shake_px > _SHAKE_PX:
            self.problem = f"not calibrated: the picture shakes, floor tags move by {shake_px:.1f} px"
            return None
        self._corner_noise_px = shake_px
        try:
            estimate = estimate_extrinsics(self._model, mean, self._expected, self._size_m)
        except ExtrinsicsError as error:
            self.problem = f"not calibrated: {error}"
            return None
        misfit_m = estimate.reprojection_px / self._px_per_m(mean)
        if misfit_m > _MOST_MISFIT_M:
            self.problem = (
                f"not calibrated: floor tags {', '.join(str(tag) for tag in estimate.used)} are {misfit_m * 1e3:.0f} mm off"
                " where the lab description has them; check their ids, poses and size and the camera's intrinsics"
            )
            return None
        self._samples = None
        self.problem = None
        self._sighting = sighting
        if self._view is not None:
            stored_px = _median(reprojection_px(self._model, self._view.T_map_camera, mean, self._expected))
            if stored_px <= max(2.0 * estimate.reprojection_px, estimate.reprojection_px + 0.5):
                return None  # what was stored still holds
        rx, ry, rz = (float(v) for v in estimate.T_map_camera.rotvec())
        x, y, z = (float(v) for v in estimate.T_map_camera.translation)
        self._use(
            CameraExtrinsics(
                self._camera_id, stamp_ns, (rx, ry, rz), (x, y, z), estimate.reprojection_px, estimate.used
            )
        )
        return self._extrinsics

    def _watch(self, seen: Corners) -> None:
        if self._view is None or len(seen) < MIN_TAGS:
            self._suspicions = 0
            return
        off_px = _median(reprojection_px(self._model, self._view.T_map_camera, seen, self._expected))
        assert self._extrinsics is not None
        off_m = (off_px - self._extrinsics.reprojection_px) / self._px_per_m(seen)
        self._suspicions = self._suspicions + 1 if off_m > _MOVED_M else 0
        if self._suspicions >= _MOVED_IN_A_ROW:
            self.problem = f"the camera moved: floor tags are {off_m * 1e3:.0f} mm off; calibrating again"
            self._extrinsics, self._view = None, None
            self._samples, self._suspicions = [], 0

    def _use(self, extrinsics: CameraExtrinsics) -> None:
        self._extrinsics = extrinsics
        self._view = CameraView(self._model, extrinsics_pose(extrinsics))

    def _px_per_m(self, seen: Mapping[int, Array]) -> float:
        sides = [np.linalg.norm(c - np.roll(c, 1, axis=0), axis=1).mean() for c in seen.values()]
        return float(np.mean(sides)) / self._size_m


def _median(values: Mapping[int, float]) -> float:
    return float(np.median(list(values.values()))) if values else 0.0
