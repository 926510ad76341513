"""From detections of many cameras to one track per vehicle."""

from localization.tracking.tracker import DuplicateTag, Tracker, TrackTransition

__all__ = ["DuplicateTag", "TrackTransition", "Tracker"]
