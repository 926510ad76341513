"""The live tracker, made for recordings: a vehicle that moves as its track does not allow is not lost for a while.

Live, a sight that does not fit is refused until more of them agree, for a wrong one must not steer a robot. A recording may have
few frames per second, or vehicles that are carried or faster than described: here the track begins anew with the sight,
unless it can be another tag with the same id. It can not when the camera that saw the vehicle last sees it now, once, or
when every camera had its turn and none saw it where it was.
"""

from collections import Counter

from msgspec.structs import replace

from localization.tracking import DuplicateTag, Tracker
from protocol.lab import Lab
from protocol.messages import Detection, FrameDetections, TrackedPose


class Following:
    """Takes frames in the order of capture time. `turn_ns` is the time within which every camera has taken a frame."""

    def __init__(self, lab: Lab, turn_ns: int) -> None:
        self._turn_ns = turn_ns
        self._labs = {vehicle.id: lab.model_copy(update={"vehicles": (vehicle,)}) for vehicle in lab.vehicles}
        self._wearers = {(vehicle.tag.family, vehicle.tag.id): vehicle.id for vehicle in lab.vehicles}
        self._trackers = {vehicle: Tracker(alone) for vehicle, alone in self._labs.items()}
        self._newest: dict[str, TrackedPose] = {}
        self._duplicates: list[DuplicateTag] = []
        self.begun_anew: Counter[str] = Counter()

    @property
    def newest(self) -> dict[str, TrackedPose]:
        """The newest pose of every vehicle that was seen so far."""
        return dict(self._newest)

    def update(self, frame: FrameDetections) -> list[TrackedPose]:
        """The poses that the frame changes, as of `Tracker.update`."""
        changed: list[TrackedPose] = []
        for vehicle, detections in self.seen(frame).items():
            changed += self._update_one(vehicle, replace(frame, detections=tuple(detections)))
        self._newest |= {pose.vehicle: pose for pose in changed}
        return changed

    def seen(self, frame: FrameDetections) -> dict[str, list[Detection]]:
        """The detections by vehicle."""
        found: dict[str, list[Detection]] = {}
        for detection in frame.detections:
            found.setdefault(self._wearers[detection.family, detection.tag_id], []).append(detection)
        return found

    def take_duplicates(self) -> list[DuplicateTag]:
        """The reports of doubled ids since the last call."""
        taken, self._duplicates = self._duplicates, []
        return taken

    def _update_one(self, vehicle: str, frame: FrameDetections) -> list[TrackedPose]:
        tracker = self._trackers[vehicle]
        poses, duplicates = tracker.update(frame), tracker.take_duplicates()
        self._duplicates += duplicates
        if poses or duplicates or len(frame.detections) > 1 or not self._is_elsewhere(vehicle, frame):
            return poses
        fresh = Tracker(self._labs[vehicle])
        poses = fresh.update(frame)
        if poses:
            self._trackers[vehicle] = fresh
            self.begun_anew[vehicle] += 1
        return poses

    def _is_elsewhere(self, vehicle: str, frame: FrameDetections) -> bool:
        """Whether the only sight of the vehicle in a frame must be of the vehicle itself."""
        last = self._newest.get(vehicle)
        if last is None or frame.stamp_ns <= last.stamp_ns:
            return False
        return frame.camera in last.cameras or frame.stamp_ns - last.stamp_ns > self._turn_ns
