"""One camera's way from a frame to tag poses, without any I/O (spec localization, "The pipeline of 2025", design, "The way of
a pose").

Windows around the predicted tags first; every K-th frame a full search for newcomers and for the floor tags, which keep
the camera calibrated. Only corners are undistorted. The caller gives frames and tracks and takes detections:

    pipeline = CameraPipeline(lab, "cam0")
    tracker = Tracker(lab)
    poses: dict[str, TrackedPose] = {}
    for frame in frames:
        detections = pipeline.process(frame, poses)
        poses.update({pose.vehicle: pose for pose in tracker.update(detections)})
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from localization.calibration import FloorSighting, SelfCalibration
from localization.detection import (
    FullSearch,
    TagDetector,
    TagGuess,
    TagObservation,
    TagSearch,
    WindowedSearch,
    is_whole,
    without_duplicates,
)
from localization.prediction import is_fresh
from localization.projection import CameraView, PointsAtInfinityError, undistort
from localization.tag_pose import PoseNoise, TagPose, extrinsics_covariance, tag_poses, upper
from localization.tags import KnownTags
from localization.windows import LastSeen, guesses_from_tracks
from protocol.clock import Clock, SystemClock
from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import CameraExtrinsics, Detection, FrameDetections, TrackedPose

_UNCALIBRATED_SIDE_PX = 27.0
"""Tags from this side length on are found before the camera knows its height (decimation 1.5)."""
_HASTE_S = 2.0
_HASTY_SHARE = 4
"""While nothing is tracked at all, every frame is searched for two seconds, then this many times as often as K says."""


@dataclass(frozen=True, slots=True)
class PipelineOptions:
    """`full_search_every`: K, a full search at least every K-th frame (None: about once a second).
    `calibration_frames`: how many frames the floor tags' corners are averaged over. `noise`: what limits poses (None:
    as measured on the floor tags)."""

    full_search_every: int | None = None
    calibration_frames: int = 10
    noise: PoseNoise | None = None


class CameraPipeline:
    """Finds the vehicles in one camera's frames. Belongs to one thread. KeyError for a camera that the lab does not have.

    `extrinsics` are a stored calibration to begin with; without them the floor tags give one within the first frames.
    """

    def __init__(
        self,
        lab: Lab,
        camera_id: str,
        *,
        clock: Clock | None = None,
        options: PipelineOptions | None = None,
        extrinsics: CameraExtrinsics | None = None,
    ) -> None:
        self.spec = lab.camera(camera_id)
        self.options = options or PipelineOptions()
        self._clock = clock or SystemClock()
        self._known = KnownTags.of(lab)
        self._model = self.spec.model()
        self._calibration = SelfCalibration(
            camera_id,
            self._model,
            self._known,
            frames=self.options.calibration_frames,
            stored=extrinsics,
            accuracy=lab.accuracy,
        )
        detector = TagDetector(self._known.families(), self._known.keys())
        self._full = FullSearch(detector, _UNCALIBRATED_SIDE_PX)
        self._windowed = WindowedSearch(detector)
        self._last_seen = LastSeen(self._known)
        self._sized_for: CameraView | None = None
        self._every = max(1, self.options.full_search_every or round(self.spec.rate_hz))
        # Cameras take turns, so that their full searches do not fall into the same instant.
        index = [camera.id for camera in lab.cameras].index(camera_id)
        self._turn = self._every * index // len(lab.cameras)
        self._tag_height_accuracy_m = lab.accuracy.tag_height_m
        self._noise_for: CameraExtrinsics | None = None
        self._calibration_covariance: NDArray[np.float64] | None = None
        self._last_tracked_ns: int | None = None
        self._tags: tuple[TagObservation, ...] = ()
        self._floor_tags: tuple[TagObservation, ...] = ()

    @property
    def extrinsics(self) -> CameraExtrinsics | None:
        """The calibration in use; None until there is one, and while a moved camera finds its place again."""
        return self._calibration.extrinsics

    @property
    def sighting(self) -> FloorSighting | None:
        """What the floor tags looked like when they were last averaged over frames."""
        return self._calibration.sighting

    def adopt(self, extrinsics: CameraExtrinsics, floor_tags: Mapping[int, SE2] | None = None) -> None:
        """Uses a calibration from outside at once; `floor_tags` (T_map_tag) replace the places where they are expected."""
        self._calibration.adopt(extrinsics, floor_tags)

    def recalibrate(self) -> None:
        """Calibrates again from the next frames; poses go on with what is in force meanwhile."""
        self._calibration.restart()

    @property
    def problem(self) -> str | None:
        """What is wrong with the calibration, in a sentence."""
        return self._calibration.problem

    @property
    def floor_tags_seen(self) -> tuple[int, ...]:
        """Ids of the floor tags in the newest full search."""
        return self._calibration.floor_tags_seen

    @property
    def tags(self) -> tuple[TagObservation, ...]:
        """What the newest frame showed: its vehicle tags, and the floor tags of the newest full search."""
        return self._tags + self._floor_tags

    def process(self, frame: Frame, predicted: Mapping[str, TrackedPose] | None = None) -> FrameDetections:
        """The vehicle tags in the frame. `predicted` are the newest tracks by vehicle id, of any time; they are extrapolated
        to the frame's capture time, and stale ones ignored. ValueError for a frame of another size than the lab file's."""
        self._check(frame)
        start_s = self._clock.monotonic_s()
        wait_ms = max(0.0, (self._clock.now_ns() - frame.stamp_ns) * 1e-6)
        predicted = predicted or {}
        full = self._full_search_due(frame, predicted)
        tags = self._find(frame, predicted, full=full)
        detected_s = self._clock.monotonic_s()
        vehicles = [tag for tag in tags if tag.key in self._known.vehicles]
        corners = [undistort(self._model, tag.corners) for tag in vehicles]
        undistorted_s = self._clock.monotonic_s()
        detections = self._poses(vehicles, corners)
        posed_s = self._clock.monotonic_s()
        self._last_seen.remember(vehicles, frame.stamp_ns)
        self._tags = tuple(vehicles)
        return FrameDetections(
            camera=self.spec.id,
            stamp_ns=frame.stamp_ns,
            sent_ns=self._clock.now_ns(),
            frame=frame.number,
            full_search=full,
            detections=tuple(detections),
            timings_ms={
                "wait": wait_ms,
                "detect": (detected_s - start_s) * 1e3,
                "undistort": (undistorted_s - detected_s) * 1e3,
                "pose": (posed_s - undistorted_s) * 1e3,
            },
        )

    def _check(self, frame: Frame) -> None:
        height, width = frame.pixels.shape[:2]
        if (width, height) != (self.spec.width, self.spec.height):
            raise ValueError(
                f"camera {self.spec.id}: a frame is {width} x {height}, the lab description says"
                f" {self.spec.width} x {self.spec.height}"
            )

    def _full_search_due(self, frame: Frame, predicted: Mapping[str, TrackedPose]) -> bool:
        self._turn += 1
        every = self._every
        tracked = bool(self._tags) or any(is_fresh(pose, frame.stamp_ns) for pose in predicted.values())
        if tracked or self._last_tracked_ns is None:
            self._last_tracked_ns = frame.stamp_ns
        if not tracked:
            hasty = frame.stamp_ns - self._last_tracked_ns < _HASTE_S * 1e9
            every = 1 if hasty else max(1, self._every // _HASTY_SHARE)
        return self._turn % every == 0 or self._calibration.eager

    def _find(self, frame: Frame, predicted: Mapping[str, TrackedPose], *, full: bool) -> list[TagObservation]:
        guesses: list[TagGuess] = []
        view = self._calibration.view
        if view is not None:
            guesses = guesses_from_tracks(view, self._known, predicted, frame.stamp_ns)
        tags = self._search(self._windowed, frame, guesses)
        found = {tag.key for tag in tags}
        if full:
            everywhere = self._search(self._full, frame)
            self._floor_tags = tuple(tag for tag in everywhere if tag.key in self._known.floor)
            tags = without_duplicates([*tags, *everywhere])
            self._calibration.observe(everywhere, frame.stamp_ns)
            self._size_full_search()
        else:
            tracked = {
                key
                for key, vehicle in self._known.vehicles.items()
                if vehicle.id in predicted and is_fresh(predicted[vehicle.id], frame.stamp_ns)
            }
            memory = self._last_seen.guesses(frame.stamp_ns, found, tracked)
            tags = without_duplicates([*tags, *self._search(self._windowed, frame, memory)])
        return tags

    def _search(self, search: TagSearch, frame: Frame, guesses: Sequence[TagGuess] = ()) -> list[TagObservation]:
        return [tag for tag in search.find(frame.pixels, guesses) if is_whole(tag, frame.pixels)]

    def _size_full_search(self) -> None:
        """Once the camera knows its height, the full search is as coarse as the smallest tag in its view allows."""
        view = self._calibration.view
        if view is None or view is self._sized_for:
            return
        self._sized_for = view
        farthest_m = _farthest_floor_m(view)
        focal_px = min(self._model.fx, self._model.fy)
        sizes = [self._known.floor_size_m, *(vehicle.tag.size_m for vehicle in self._known.vehicles.values())]
        self._full.side_px = focal_px * min(sizes) / farthest_m

    def _poses(self, tags: list[TagObservation], corners: list[NDArray[np.float64]]) -> list[Detection]:
        view = self._calibration.view
        if view is None:
            return []
        worn = [self._known.vehicles[tag.key].tag for tag in tags]
        found = tag_poses(
            view,
            np.array(corners).reshape(-1, 4, 2),
            [each.size_m for each in worn],
            [each.height_m for each in worn],
            self._pose_noise(),
        )
        return [
            Detection(
                family=tag.family,
                tag_id=tag.tag_id,
                corners_px=_corner_tuples(tag),
                decision_margin=tag.decision_margin,
                x=placed.pose.x,
                y=placed.pose.y,
                yaw=placed.pose.yaw,
                covariance=upper(placed.covariance),
                systematic=upper(placed.systematic),
            )
            for tag, placed in zip(tags, found, strict=True)
            if isinstance(placed, TagPose)  # else a wrong reading: not the square that this vehicle wears
        ]

    def _pose_noise(self) -> PoseNoise:
        """What limits poses now: the corners' flicker, what the calibration leaves open, and how well heights were measured."""
        if self.options.noise is not None:
            return self.options.noise
        extrinsics = self._calibration.extrinsics
        if extrinsics is not self._noise_for:
            self._noise_for = extrinsics
            self._calibration_covariance = None if extrinsics is None else extrinsics_covariance(extrinsics)
        return replace(
            self._calibration.noise,
            height_m=self._tag_height_accuracy_m,
            calibration=self._calibration_covariance,
        )


def _corner_tuples(
    tag: TagObservation,
) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float], tuple[float, float]]:
    a, b, c, d = ((float(x), float(y)) for x, y in tag.corners)
    return a, b, c, d


def _farthest_floor_m(view: CameraView) -> float:
    """Distance along the optical axis of the farthest floor point that the image shows; for a camera that sees the horizon
    three times its height."""
    width, height = view.model.width - 1.0, view.model.height - 1.0
    border = undistort(view.model, np.array([[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]]))
    mount_height = float(view.T_map_camera.translation[2])
    try:
        hits = view.hits(border, 0.0)
    except PointsAtInfinityError:
        return 3.0 * mount_height
    floor = np.column_stack([hits.points, np.zeros(4)])
    depths = view.T_map_camera.inverse().apply(floor)[:, 2]
    return min(3.0 * mount_height, float(cast("float", depths.max())))
