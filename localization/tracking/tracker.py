"""All cameras' detections become one track per vehicle, in the map frame (spec localization, "Better than the reports").

Pure: no clock, no I/O. Two tags with one id are reported and never averaged; who is known keeps its track.
"""

import logging
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import shapely

from localization.tag_pose import upper
from localization.tags import KnownTags, TagKey
from localization.tracking.filter import State
from localization.tracking.motion import TURN, map_acceleration, map_velocity
from localization.tracking.sight import Sight, is_usable, sight_of
from localization.tracking.track import LOST_AFTER_S, Track, Verdict
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


@dataclass(frozen=True, slots=True)
class TrackTransition:
    """A vehicle came to be tracked, or is not any longer. `stamp_ns` is when it was first (last) seen, `place` where (x, y in
    metres, map frame)."""

    vehicle: str
    stamp_ns: int
    tracked: bool
    place: tuple[float, float]

    def __str__(self) -> str:
        x, y = self.place
        return (
            f"{self.vehicle} is tracked at ({x:.2f}, {y:.2f})"
            if self.tracked
            else (f"{self.vehicle} is lost, last seen at ({x:.2f}, {y:.2f})")
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
        self._tracked: set[str] = set()
        self._transitions: deque[TrackTransition] = deque(maxlen=_MOST_REPORTS)

    def update(self, frame: FrameDetections) -> list[TrackedPose]:
        """Takes one camera's frame; returns the new poses of the vehicles whose tracks it changed, each at the capture time
        of the newest frame fused so far."""
        changed: list[TrackedPose] = []
        for vehicle, detections in self._by_vehicle(frame):
            sight = self._chosen(vehicle, detections, frame)
            if sight is None:
                continue
            before = self._tracks[vehicle.id].newest
            verdict = self._tracks[vehicle.id].add(sight)
            if verdict is Verdict.STARTED:
                self._lose(vehicle.id, before)
                self._find(vehicle.id, sight)
            if verdict in (Verdict.STARTED, Verdict.FUSED):
                changed.append(self._published(vehicle.id))
            elif verdict is Verdict.REFUSED:
                self._report_elsewhere(vehicle, sight)
        return changed

    def predict(self, vehicle_id: str, stamp_ns: int) -> TrackedPose | None:
        """The vehicle's pose at another time; None when it is not tracked then. KeyError for an unknown vehicle."""
        state = self._tracks[vehicle_id].at(stamp_ns)
        return None if state is None else self._message(vehicle_id, state)

    def expire(self, now_ns: int) -> None:
        """Notes which vehicles are lost by now: not seen for LOST_AFTER_S. To be called now and then, since what is lost sends no
        frames that would tell."""
        for vehicle_id in tuple(self._tracked):
            state = self._tracks[vehicle_id].newest
            if state is not None and now_ns - state.stamp_ns > LOST_AFTER_S * 1e9:
                self._lose(vehicle_id, state)

    def take_transitions(self) -> list[TrackTransition]:
        """The vehicles lost and found since the last call, in that order. One that is seen again somewhere else, too far away to
        have driven there, is lost and found."""
        taken = list(self._transitions)
        self._transitions.clear()
        return taken

    def take_duplicates(self) -> list[DuplicateTag]:
        """The reports of doubled ids since the last call."""
        taken = list(self._duplicates)
        self._duplicates.clear()
        return taken

    def _lose(self, vehicle_id: str, state: State | None) -> None:
        if state is not None and vehicle_id in self._tracked:
            self._tracked.discard(vehicle_id)
            self._transitions.append(TrackTransition(vehicle_id, state.stamp_ns, False, _place(state.mean)))

    def _find(self, vehicle_id: str, sight: Sight) -> None:
        self._tracked.add(vehicle_id)
        self._transitions.append(TrackTransition(vehicle_id, sight.stamp_ns, True, _place(sight.pose)))

    def _by_vehicle(self, frame: FrameDetections) -> list[tuple[VehicleSpec, list[Detection]]]:
        found: dict[TagKey, list[Detection]] = {}
        for detection in frame.detections:
            key = detection.family, detection.tag_id
            if key not in self._known.vehicles or not is_usable(detection):
                _logger.debug("ignored tag %d of %s", detection.tag_id, frame.camera)
                continue
            found.setdefault(key, []).append(detection)
        return [(self._known.vehicles[key], detections) for key, detections in found.items()]

    def _chosen(self, vehicle: VehicleSpec, detections: list[Detection], frame: FrameDetections) -> Sight | None:
        """The sight to believe. Of several tags with one id the one on the track; without a track none of them."""
        sights = [sight_of(vehicle, detection, frame) for detection in detections]
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
        self._duplicates.append(DuplicateTag(vehicle.id, vehicle.tag.id, camera, stamp_ns, (_place(a), _place(b))))

    def _published(self, vehicle_id: str) -> TrackedPose:
        state = self._tracks[vehicle_id].newest
        assert state is not None
        return self._message(vehicle_id, state)

    def _message(self, vehicle_id: str, state: State) -> TrackedPose:
        x, y, yaw = state.mean[:3].tolist()
        vx, vy = map_velocity(state.mean)
        ax, ay = map_acceleration(state.mean)
        return TrackedPose(
            vehicle=vehicle_id,
            stamp_ns=state.stamp_ns,
            x=x,
            y=y,
            yaw=yaw,
            vx=vx,
            vy=vy,
            yaw_rate=float(state.mean[TURN]),
            covariance=upper(state.covariance[:3, :3]),
            cameras=self._tracks[vehicle_id].cameras(_TOGETHER_S),
            ax=ax,
            ay=ay,
            area=next((name for name, polygon in self._areas if shapely.intersects_xy(polygon, x, y)), None),
        )


def _place(pose: Iterable[float]) -> tuple[float, float]:
    x, y, *_ = pose
    return float(x), float(y)


def _apart(a: Sight, b: Sight) -> float:
    return float(np.hypot(*(a.pose - b.pose)[:2]))
