"""A surveyed room: its simulated cameras, each with the pipeline that is deployed, calibrated from the floor tags together.

The seed decides what truly stands in it (`lab.truth`): how far floor tags, lenses and tag heights are off their description.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lab.rendering import CameraRenderer
from lab.snapshot import Snapshot, VehicleSnapshot
from launcher.errors import LauncherError
from launcher.experiments.visibility import TagVisibility
from localization.calibration import ExtrinsicsError, JointCalibration, refine_jointly
from localization.pipeline import CameraPipeline, PipelineOptions
from protocol.clock import SimulatedClock
from protocol.frames import Frame
from protocol.lab import Lab, SimulatedSurvey
from protocol.messages import FrameDetections, TrackedPose

_MOST_EMPTY_FRAMES = 40
"""A camera that sees the empty floor has found its place long before."""


def surveyed_as_described(lab: Lab) -> Lab:
    """The lab whose truth is as far off its description as the description says of its own accuracy: what honest covariances are
    judged by."""
    accuracy = lab.accuracy
    survey = SimulatedSurvey(
        floor_tag_m=accuracy.floor_tag_m,
        floor_tag_rad=accuracy.floor_tag_rad,
        focal=accuracy.focal,
        center_px=accuracy.center_px,
        tag_height_m=accuracy.tag_height_m,
    )
    return lab.model_copy(update={"simulation": lab.simulation.model_copy(update={"survey": survey})})


@dataclass(frozen=True, slots=True, eq=False)
class RoomCamera:
    """One camera: what makes its frames, what reads them, and the truth of which tags it sees."""

    id: str
    renderer: CameraRenderer
    pipeline: CameraPipeline
    visibility: TagVisibility


class Room:
    """The cameras over one surveyed floor. Time passes when it is told to; durations count as nothing, so that results do not
    depend on the machine. LauncherError when the floor tags do not give a calibration."""

    def __init__(self, lab: Lab, seed: int, options: PipelineOptions | None = None) -> None:
        self.lab, self.seed = lab, seed
        self.clock = SimulatedClock()
        self.cameras = [
            RoomCamera(
                camera.id,
                CameraRenderer(lab, camera.id, seed),
                CameraPipeline(lab, camera.id, clock=self.clock, options=options),
                TagVisibility(lab, camera.id, seed),
            )
            for camera in lab.cameras
        ]
        self._frames = 0
        self.calibration = self._calibrate()

    def look(
        self, camera: RoomCamera, vehicles: Sequence[VehicleSnapshot], predicted: Mapping[str, TrackedPose]
    ) -> FrameDetections:
        """What the camera makes of this instant."""
        self._frames += 1
        stamp_ns = self.clock.now_ns()
        pixels = camera.renderer.render(Snapshot(stamp_ns, tuple(vehicles), ()), self._frames)
        return camera.pipeline.process(Frame(self._frames, stamp_ns, pixels), predicted)

    def _calibrate(self) -> JointCalibration:
        """Every camera from the empty floor, then all of them together, as the calibrator does when the last one is ready."""
        for camera in self.cameras:
            for _ in range(_MOST_EMPTY_FRAMES):
                if camera.pipeline.sighting is not None:
                    break
                self.clock.wait(1.0 / camera.pipeline.spec.rate_hz)
                self.look(camera, (), {})
        sightings = [camera.pipeline.sighting for camera in self.cameras]
        unseen = [camera for camera, sighting in zip(self.cameras, sightings, strict=True) if sighting is None]
        if unseen:
            raise LauncherError(f"camera {unseen[0].id} of the room of seed {self.seed}: {unseen[0].pipeline.problem}")
        try:
            joint = refine_jointly(self.lab, [sighting for sighting in sightings if sighting is not None])
        except ExtrinsicsError as error:
            raise LauncherError(f"the room of seed {self.seed}: {error}") from None
        for camera in self.cameras:
            camera.pipeline.adopt(joint.extrinsics[camera.id], joint.floor_tags)
        return joint
