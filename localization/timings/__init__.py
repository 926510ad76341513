"""Keeps the stage timings of every frame in files (protocol, `timings`) without ever holding a frame up."""

from localization.timings.log import TimingLog, open_timing_log
from localization.timings.writer import SegmentWriter, prune

__all__ = ["SegmentWriter", "TimingLog", "open_timing_log", "prune"]
