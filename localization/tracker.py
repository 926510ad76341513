"""The tracker process: `python -m localization.tracker`. Detections of all cameras in; poses out as the lab's `outputs` say.

UDP first, then the bus: a slow Redis must not age the robots' poses.
"""

import argparse
import asyncio
import contextlib
import logging
from collections.abc import Sequence

from localization.outputs import Outputs, UdpSender, outputs_of
from localization.timings import TRACKER_STAGES, TimingLog, open_timing_log
from localization.track_reports import TrackReports, sentence
from localization.tracking import DuplicateTag, Tracker, TrackTransition
from protocol.bus import Bus
from protocol.channels import DETECTIONS, EVENTS, LAB_INSTANCE, REGISTRATIONS
from protocol.clock import Clock, SystemClock
from protocol.errors import BusUnavailableError, LabFileError
from protocol.lab import Lab, load_lab
from protocol.lifetime import run_until_signal
from protocol.messages import Event, EventLevel, FrameDetections, Registration
from protocol.settings import Settings

_logger = logging.getLogger(__name__)

_OLDEST_S, _AHEAD_S = 2.0, 0.5
"""Frames older than this, or from the future, come from a snapshot or a clock that is wrong."""
_REPORT_EVERY_S = 10.0
_LOOK_FOR_LOST_EVERY_S = 0.25


class TrackerService:
    """The I/O around `Tracker`."""

    def __init__(self, lab: Lab, bus: Bus, outputs: Outputs, timings: TimingLog, clock: Clock) -> None:
        self._tracker, self._bus, self._outputs, self._clock = Tracker(lab), bus, outputs, clock
        self._timings, self._reports = timings, TrackReports()
        self._reported_s: dict[str, float] = {}

    async def run(self) -> None:
        """Until cancelled."""
        async for received in self._bus.subscribe(DETECTIONS, REGISTRATIONS):
            message = received.message
            if isinstance(message, FrameDetections):
                await self._fuse(message)
            elif isinstance(message, Registration):
                self._outputs.register(message)

    async def look_for_lost(self) -> None:
        """Tells who was lost and found, until cancelled: what is lost sends no frames that would tell."""
        while True:
            await self._clock.sleep(_LOOK_FOR_LOST_EVERY_S)
            self._tracker.expire(self._clock.now_ns())
            for transition in self._tracker.take_transitions():
                self._reports.note(transition)
            for transition in self._reports.take_due(self._clock.monotonic_s()):
                await self._report_transition(transition)

    async def _fuse(self, frame: FrameDetections) -> None:
        wait_ms = (self._clock.now_ns() - frame.stamp_ns) * 1e-6
        if not -_AHEAD_S <= wait_ms * 1e-3 <= _OLDEST_S:
            if self._may_report(f"clock of {frame.camera}"):
                _logger.warning("ignored a frame of %s, stamped %.1f s ago", frame.camera, wait_ms * 1e-3)
            return
        start_s = self._clock.monotonic_s()
        poses = self._tracker.update(frame)
        tracked_s = self._clock.monotonic_s()
        self._outputs.send(poses)
        sent_s, sent_ns = self._clock.monotonic_s(), self._clock.now_ns()
        await self._outputs.publish(poses)
        published_s = self._clock.monotonic_s()
        self._timings.add(
            frame.stamp_ns,
            {
                "wait": wait_ms,
                "track": (tracked_s - start_s) * 1e3,
                "send": (sent_s - tracked_s) * 1e3,
                "publish": (published_s - sent_s) * 1e3,
                "total": (sent_ns - frame.stamp_ns) * 1e-6,
            },
        )
        for duplicate in self._tracker.take_duplicates():
            await self._report_duplicate(duplicate)

    async def _report_duplicate(self, duplicate: DuplicateTag) -> None:
        if self._may_report(duplicate.vehicle):
            _logger.warning("%s", duplicate)
            await self._tell(EventLevel.WARNING, "duplicate_tag", str(duplicate))

    async def _report_transition(self, transition: TrackTransition) -> None:
        level, kind = (EventLevel.INFO, "vehicle_found") if transition.tracked else (EventLevel.WARNING, "vehicle_lost")
        _logger.info("%s", sentence(transition))
        await self._tell(level, kind, sentence(transition))

    async def _tell(self, level: EventLevel, kind: str, text: str) -> None:
        event = Event(stamp_ns=self._clock.now_ns(), level=level, source="tracker", kind=kind, text=text)
        with contextlib.suppress(BusUnavailableError):  # it stands in the log
            await self._bus.publish(EVENTS, LAB_INSTANCE, event)

    def _may_report(self, what: str) -> bool:
        now_s = self._clock.monotonic_s()
        if now_s - self._reported_s.get(what, -_REPORT_EVERY_S) < _REPORT_EVERY_S:
            return False
        self._reported_s[what] = now_s
        return True


async def serve(lab: Lab, settings: Settings, clock: Clock) -> None:
    """Runs the tracker until SIGTERM or SIGINT."""
    bus = Bus.connect(settings.redis_url, clock)
    noted = {"outputs": lab.outputs.model_dump_json()}
    try:
        with (
            UdpSender(clock) as sender,
            open_timing_log(settings, clock, lab.name, "tracker", TRACKER_STAGES, noted=noted) as timings,
        ):
            outputs = outputs_of(lab, bus, sender, clock, settings.udp_key)
            service = TrackerService(lab, bus, outputs, timings, clock)
            await run_until_signal(service.run(), service.look_for_lost(), outputs.run(clock))
    finally:
        await bus.close()


def main(arguments: Sequence[str] | None = None) -> None:
    """Settings come from the environment (`protocol.settings`), outputs and their rates from the lab description."""
    parser = argparse.ArgumentParser(prog="python -m localization.tracker", description=__doc__)
    parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(message)s")
    settings = Settings.from_environment()
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from None
    _logger.info("%s, outputs %s", settings, lab.outputs)
    asyncio.run(serve(lab, settings, SystemClock()))


if __name__ == "__main__":
    main()
