"""The full search spread over frames: a few tiles each, the rim every other time, so that no frame pays for the whole
(spec localization, "What the reports ask for next": newcomers at the frame borders)."""

from dataclasses import dataclass

from localization.detection.detector import TagDetector
from localization.detection.looks import equalised
from localization.detection.observation import Image, TagObservation, is_whole_in, to_grey, without_duplicates
from localization.detection.tiles import Tile, Tiling
from protocol.clock import Clock

_SLOWEST, _FASTEST = 20.0, 0.5
"""How many times the nominal time of a tile is believed. The lower bound also limits a frame's tiles where a clock stands
still."""
_EQUALISED_PART = 0.65
"""Of the smallest tag's side: parts that an equalised tile consists of."""
_LEARNING = 0.1
"""Weight of the newest tile's time."""


@dataclass(frozen=True, slots=True)
class SpreadStep:
    """The tags seen in this frame's tiles; in the frame that ends a round, all that were seen since its beginning, whenever
    that was (None in other frames)."""

    tags: list[TagObservation]
    round_tags: list[TagObservation] | None


class SpreadSearch:
    """Searches tile after tile. Time is what is shared out: a frame takes tiles while its allowance, and what earlier frames
    left of theirs, lasts for the next one by the time that tiles took so far. In every other round tiles are equalised first: so
    tags on which a shadow's edge lies are found too."""

    def __init__(self, detector: TagDetector, clock: Clock, budget_ms: float) -> None:
        if budget_ms <= 0:
            raise ValueError(f"a search with {budget_ms} ms per frame finds nothing")
        self._detector, self._clock, self._budget_ms = detector, clock, budget_ms
        self._pace = 1.0
        self._credit_ms = 0.0
        self._tiling: Tiling | None = None
        self._rim: tuple[Tile, ...] = ()
        self._inside: tuple[Tile, ...] = ()
        self._round_ms = 0.0
        self._equalise = False
        self._rim_done = self._inside_done = 0
        self._next_rim = 0
        self._round_tags: list[TagObservation] = []

    def aim(self, tiling: Tiling) -> None:
        """Searches these tiles; others than before begin a new round."""
        if tiling is self._tiling:
            return
        self._tiling = tiling
        self._rim, self._inside = tiling.rim, tiling.inside
        self._round_ms = tiling.nominal_ms
        self._next_rim = 0
        self.restart()

    def restart(self) -> None:
        """Begins a new round: nothing that was seen so far counts for it."""
        self._rim_done = self._inside_done = 0
        self._round_tags = []

    def step(self, image: Image, since_s: float, round_s: float) -> SpreadStep:
        """Some tiles of this frame, `since_s` after the one before, at a pace that makes a round take `round_s` (0: as fast as
        the budget per frame allows)."""
        tile = self._upcoming()
        if tile is None:
            return SpreadStep([], None)
        wanted_ms = self._budget_ms
        if round_s > 0:
            wanted_ms = min(wanted_ms, self._round_ms * self._pace * max(0.0, since_s) / round_s)
        # A machine for which one tile exceeds the budget saves up for it.
        self._credit_ms = min(self._credit_ms + wanted_ms, max(self._budget_ms, self._expected_ms(tile)))
        tags: list[TagObservation] = []
        finished: list[TagObservation] | None = None
        while finished is None and self._credit_ms >= self._expected_ms(tile):
            tags += self._search(image, tile)
            finished = self._count(tile)
            tile = self._upcoming() or tile
        return SpreadStep(without_duplicates(tags), finished)

    def _search(self, image: Image, tile: Tile) -> list[TagObservation]:
        start_s = self._clock.monotonic_s()
        box = tile.box
        grey = to_grey(box.of(image))
        if self._equalise:
            grey = equalised(grey, _EQUALISED_PART * tile.level.least_px)
        seen = self._detector.detect(grey, tile.level.decimation, (box.left, box.top))
        whole = [tag for tag in seen if is_whole_in(tag, box)]  # what is cut off lies wholly in the next tile
        self._round_tags += whole
        took = (self._clock.monotonic_s() - start_s) * 1e3 / tile.nominal_ms
        took = min(_SLOWEST, max(_FASTEST, took))
        self._credit_ms -= took * tile.nominal_ms
        self._pace += _LEARNING * (took - self._pace)
        return whole

    def _upcoming(self) -> Tile | None:
        """Rim and inside take turns; the rim goes on from the start when it is through before the inside is."""
        rim_turn = self._rim_done <= self._inside_done or self._inside_done >= len(self._inside)
        if self._rim and rim_turn:
            return self._rim[self._next_rim]
        return self._inside[self._inside_done] if self._inside_done < len(self._inside) else None

    def _count(self, tile: Tile) -> list[TagObservation] | None:
        """Notes a tile as done; at the end of a round its tags."""
        if self._rim and tile is self._rim[self._next_rim]:
            self._next_rim = (self._next_rim + 1) % len(self._rim)
            self._rim_done += 1
        else:
            self._inside_done += 1
        if self._rim_done < len(self._rim) or self._inside_done < len(self._inside):
            return None
        finished = without_duplicates(self._round_tags)
        self._equalise = not self._equalise
        self.restart()
        return finished

    def _expected_ms(self, tile: Tile) -> float:
        return self._pace * tile.nominal_ms
