"""How a frame is cut into tiles for the search that is spread over frames.

Tiles overlap by one tag, so that each tag lies wholly in one of them. The rim, where vehicles drive in, has tiles of its own.
Tags of very different sizes are looked for at levels of their own, each as coarse as its smallest tag allows.
"""

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

from localization.detection.detector import COARSE_PX, decimation_for
from localization.detection.observation import Box

_NS_PER_PIXEL = 50.0
"""Of the detector without decimation, measured; with decimation d about this over d^2."""
_TILE_MS = 1.8
_TURNED = math.sqrt(2.0) * 10 / 8
"""A tag with its white border, turned by 45 degrees, reaches so far, relative to its side."""
_RIM_FOOTPRINTS = 2.0
"""The rim's width: a tag that drives in stays in it for one length of itself."""


@dataclass(frozen=True, slots=True)
class TagSizes:
    """From which to which side length a kind of tag appears in the picture, pixels."""

    least_px: float
    most_px: float


@dataclass(frozen=True, slots=True)
class Level:
    """One decimation with the smallest and the largest tag that are looked for at it, pixels."""

    decimation: float
    least_px: float
    most_px: float

    @property
    def footprint_px(self) -> int:
        """How far a tag reaches at most."""
        return math.ceil(_TURNED * self.most_px) + 2

    def nominal_ms(self, pixels: int) -> float:
        """What so many pixels take on the machine that this was measured on."""
        return pixels * _NS_PER_PIXEL / self.decimation**2 * 1e-6


@dataclass(frozen=True, slots=True)
class Tile:
    """A part of the picture to be searched at a level."""

    level: Level
    box: Box

    @property
    def nominal_ms(self) -> float:
        return self.level.nominal_ms(self.box.pixels)


@dataclass(frozen=True, slots=True)
class Tiling:
    """The tiles of a picture, those of the rim and those inside of it, and the levels that they are of."""

    levels: tuple[Level, ...]
    rim: tuple[Tile, ...]
    inside: tuple[Tile, ...]

    @property
    def nominal_ms(self) -> float:
        """What all of them take together."""
        return sum(tile.nominal_ms for tile in self.rim + self.inside)


def tiling(width: int, height: int, kinds: Iterable[TagSizes]) -> Tiling:
    """Tiles in which every tag of these kinds that the picture shows wholly lies wholly, at a level that finds it.

    Levels are merged into finer ones when that is cheaper.
    """
    levels: dict[float, Level] = {}
    for kind in kinds:
        level = Level(decimation_for(kind.least_px, COARSE_PX), kind.least_px, kind.most_px)
        known = levels.get(level.decimation, level)
        levels[level.decimation] = _merged(known, level)
    chosen: list[Tiling] = []
    for level in sorted(levels.values(), key=lambda level: level.decimation):
        apart = _tiles(level, width, height)
        if chosen:
            together = _tiles(_merged(chosen[-1].levels[0], level), width, height)
            if together.nominal_ms <= chosen[-1].nominal_ms + apart.nominal_ms:
                chosen[-1] = together
                continue
        chosen.append(apart)
    return Tiling(
        tuple(itertools.chain.from_iterable(tiles.levels for tiles in chosen)),
        tuple(itertools.chain.from_iterable(tiles.rim for tiles in chosen)),
        tuple(itertools.chain.from_iterable(tiles.inside for tiles in chosen)),
    )


def _merged(fine: Level, other: Level) -> Level:
    """The tags of both at the decimation of the first."""
    return Level(fine.decimation, min(fine.least_px, other.least_px), max(fine.most_px, other.most_px))


def _tiles(level: Level, width: int, height: int) -> Tiling:
    reach = level.footprint_px
    rim = math.ceil(_RIM_FOOTPRINTS * reach)
    most = _TILE_MS / level.nominal_ms(1)
    inner = Box(rim - reach, rim - reach, width - rim + reach, height - rim + reach)
    if min(inner.right - inner.left, inner.bottom - inner.top) <= reach:
        return Tiling((level,), _grid(level, Box(0, 0, width, height), most), ())
    strips = (
        Box(0, 0, width, rim),
        Box(0, height - rim, width, height),
        Box(0, inner.top, rim, inner.bottom),
        Box(width - rim, inner.top, width, inner.bottom),
    )
    outer = itertools.chain.from_iterable(_grid(level, strip, most) for strip in strips)
    return Tiling((level,), tuple(outer), _grid(level, inner, most))


def _grid(level: Level, box: Box, most_pixels: float) -> tuple[Tile, ...]:
    """The box cut into tiles of at most so many pixels where the overlap allows it, about square."""
    width, height = box.right - box.left, box.bottom - box.top
    reach = level.footprint_px
    side = max(2.0 * reach, math.sqrt(most_pixels))
    # What a narrow box saves in one direction may be spent in the other.
    columns = _cut(box.left, box.right, reach, max(side, most_pixels / min(side, height)))
    rows = _cut(box.top, box.bottom, reach, max(side, most_pixels / min(side, width)))
    return tuple(Tile(level, Box(x0, y0, x1, y1)) for y0, y1 in rows for x0, x1 in columns)


def _cut(low: int, high: int, overlap: int, longest: float) -> list[tuple[int, int]]:
    """Equal pieces from `low` to `high` that overlap by `overlap`."""
    length = high - low
    if length <= longest:
        return [(low, high)]
    pieces = math.ceil((length - overlap) / (longest - overlap))
    step = (length - overlap) / pieces
    return [(low + math.floor(i * step), min(high, low + math.ceil((i + 1) * step) + overlap)) for i in range(pieces)]
