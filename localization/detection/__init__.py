"""Tags in an image: AprilTag's own detector behind three strategies, the whole frame, the whole frame spread over many frames,
and windows around predicted tags (spec localization, "The pipeline of 2025", steps 2 and 3)."""

from localization.detection.detector import TagDetector, decimation_for
from localization.detection.full import FullSearch
from localization.detection.motion import MotionSearch
from localization.detection.observation import (
    Box,
    Image,
    TagGuess,
    TagObservation,
    TagSearch,
    is_whole,
    to_grey,
    without_duplicates,
)
from localization.detection.spread import SpreadSearch, SpreadStep
from localization.detection.tiles import TagSizes, Tiling, tiling
from localization.detection.windowed import WindowedSearch

__all__ = [
    "Box",
    "FullSearch",
    "Image",
    "MotionSearch",
    "SpreadSearch",
    "SpreadStep",
    "TagDetector",
    "TagGuess",
    "TagObservation",
    "TagSearch",
    "TagSizes",
    "Tiling",
    "WindowedSearch",
    "decimation_for",
    "is_whole",
    "tiling",
    "to_grey",
    "without_duplicates",
]
