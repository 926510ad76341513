"""A camera's process: `python -m localization.camera CAMERA`. Frames in; detections, floor raster, state, preview out.

Detections leave first. Everything else follows at its own rate, and what Redis does not take is superseded by the next.
"""

import argparse
import logging
import signal
from collections.abc import Mapping, Sequence
from types import FrameType
from typing import NoReturn, cast

import cv2

from localization.calibration_link import CalibrationLink
from localization.camera_state import CameraStatistics
from localization.floor import FloorObserver
from localization.pipeline import CameraPipeline, PipelineOptions
from localization.pose_feed import PoseFeed
from localization.preview import preview_jpeg
from localization.robots_in_view import RobotsInView
from localization.sources import Source, open_source
from localization.timings import CAMERA_STAGES, TimingLog, camera_stages, open_timing_log
from protocol import keys
from protocol.bus import UNAVAILABLE, SyncBus
from protocol.channels import CAMERA_STATES, DETECTIONS, RASTERS
from protocol.clock import Clock, SystemClock
from protocol.codec import decode, encode
from protocol.errors import DecodeError, LabFileError
from protocol.frames import Frame
from protocol.lab import Lab, load_lab
from protocol.messages import CameraExtrinsics, TrackedPose
from protocol.settings import Settings

_logger = logging.getLogger(__name__)

_STATE_EVERY_S = 0.5
_PREVIEW_EVERY_S = 0.25
_FRAME_TIMEOUT_S = 0.2
_MOST_POSE_READS_HZ = 30.0
_REDIS_AT_START_S = 2.0


class CameraService:
    """The I/O around `CameraPipeline`: one `step` per frame, or per timeout when none comes."""

    def __init__(
        self,
        lab: Lab,
        source: Source,
        pipeline: CameraPipeline,
        floor: FloorObserver,
        bus: SyncBus,
        timings: TimingLog,
        clock: Clock,
    ) -> None:
        self._timings = timings
        self._source, self._pipeline, self._floor, self._bus, self._clock = source, pipeline, floor, bus, clock
        self._calibration = CalibrationLink(lab, pipeline, bus, clock)
        self._id = pipeline.spec.id
        self._names = {(v.tag.family, v.tag.id): v.id for v in lab.vehicles}
        self._poses = PoseFeed(bus, min(_MOST_POSE_READS_HZ, 2 * pipeline.spec.rate_hz))
        self._stored = pipeline.extrinsics
        self._robots = RobotsInView()
        self._due: dict[str, float] = {}

    def run(self) -> NoReturn:
        """For ever; a signal's exception ends it."""
        clock = self._clock
        statistics = CameraStatistics(clock.monotonic_s())
        while True:
            frame = self._source.newest(_FRAME_TIMEOUT_S)
            if frame is not None:
                poses = self._poses.newest
                detections = self._pipeline.process(frame, poses)
                ready_s = clock.monotonic_s()
                self._bus.publish(DETECTIONS, self._id, detections)
                sent_s = clock.monotonic_s()
                stages_ms = camera_stages(detections, frame.decode_ms, (sent_s - ready_s) * 1e3)
                self._timings.add(detections.stamp_ns, stages_ms)
                statistics.add(detections, sent_s)
                seen = {self._names[tag.key] for tag in self._pipeline.tags if tag.key in self._names}
                self._robots.note(frame.stamp_ns, seen, full_search=detections.full_search)
                self._look_at_floor(frame, poses)
                if self._calibration.note():
                    self._due.pop("state", None)  # an alarm does not wait for its turn
            now_s = clock.monotonic_s()
            if frame is not None and self._is_due("preview", now_s, _PREVIEW_EVERY_S):
                self._keep(keys.PREVIEWS, preview_jpeg(frame.pixels, self._pipeline.tags, self._names))
            if self._is_due("state", now_s, _STATE_EVERY_S):
                if self._calibration.exchange():
                    self._stored = None  # Redis has lost it with the rest
                self._keep_extrinsics()
                state = statistics.state(self._source.state, self._pipeline, now_s, clock.now_ns())
                self._bus.publish(CAMERA_STATES, self._id, state)

    def close(self) -> None:
        """Keeps what was learned and lets everything go."""
        self._poses.close()
        self._source.close()
        self._floor.save()

    def _look_at_floor(self, frame: Frame, poses: Mapping[str, TrackedPose]) -> None:
        extrinsics = self._pipeline.extrinsics
        if extrinsics is None:
            return
        known = self._robots.are_known(poses)
        raster = self._floor.observe(frame, extrinsics, poses, robots_are_known=known)
        if raster is not None:
            self._bus.publish(RASTERS, self._id, raster)
        tile = self._floor.picture()
        if tile is not None:
            self._keep(keys.FLOOR_TILES, tile.pack())

    def _keep_extrinsics(self) -> None:
        """Writes a new calibration, again and again until Redis takes it."""
        extrinsics = self._pipeline.extrinsics
        if extrinsics is None or extrinsics is self._stored:
            return
        if self._keep(keys.EXTRINSICS, encode(extrinsics)):
            self._stored = extrinsics

    def _keep(self, key: str, value: bytes) -> bool:
        try:
            self._bus.redis.hset(key, self._id, value)  # pyright: ignore[reportArgumentType]  # bytes are fine
        except UNAVAILABLE:
            return False
        return True

    def _is_due(self, what: str, now_s: float, every_s: float) -> bool:
        if now_s < self._due.get(what, now_s):
            return False
        self._due[what] = now_s + every_s
        return True


def stored_extrinsics(bus: SyncBus, camera_id: str, clock: Clock) -> CameraExtrinsics | None:
    """What an earlier run of this camera found; None when there is nothing usable, or Redis does not answer for a while."""
    deadline_s = clock.monotonic_s() + _REDIS_AT_START_S
    while True:
        try:
            raw = cast("bytes | None", bus.redis.hget(keys.EXTRINSICS, camera_id))
            return None if raw is None else decode(CameraExtrinsics, raw)
        except DecodeError as error:
            _logger.warning("the stored calibration is not usable: %s", error)
            return None
        except UNAVAILABLE as error:
            if clock.monotonic_s() > deadline_s:
                _logger.warning("calibrating anew, the stored calibration is out of reach: %s", error)
                return None
            clock.wait(0.1)


def _end(_number: int, _frame: FrameType | None) -> NoReturn:
    raise SystemExit(0)


def main(arguments: Sequence[str] | None = None) -> None:
    """Settings come from the environment (`protocol.settings`), the camera from the command line."""
    parser = argparse.ArgumentParser(prog="python -m localization.camera", description=__doc__)
    parser.add_argument("camera", help="the camera's id in the lab description")
    parser.add_argument(
        "--full-search-every", type=int, metavar="K", help="search the whole of every K-th frame (about once a second)"
    )
    given = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(message)s")
    settings = Settings.from_environment()
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from None
    known = [camera.id for camera in lab.cameras]
    if given.camera not in known:
        raise SystemExit(f"{settings.lab} has no camera {given.camera!r}, it has {', '.join(known) or 'none'}")
    _logger.info("camera %s, %s", given.camera, settings)
    signal.signal(signal.SIGTERM, _end)
    signal.signal(signal.SIGINT, _end)
    cv2.setNumThreads(1)  # several cameras share the cores; threads for one frame only get into each other's way
    clock = SystemClock()
    bus = SyncBus.connect(settings.redis_url)
    pipeline = CameraPipeline(
        lab,
        given.camera,
        clock=clock,
        options=PipelineOptions(full_search_every=given.full_search_every),
        extrinsics=stored_extrinsics(bus, given.camera, clock),
    )
    floor = FloorObserver(lab, given.camera, settings.state)
    source = open_source(pipeline.spec, settings.state, clock)
    noted = {"width": pipeline.spec.width, "height": pipeline.spec.height, "rate_hz": pipeline.spec.rate_hz}
    noted["full_search_every"] = given.full_search_every
    with open_timing_log(settings, clock, lab.name, "camera", CAMERA_STAGES, given.camera, noted) as timings:
        service = CameraService(lab, source, pipeline, floor, bus, timings, clock)
        try:
            service.run()
        finally:
            service.close()
            bus.close()


if __name__ == "__main__":
    main()
