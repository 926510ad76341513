"""One camera's way from a frame to tag poses, without any I/O (spec localization, "The pipeline of 2025", design, "The way of
a pose").

Windows around the predicted tags first; newcomers are searched for in a part of each frame, and the floor tags, which keep
the camera calibrated, in turn. Only corners are undistorted. The caller gives frames and tracks and takes detections:

    pipeline = CameraPipeline(lab, "cam0")
    tracker = Tracker(lab)
    poses: dict[str, TrackedPose] = {}
    for frame in frames:
        detections = pipeline.process(frame, poses)
        poses.update({pose.vehicle: pose for pose in tracker.update(detections)})
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from localization.calibration import FloorSighting, SelfCalibration
from localization.camera_search import CameraSearch
from localization.detection import TagObservation
from localization.projection import undistort
from localization.tag_pose import PoseNoise, TagPose, extrinsics_covariance, tag_poses, upper
from localization.tags import KnownTags
from protocol.clock import Clock, SystemClock
from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import CameraExtrinsics, Detection, FrameDetections, TrackedPose


@dataclass(frozen=True, slots=True)
class PipelineOptions:
    """`full_search_every`: K, a search of a whole frame at least every K-th time, as the reports have it (None: spread over all
    frames, faster while something is missing). `search_budget_ms`: how much of a frame's time the spread search may take.
    `calibration_frames`: how many frames the floor tags' corners are averaged over. `noise`: what limits poses (None: as
    measured on the floor tags)."""

    full_search_every: int | None = None
    search_budget_ms: float = 3.0
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
        index = [camera.id for camera in lab.cameras].index(camera_id)
        self._search = CameraSearch(
            self._known,
            self._calibration,
            self._clock,
            width=self.spec.width,
            every=self.options.full_search_every,
            budget_ms=self.options.search_budget_ms,
            rate_hz=self.spec.rate_hz,
            turn=index / len(lab.cameras),
        )
        self._tag_height_accuracy_m = lab.accuracy.tag_height_m
        self._noise_for: CameraExtrinsics | None = None
        self._calibration_covariance: NDArray[np.float64] | None = None
        self._tags: tuple[TagObservation, ...] = ()

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

    def look_again(self) -> None:
        """Averages the floor tags anew over the next frames; poses go on with the present calibration meanwhile."""
        self._calibration.look_again()

    def recalibrate(self) -> None:
        """Forgets the calibration and makes a new one from the next frames."""
        self._calibration.restart()

    @property
    def problem(self) -> str | None:
        """What is wrong with the calibration, in a sentence."""
        return self._calibration.problem

    @property
    def displaced_floor_tags(self) -> Mapping[int, float]:
        """Floor tags that no longer lie where they did, though the camera stands still: by how much (m)."""
        return self._calibration.displaced_m

    @property
    def floor_tags_seen(self) -> tuple[int, ...]:
        """Ids of the floor tags in the newest complete look at them."""
        return self._calibration.floor_tags_seen

    @property
    def tags(self) -> tuple[TagObservation, ...]:
        """What the newest frame showed: its vehicle tags, and the floor tags of the newest complete look at them."""
        return self._tags + self._search.floor_tags

    def process(self, frame: Frame, predicted: Mapping[str, TrackedPose] | None = None) -> FrameDetections:
        """The vehicle tags in the frame. `predicted` are the newest tracks by vehicle id, of any time; they are extrapolated
        to the frame's capture time, and stale ones ignored. ValueError for a frame of another size than the lab file's."""
        self._check(frame)
        wait_ms = max(0.0, (self._clock.now_ns() - frame.stamp_ns) * 1e-6)
        found = self._search.find(frame, predicted or {})
        start_s = self._clock.monotonic_s()
        corners = np.array([tag.corners for tag in found.vehicles]).reshape(-1, 2)
        planes = undistort(self._model, corners).reshape(-1, 4, 2) if len(corners) else corners.reshape(-1, 4, 2)
        undistorted_s = self._clock.monotonic_s()
        detections = self._poses(found.vehicles, planes)
        posed_s = self._clock.monotonic_s()
        self._tags = tuple(found.vehicles)
        return FrameDetections(
            camera=self.spec.id,
            stamp_ns=frame.stamp_ns,
            sent_ns=self._clock.now_ns(),
            frame=frame.number,
            full_search=found.full_search,
            detections=tuple(detections),
            timings_ms={
                "wait": wait_ms,
                "window": found.window_ms,
                "full": found.full_ms,
                "undistort": (undistorted_s - start_s) * 1e3,
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

    def _poses(self, tags: list[TagObservation], planes: NDArray[np.float64]) -> list[Detection]:
        """From the undistorted corners `planes` (N, 4, 2) of N tags."""
        view = self._calibration.view
        if view is None:
            return []
        worn = [self._known.vehicles[tag.key].tag for tag in tags]
        found = tag_poses(
            view,
            planes,
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
