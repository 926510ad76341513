"""Keeps the stage timings of every frame in files (protocol, `timings`) without ever holding a frame up."""

from localization.timings.log import TimingLog, open_timing_log
from localization.timings.stages import CAMERA_STAGES, TRACKER_STAGES, camera_stages
from localization.timings.writer import SegmentWriter, prune

__all__ = [
    "CAMERA_STAGES",
    "TRACKER_STAGES",
    "SegmentWriter",
    "TimingLog",
    "camera_stages",
    "open_timing_log",
    "prune",
]
