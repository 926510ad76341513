"""The windowed search: only around where each tag should be (spec localization, "The pipeline of 2025", step 2)."""

import math
from collections.abc import Sequence

from localization.detection.detector import TagDetector
from localization.detection.looks import Look, looks_for
from localization.detection.observation import (
    Box,
    Image,
    TagGuess,
    TagObservation,
    is_whole_in,
    to_grey,
    without_duplicates,
)

_MOST_LAST_RESORTS = 4
"""So many tags per frame get them: with the light off, all of them would."""
_MOST_TREATED_PX = 400 * 400
"""Larger windows are only looked at as they are."""


class WindowedSearch:
    """Looks only around each guess: coarsely first, then more finely, in the end with treated pictures.

    Without `last_resorts` only the usual looks are taken: for tags that are often hidden, and need not be found at once.
    """

    def __init__(self, detector: TagDetector, *, last_resorts: bool = True) -> None:
        self._detector = detector
        self._most_last_resorts = _MOST_LAST_RESORTS if last_resorts else 0

    def find(self, image: Image, guesses: Sequence[TagGuess] = ()) -> list[TagObservation]:
        found: list[TagObservation] = []
        missed: list[tuple[TagGuess, Box, tuple[Look, ...]]] = []
        for guess in guesses:
            if any(tag.key == guess.key and _hits(tag, guess) for tag in found):
                continue  # the neighbour's window had it already
            box = _window(guess, image.shape[1], image.shape[0])
            if box is None:
                continue
            usual, last = looks_for(guess.side_px)
            tags = self._look(image, box, guess, usual)
            found += tags
            if not any(tag.key == guess.key for tag in tags):
                missed.append((guess, box, last))
        for guess, box, last in missed[: self._most_last_resorts]:
            found += self._look(image, box, guess, last)
        return without_duplicates(found)

    def _look(self, image: Image, box: Box, guess: TagGuess, looks: tuple[Look, ...]) -> list[TagObservation]:
        """What the looks show, up to the one that shows the guessed tag."""
        found: list[TagObservation] = []
        grey = to_grey(box.of(image))
        for look in looks:
            plain = look == Look(look.treatment.PLAIN, look.decimation)
            if not plain and box.pixels > _MOST_TREATED_PX:
                continue
            tags = self._detector.detect(look.prepare(grey), look.decimation, (box.left, box.top), look.scale)
            # A treated window may only show what was looked for: it is easier to misread.
            tags = [tag for tag in tags if is_whole_in(tag, box) and (plain or tag.key == guess.key)]
            found += tags
            if any(tag.key == guess.key for tag in tags):
                break
        return found


def _hits(tag: TagObservation, guess: TagGuess) -> bool:
    x, y = tag.centre
    return math.hypot(x - guess.x, y - guess.y) <= guess.side_px + guess.margin_px


def _window(guess: TagGuess, width: int, height: int) -> Box | None:
    """The tag turned at will, its white border and the margin; None when no whole tag fits into what the frame has of it."""
    reach = guess.side_px * (math.sqrt(0.5) + 0.25) + guess.margin_px
    left, right = max(0, math.floor(guess.x - reach)), min(width, math.ceil(guess.x + reach) + 1)
    top, bottom = max(0, math.floor(guess.y - reach)), min(height, math.ceil(guess.y + reach) + 1)
    if min(right - left, bottom - top) < guess.side_px:
        return None
    return Box(left, top, right, bottom)
