"""A crowd on nested loops, tracked by all cameras, and everything that is needed to look at it again with a stopwatch."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geometry import SE2, angle_difference
from lab.snapshot import VehicleSnapshot
from launcher.experiments.courses import Course, rectangle
from launcher.experiments.fleets import with_fleet
from launcher.experiments.rooms import Room
from localization.tracking import Tracker
from localization.tracking.track import LOST_AFTER_S
from protocol.lab import Lab
from protocol.messages import FrameDetections, TrackedPose

SPEED_MPS = 0.4
_LOOPS = 3
_BETWEEN_LOOPS_M = 0.6
_MARGIN_X_M, _MARGIN_Y_M = 0.35, 0.6
"""From the lab's bounds: there the cameras see a tag of the reports' height as a whole."""
_SETTLE_S = 2.0
"""The vehicles stand meanwhile and are found."""


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """One frame of one camera: what was on the floor, what was known before, and what came of it."""

    camera: str
    stamp_ns: int
    vehicles: tuple[VehicleSnapshot, ...]
    predicted: Mapping[str, TrackedPose]
    detections: FrameDetections


@dataclass(frozen=True, slots=True, eq=False)
class CrowdDrive:
    """The drive: `lost` counts vehicles that were not tracked any more while a camera saw them."""

    room: Room
    looks: list[Look]
    visible_tags: int
    found_tags: int
    lost: int
    error_median_mm: float
    error_max_mm: float


def drive_crowd(lab: Lab, seed: int, count: int, seconds: float) -> CrowdDrive:
    """`count` vehicles drive for `seconds`, cameras taking turns as free-running ones do."""
    room = Room(with_fleet(lab, count), seed)
    loops, tracker, poses = _Loops(room.lab), Tracker(room.lab), dict[str, TrackedPose]()
    period_s = 1.0 / (room.cameras[0].pipeline.spec.rate_hz * len(room.cameras))
    looks, errors_mm = list[Look](), list[float]()
    seen_ns: dict[str, int] = {}
    visible = found = lost = 0
    settle = round(_SETTLE_S / period_s)
    for turn in range(-settle, max(1, round(seconds / period_s))):
        room.clock.wait(period_s)
        stamp_ns, camera = room.clock.now_ns(), room.cameras[turn % len(room.cameras)]
        truth = loops.at(max(0, turn) * period_s, driving=turn >= 0)
        predicted = dict(poses)
        detections = room.look(camera, truth, predicted)
        updated = tracker.update(detections)
        poses.update({pose.vehicle: pose for pose in updated})
        tracker.expire(stamp_ns)
        transitions = tracker.take_transitions()
        in_view = [v for v in truth if camera.visibility.sees(v.id, SE2(v.x, v.y, v.yaw))]
        if turn >= 0:
            given = {detection.tag_id for detection in detections.detections}
            visible += len(in_view)
            found += sum(room.lab.vehicle(v.id).tag.id in given for v in in_view)
            lost += sum(
                not each.tracked and stamp_ns - seen_ns.get(each.vehicle, 0) <= LOST_AFTER_S * 1e9
                for each in transitions
            )
            exact = {v.id: v for v in truth}
            errors_mm += [1e3 * math.hypot(p.x - exact[p.vehicle].x, p.y - exact[p.vehicle].y) for p in updated]
            looks.append(Look(camera.id, stamp_ns, truth, predicted, detections))
        seen_ns.update({v.id: stamp_ns for v in in_view})
    median, largest = (float(np.median(errors_mm)), max(errors_mm)) if errors_mm else (0.0, 0.0)
    return CrowdDrive(room, looks, visible, found, lost, median, largest)


class _Loops:
    """Rectangles inside one another, the vehicles spread over them evenly; every second loop is driven the other way round."""

    def __init__(self, lab: Lab) -> None:
        min_x, min_y, max_x, max_y = lab.bounds()
        self._courses: list[Course] = []
        for loop in range(_LOOPS):
            x, y = _MARGIN_X_M + loop * _BETWEEN_LOOPS_M, _MARGIN_Y_M + loop * _BETWEEN_LOOPS_M
            radius_m = 0.6 - 0.1 * loop
            self._courses.append(rectangle(min_x + x, min_y + y, max_x - x, max_y - y, radius_m))
        self._places = list(zip((v.id for v in lab.vehicles), self._spread(len(lab.vehicles)), strict=True))

    def _spread(self, count: int) -> Sequence[tuple[int, float]]:
        """Loop and way along it (m) of each vehicle: equally far apart over the length of all loops."""
        lengths = np.array([course.length_m for course in self._courses])
        shares = np.floor(np.cumsum(lengths) / lengths.sum() * count + 1e-9).astype(int)
        numbers = np.diff(shares, prepend=0)
        return [
            (loop, place / number * float(lengths[loop]))
            for loop, number in enumerate(numbers)
            for place in range(number)
        ]

    def at(self, time_s: float, *, driving: bool) -> tuple[VehicleSnapshot, ...]:
        """All vehicles after that time at SPEED_MPS."""
        snapshots: list[VehicleSnapshot] = []
        for vehicle_id, (loop, start_m) in self._places:
            course, back = self._courses[loop], loop % 2 == 1
            way_m = start_m + SPEED_MPS * time_s * (-1 if back else 1)
            x, y, heading = course.at(way_m)
            turn = angle_difference(course.at(way_m + 0.02)[2], course.at(way_m - 0.02)[2]) / 0.04 * SPEED_MPS
            yaw = heading + math.pi if back else heading
            speed = SPEED_MPS if driving else 0.0
            turning = (-turn if back else turn) if driving else 0.0
            snapshots.append(VehicleSnapshot(vehicle_id, x, y, math.remainder(yaw, math.tau), speed, turning))
        return tuple(snapshots)
