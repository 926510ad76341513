"""The full search: the whole frame at once (spec localization, "The pipeline of 2025", step 3)."""

from collections.abc import Sequence

from localization.detection.detector import COARSE_PX, TagDetector, decimation_for
from localization.detection.observation import Image, TagGuess, TagObservation, to_grey, without_duplicates


class FullSearch:
    """Looks everywhere. `side_px` is the smallest tag that must be found, in pixels."""

    def __init__(self, detector: TagDetector, side_px: float) -> None:
        self._detector = detector
        self.side_px = side_px

    def find(self, image: Image, guesses: Sequence[TagGuess] = ()) -> list[TagObservation]:
        side_px = min([self.side_px, *(guess.side_px for guess in guesses)])
        tags = self._detector.detect(to_grey(image), decimation_for(side_px, COARSE_PX))
        return without_duplicates(tags)
