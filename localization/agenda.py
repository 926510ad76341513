"""When the cameras of a lab are to be calibrated jointly: at the first start, after a camera found its place anew by itself,
and when a person asks. No I/O."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from protocol.lab import Lab, camera_basis, floor_basis
from protocol.messages import Calibration, CalibrationRun, CameraState, FloorTagSighting

_SETTLED_NS = 1_000_000_000
"""After the newest sighting, so that cameras that were bumped together are refined together."""
_PATIENCE_NS = 10_000_000_000
"""How long a first calibration waits for cameras that have said nothing yet."""
_ANSWER_NS = 15_000_000_000
"""How long a run waits for the cameras that were asked."""


@dataclass(slots=True)
class Agenda:
    """What is known, and what follows from it. Mutable; belongs to one task."""

    lab: Lab
    sightings: dict[str, FloorTagSighting] = field(default_factory=dict[str, FloorTagSighting])
    states: dict[str, CameraState] = field(default_factory=dict[str, CameraState])
    run: CalibrationRun | None = None
    _failed: frozenset[tuple[str, int]] = frozenset()

    def usable(self) -> list[FloorTagSighting]:
        """The newest sighting of every camera, if it is of the camera that the lab description has today."""
        newest = ((camera, self.sightings.get(camera.id)) for camera in self.lab.cameras)
        return [seen for camera, seen in newest if seen is not None and seen.basis == camera_basis(camera)]

    def still_holds(self, calibration: Calibration | None) -> Calibration | None:
        """The calibration as far as it rests on today's lab description; None when it does not at all."""
        if calibration is None or calibration.floor_basis != floor_basis(self.lab.floor_tags):
            return None
        bases = {camera.id: camera_basis(camera) for camera in self.lab.cameras}
        cameras = {name: c for name, c in calibration.cameras.items() if bases.get(name) == c.basis}
        return calibration.model_copy(update={"cameras": cameras})

    def unrefined(self, current: Calibration | None, now_ns: int) -> tuple[str, ...]:
        """Cameras that calibrated themselves and are not part of the result in force, once it is time to refine them; none
        while others may follow, and none that failed already as they are. What somebody asked for is theirs to decide."""
        held, usable = self.still_holds(current), self.usable()
        new = [
            sighting
            for sighting in usable
            if held is None
            or sighting.camera not in held.cameras
            or (sighting.extrinsics_ns > held.stamp_ns and not sighting.request)
        ]
        if not new or self._key(new) == self._failed:
            return ()
        newest_ns = max(sighting.stamp_ns for sighting in new)
        complete = len(usable) == len(self.lab.cameras)
        if now_ns - newest_ns < (_SETTLED_NS if complete else _PATIENCE_NS):
            return ()
        return tuple(sighting.camera for sighting in new)

    def note_failure(self, cameras: tuple[str, ...]) -> None:
        """These, as they were seen, gave no joint result: not tried again before something else is seen."""
        self._failed = self._key([self.sightings[camera] for camera in cameras])

    def answered(self, run: CalibrationRun) -> tuple[str, ...]:
        """The cameras that looked anew for the run."""
        return tuple(c for c in run.cameras if c in self.sightings and self.sightings[c].request == run.id)

    def is_collected(self, run: CalibrationRun, now_ns: int) -> bool:
        """Whether nobody is waited for any longer."""
        return set(self.answered(run)) >= set(run.cameras) or now_ns - run.started_ns > _ANSWER_NS

    def why_silent(self, run: CalibrationRun) -> str:
        """A sentence for each camera that did not answer."""
        silent = [camera for camera in run.cameras if camera not in self.answered(run)]
        return "; ".join(f"{camera} did not answer ({_state(self.states, camera)})" for camera in silent)

    def _key(self, sightings: list[FloorTagSighting]) -> frozenset[tuple[str, int]]:
        return frozenset((sighting.camera, sighting.stamp_ns) for sighting in sightings)


def _state(states: Mapping[str, CameraState], camera: str) -> str:
    state = states.get(camera)
    if state is None:
        return "its process has never reported"
    return state.error or (f"it sees {len(state.floor_tags_seen)} floor tags" if state.connected else "not connected")
