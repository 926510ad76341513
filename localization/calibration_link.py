"""A camera's side of calibration at run time: it takes joint results that came into force, looks anew at the floor tags when
somebody asks, and tells what it saw (docs/calibrate.md)."""

import logging
from typing import cast

import numpy as np

from geometry import SE2
from localization.calibration import FloorSighting
from localization.pipeline import CameraPipeline
from protocol import keys
from protocol.bus import UNAVAILABLE, SyncBus
from protocol.channels import CALIBRATION_RUNS, EVENTS, LAB_INSTANCE, SIGHTINGS
from protocol.clock import Clock
from protocol.codec import decode
from protocol.errors import BusUnavailableError, DecodeError
from protocol.lab import Lab, camera_basis, floor_basis
from protocol.messages import Calibration, CalibrationRun, Event, EventLevel, FloorTagSighting, RunState
from protocol.messages.calibration import CURRENT, Corners

_logger = logging.getLogger(__name__)
_MOST_PENDING = 20


class CalibrationLink:
    """Call `exchange` a few times a second, and `note` after every frame; both belong to the camera's own thread."""

    def __init__(self, lab: Lab, pipeline: CameraPipeline, bus: SyncBus, clock: Clock) -> None:
        self._pipeline, self._bus, self._clock = pipeline, bus, clock
        self._id = pipeline.spec.id
        self._camera_basis, self._floor_basis = camera_basis(pipeline.spec), floor_basis(lab.floor_tags)
        self._newest_ns = 0 if pipeline.extrinsics is None else pipeline.extrinsics.stamp_ns
        self._extrinsics = pipeline.extrinsics
        self._problem: str | None = None
        self._displaced: frozenset[int] = frozenset()
        self._seen: bytes | None = None
        self._handled = self._request = 0
        self._told: FloorSighting | None = None
        self._pending: list[Event] = []

    def note(self) -> bool:
        """Notices what the newest frame changed; whether something did that people should hear of at once."""
        extrinsics, problem = self._pipeline.extrinsics, self._pipeline.problem
        if extrinsics is not None and extrinsics is not self._extrinsics:
            tags = ", ".join(str(tag) for tag in extrinsics.floor_tags)
            text = f"{self._id} found its place from floor tags {tags}, {extrinsics.reprojection_px:.2f} px off"
            self._record(EventLevel.INFO, "camera_calibrated", text)
            self._newest_ns = extrinsics.stamp_ns
        changed = extrinsics is not self._extrinsics or (problem is None) != (self._problem is None)
        if problem is not None and self._problem is None:
            level = EventLevel.ERROR if extrinsics is None else EventLevel.WARNING
            self._record(level, "camera_not_calibrated", f"{self._id}: {problem}")
        displaced = self._pipeline.displaced_floor_tags
        for tag in sorted(displaced.keys() - self._displaced):
            text = f"{self._id}: floor tag {tag} lies {displaced[tag] * 1e3:.0f} mm from where it did; calibrate, or put it back"
            self._record(EventLevel.WARNING, "floor_tag_displaced", text)
        self._displaced = frozenset(displaced)
        self._extrinsics, self._problem = extrinsics, problem
        return changed

    def exchange(self) -> bool:
        """Reads what is in force and what is asked for, sends what is new; whether Redis has lost what it was told. Nothing
        happens while it is out of reach."""
        try:
            reads = self._bus.redis.pipeline(transaction=False)
            reads.hget(keys.CALIBRATIONS, CURRENT)
            reads.hget(keys.live(CALIBRATION_RUNS.name), LAB_INSTANCE)
            reads.hexists(keys.live(SIGHTINGS.name), self._id)
            current, run, is_known = cast("tuple[bytes | None, bytes | None, bool]", tuple(reads.execute()))
        except UNAVAILABLE:
            return False
        if current is not None and current != self._seen:
            self._seen = current
            self._adopt(current)
        is_lost = not is_known and self._told is not None and not self._request
        if is_lost:
            self._told = None
        if run is not None:
            self._heed(run)
        self._tell_sighting()
        self._tell_events()
        return is_lost

    def _adopt(self, data: bytes) -> None:
        """Takes a joint result: its floor tags always, its extrinsics unless this camera found newer ones by itself."""
        try:
            calibration = decode(Calibration, data)
        except DecodeError as error:
            _logger.warning("the calibration in force is not usable: %s", error)
            return
        mine = calibration.cameras.get(self._id)
        if calibration.floor_basis != self._floor_basis or (mine is not None and mine.basis != self._camera_basis):
            _logger.info("the stored calibration rests on another lab description and is not used")
            return
        floor_tags = {tag: SE2(place.x, place.y, place.yaw) for tag, place in calibration.floor_tags.items()}
        own = self._pipeline.extrinsics
        if mine is not None and calibration.stamp_ns > self._newest_ns:
            self._pipeline.adopt(mine.extrinsics(self._id, calibration.stamp_ns), floor_tags)
            self._newest_ns = calibration.stamp_ns
            _logger.info("took calibration %d of %s", calibration.id, calibration.by)
        elif own is not None:
            self._pipeline.adopt(own, floor_tags)
        self._extrinsics, self._problem = self._pipeline.extrinsics, self._pipeline.problem

    def _heed(self, data: bytes) -> None:
        try:
            run = decode(CalibrationRun, data)
        except DecodeError as error:
            _logger.warning("ignored a calibration run: %s", error)
            return
        asked = run.state is RunState.COLLECTING and self._id in run.cameras and self._id not in run.answered
        if asked and run.id != self._handled:
            self._handled = self._request = run.id
            self._told = self._pipeline.sighting  # what was seen before is no answer
            self._pipeline.look_again()

    def _tell_sighting(self) -> None:
        sighting, extrinsics = self._pipeline.sighting, self._pipeline.extrinsics
        if sighting is None or extrinsics is None or sighting is self._told:
            return
        message = sighting_message(sighting, extrinsics.stamp_ns, self._camera_basis, self._request)
        if self._bus.publish(SIGHTINGS, self._id, message):
            self._told, self._request = sighting, 0

    def _record(self, level: EventLevel, kind: str, text: str) -> None:
        (_logger.info if level is EventLevel.INFO else _logger.warning)("%s", text)
        event = Event(stamp_ns=self._clock.now_ns(), level=level, source=self._id, kind=kind, text=text)
        self._pending = [*self._pending, event][-_MOST_PENDING:]

    def _tell_events(self) -> None:
        while self._pending:
            try:
                self._bus.publish(EVENTS, LAB_INSTANCE, self._pending[0])
            except BusUnavailableError:
                return  # kept for the next time
            del self._pending[0]


def sighting_message(sighting: FloorSighting, extrinsics_ns: int, basis: str, request: int) -> FloorTagSighting:
    """A sighting as it is sent."""
    return FloorTagSighting(
        camera=sighting.camera,
        stamp_ns=sighting.stamp_ns,
        frames=sighting.frames,
        corners={tag: _corners(corners.tolist()) for tag, corners in sighting.corners.items()},
        corner_noise_px=sighting.corner_noise_px,
        extrinsics_ns=extrinsics_ns,
        basis=basis,
        request=request,
    )


def received_sighting(message: FloorTagSighting) -> FloorSighting:
    """A sighting as it is calibrated from."""
    return FloorSighting(
        camera=message.camera,
        stamp_ns=message.stamp_ns,
        frames=message.frames,
        corners={tag: np.array(corners) for tag, corners in message.corners.items()},
        corner_noise_px=message.corner_noise_px,
    )


def _corners(rows: list[list[float]]) -> Corners:
    a, b, c, d = ((row[0], row[1]) for row in rows)
    return a, b, c, d
