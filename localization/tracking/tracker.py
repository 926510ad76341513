"""All cameras' detections become one track per vehicle, in the map frame (spec localization, "Better than the reports").

Pure: no clock, no I/O. Two tags with one id are reported and never averaged; who is known keeps its track.
"""

import logging
import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import shapely

from geometry import SE2
from localization.tag_pose import from_upper, upper, vehicle_pose
from localization.tags import KnownTags, TagKey
from localization.tracking.motion import State, map_velocity
from localization.tracking.track import Sight, Track, Verdict
from protocol.lab import Lab, VehicleSpec
from protocol.messages import Detection, FrameDetections, TrackedPose

_logger = logging.getLogger(__name__)

_TOGETHER_S = 0.02
"""Cameras whose frames are this near in time count as having seen the vehicle in the same update."""
_SAME_INSTANT_S = 0.05
_APART_M = 0.10
"""Two detections of one id in one frame this far apart are two tags."""
_MOST_REPORTS = 100


@dataclass(frozen=True, slots=True)
class DuplicateTag:
    """Two tags with one id: in one frame, or one where a live track says that its vehicle is not. Metres, map frame."""

    vehicle: str
    tag_id: int
    camera: str
    stamp_ns: int
    places: tuple[tuple[float, float], tuple[float, float]]

    def __str__(self) -> str:
        (ax, ay), (bx, by) = self.places
        return (
            f"tag {self.tag_id} of {self.vehicle} is at ({ax:.2f}, {ay:.2f}) and at ({bx:.2f}, {by:.2f}) at once,"
            f" says {self.camera}: two tags with one id?"
        )


class Tracker:
    """Fuses `FrameDetections` of any camera, in any order, into poses of vehicles."""

    def __init__(self, lab: Lab) -> None:
        self._known = KnownTags.of(lab)
        self._tracks = {vehicle.id: Track(vehicle.limits) for vehicle in lab.vehicles}
        self._areas = [(area.id, shapely.Polygon(area.outline)) for area in lab.areas]
        for _, polygon in self._areas:
            shapely.prepare(polygon)
        self._duplicates: deque[DuplicateTag] = deque(maxlen=_MOST_REPORTS)

    def update(self, frame: FrameDetections) -> list[TrackedPose]:
        """Takes one camera's frame; returns the new poses of the vehicles whose tracks it changed, each at the capture time
        of the newest frame fused so far."""
        changed: list[TrackedPose] = []
        for vehicle, detections in self._by_vehicle(frame):
            sight = self._chosen(vehicle, detections, frame)
            if sight is None:
                continue
            verdict = self._tracks[vehicle.id].add(sight)
            if verdict in (Verdict.STARTED, Verdict.FUSED):
                changed.append(self._published(vehicle.id))
            elif verdict is Verdict.REFUSED:
                self._report_elsewhere(vehicle, sight)
        return changed

    def predict(self, vehicle_id: str, stamp_ns: int) -> TrackedPose | None:
        """The vehicle's pose at another time; None when it is not tracked then. KeyError for an unknown vehicle."""
        state = self._tracks[vehicle_id].at(stamp_ns)
        return None if state is None else self._message(vehicle_id, state)

    def take_duplicates(self) -> list[DuplicateTag]:
        """The reports of doubled ids since the last call."""
        taken = list(self._duplicates)
        self._duplicates.clear()
        return taken

    def _by_vehicle(self, frame: FrameDetections) -> list[tuple[VehicleSpec, list[Detection]]]:
        found: dict[TagKey, list[Detection]] = {}
        for detection in frame.detections:
            key = detection.family, detection.tag_id
            if key not in self._known.vehicles or not _usable(detection):
                _logger.debug("ignored tag %d of %s", detection.tag_id, frame.camera)
                continue
            found.setdefault(key, []).append(detection)
        return [(self._known.vehicles[key], detections) for key, detections in found.items()]

    def _chosen(self, vehicle: VehicleSpec, detections: list[Detection], frame: FrameDetections) -> Sight | None:
        """The sight to believe. Of several tags with one id the one on the track; without a track none of them."""
        sights = [_sight(vehicle, detection, frame) for detection in detections]
        if len(sights) == 1:
            return sights[0]
        first, *others = sights
        farthest = max(others, key=lambda other: _apart(first, other))
        if _apart(first, farthest) < _APART_M:
            return min(sights, key=lambda sight: float(np.trace(sight.covariance)))
        self._report(vehicle, frame.camera, frame.stamp_ns, first.pose, farthest.pose)
        track = self._tracks[vehicle.id]
        followed = [(distance2, sight) for sight in sights if (distance2 := track.distance2(sight)) is not None]
        return min(followed, key=lambda item: item[0])[1] if followed else None

    def _report_elsewhere(self, vehicle: VehicleSpec, sight: Sight) -> None:
        """A refused sight of an instant at which the vehicle was seen elsewhere. (Seen later, it may have been carried.)"""
        state = self._tracks[vehicle.id].newest
        if state is None or abs(sight.stamp_ns - state.stamp_ns) > _SAME_INSTANT_S * 1e9:
            return
        if float(np.hypot(*(state.mean[:2] - sight.pose[:2]))) >= _APART_M:
            self._report(vehicle, sight.camera, sight.stamp_ns, state.mean, sight.pose)

    def _report(self, vehicle: VehicleSpec, camera: str, stamp_ns: int, a: Iterable[float], b: Iterable[float]) -> None:
        (ax, ay, *_), (bx, by, *_) = a, b
        places = ((float(ax), float(ay)), (float(bx), float(by)))
        self._duplicates.append(DuplicateTag(vehicle.id, vehicle.tag.id, camera, stamp_ns, places))

    def _published(self, vehicle_id: str) -> TrackedPose:
        state = self._tracks[vehicle_id].newest
        assert state is not None
        return self._message(vehicle_id, state)

    def _message(self, vehicle_id: str, state: State) -> TrackedPose:
        x, y, yaw = (float(value) for value in state.mean[:3])
        vx, vy = map_velocity(state)
        return TrackedPose(
            vehicle=vehicle_id,
            stamp_ns=state.stamp_ns,
            x=x,
            y=y,
            yaw=yaw,
            vx=vx,
            vy=vy,
            yaw_rate=float(state.mean[5]),
            covariance=upper(state.covariance[:3, :3]),
            cameras=self._tracks[vehicle_id].cameras(_TOGETHER_S),
            area=next((name for name, polygon in self._areas if shapely.intersects_xy(polygon, x, y)), None),
        )


def _sight(vehicle: VehicleSpec, detection: Detection, frame: FrameDetections) -> Sight:
    pose, covariance = vehicle_pose(
        SE2(detection.x, detection.y, detection.yaw), from_upper(detection.covariance), vehicle.tag.pose_on_vehicle()
    )
    return Sight(frame.camera, frame.stamp_ns, np.array([pose.x, pose.y, pose.yaw]), covariance)


def _usable(detection: Detection) -> bool:
    """Finite, and with a covariance that is one."""
    if not all(math.isfinite(v) for v in (detection.x, detection.y, detection.yaw, *detection.covariance)):
        return False
    return float(np.linalg.eigvalsh(from_upper(detection.covariance))[0]) > 0.0


def _apart(a: Sight, b: Sight) -> float:
    return float(np.hypot(*(a.pose - b.pose)[:2]))
