"""The tracker process: `python -m localization.tracker`. Detections of all cameras in; poses out as the lab's `outputs` say.

UDP first, then the bus: a slow Redis must not age the robots' poses.
"""

import argparse
import asyncio
import contextlib
import logging
from collections.abc import Sequence

from localization.outputs import Outputs, UdpSender, outputs_of
from localization.tracking import DuplicateTag, Tracker
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


class TrackerService:
    """The I/O around `Tracker`."""

    def __init__(self, lab: Lab, bus: Bus, outputs: Outputs, clock: Clock) -> None:
        self._tracker, self._bus, self._outputs, self._clock = Tracker(lab), bus, outputs, clock
        self._reported_s: dict[str, float] = {}

    async def run(self) -> None:
        """Until cancelled."""
        async for received in self._bus.subscribe(DETECTIONS, REGISTRATIONS):
            message = received.message
            if isinstance(message, FrameDetections):
                await self._fuse(message)
            elif isinstance(message, Registration):
                self._outputs.register(message)

    async def _fuse(self, frame: FrameDetections) -> None:
        age_s = (self._clock.now_ns() - frame.stamp_ns) * 1e-9
        if not -_AHEAD_S <= age_s <= _OLDEST_S:
            if self._may_report(f"clock of {frame.camera}"):
                _logger.warning("ignored a frame of %s, stamped %.1f s ago", frame.camera, age_s)
            return
        poses = self._tracker.update(frame)
        self._outputs.send(poses)
        await self._outputs.publish(poses)
        for duplicate in self._tracker.take_duplicates():
            await self._report(duplicate)

    async def _report(self, duplicate: DuplicateTag) -> None:
        if not self._may_report(duplicate.vehicle):
            return
        _logger.warning("%s", duplicate)
        event = Event(
            stamp_ns=self._clock.now_ns(),
            level=EventLevel.WARNING,
            source="tracker",
            kind="duplicate_tag",
            text=str(duplicate),
        )
        with contextlib.suppress(BusUnavailableError):  # it stands in the log, and comes again
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
    try:
        with UdpSender(clock) as sender:
            outputs = outputs_of(lab, bus, sender, clock, settings.udp_key)
            await run_until_signal(TrackerService(lab, bus, outputs, clock).run(), outputs.run(clock))
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
