"""The floor tags of a calibrated camera, looked for one after the other in small windows: what shows that it moved, at a
fraction of the cost of full searches (spec localization; "drift watch")."""

import numpy as np

from localization.detection import Image, TagGuess, TagObservation, TagSearch
from localization.detection.observation import side_length
from localization.projection import CameraView
from localization.tags import KnownTags, TagKey

_ROUND_S = 0.25
"""How long it takes to see every floor tag once."""
_MOST_PER_FRAME = 2
_MARGIN_SIDES = 0.35
"""How far floor tags are looked for from where they should be, in their sides: for the usual 16 cm tag 5 cm. A camera that was
moved further sees none of them, and the full search does."""
_ENOUGH = 2
"""With fewer floor tags nothing can be said of the camera's place."""


class FloorWatch:
    """Goes round the floor tags that the camera should see."""

    def __init__(self, search: TagSearch, known: KnownTags) -> None:
        self._search, self._known = search, known
        self._view: CameraView | None = None
        self._guesses: list[TagGuess] = []
        self._credit = 0.0
        self._next = 0
        self._seen: dict[TagKey, TagObservation] = {}
        self.blind = False
        """Whether the last round saw too few floor tags where there should be enough: covered, dark, or the camera was moved
        far."""

    @property
    def expects(self) -> int:
        """How many floor tags the camera should see; with fewer than two there is nothing to watch."""
        return len(self._guesses)

    def aim(self, view: CameraView | None) -> None:
        """Watches through another calibration; None: there is none."""
        if view is self._view:
            return
        self._view = view
        self._guesses = [] if view is None else _guesses(view, self._known)
        self._next, self._seen, self.blind = 0, {}, False

    def look(self, image: Image) -> list[TagObservation]:
        """All expected floor tags at once."""
        return self._search.find(image, self._guesses)

    def step(self, image: Image, since_s: float) -> list[TagObservation] | None:
        """The next floor tags, `since_s` after the last frame; in the frame that ends a round, those seen in it."""
        if len(self._guesses) < _ENOUGH:
            return None
        wanted = len(self._guesses) * max(0.0, since_s) / _ROUND_S
        self._credit = min(self._credit + wanted, float(_MOST_PER_FRAME))
        while self._credit >= 1.0:
            self._credit -= 1.0
            guess = self._guesses[self._next]
            self._seen.update({tag.key: tag for tag in self._search.find(image, [guess]) if tag.key == guess.key})
            self._next += 1
            if self._next == len(self._guesses):
                seen, self._seen, self._next = list(self._seen.values()), {}, 0
                self.blind = len(seen) < _ENOUGH
                return seen
        return None


def _guesses(view: CameraView, known: KnownTags) -> list[TagGuess]:
    """One for every floor tag that lies wholly in the picture."""
    guesses: list[TagGuess] = []
    size = np.array([view.model.width, view.model.height])
    for key in sorted(known.floor):
        pixels, meant = view.project(np.column_stack([known.floor_corners(key), np.zeros(4)]))
        border_px = side_length(pixels) / 8
        inside = (pixels >= border_px) & (pixels <= size - 1 - border_px)
        if bool(meant.all()) and bool(inside.all()):
            x, y = pixels.mean(axis=0)
            side_px = side_length(pixels)
            guesses.append(TagGuess(key, float(x), float(y), side_px, _MARGIN_SIDES * side_px))
    return guesses
