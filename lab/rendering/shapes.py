"""The bodies of what moves: stacks of prisms with a picture on top, in the thing's own frame."""

import itertools
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lab.objects import PALLET_HEIGHT_M, PALLET_LENGTH_M, PALLET_WIDTH_M, PERSON_HEIGHT_M
from lab.rendering.textures import ROOFS, Colour, Texture, roof_texture, slats_texture
from protocol.lab import VehicleSpec

Ring = NDArray[np.float64]
_EDGE_PIECES = 3
"""Each edge of an outline is drawn in this many pieces, so that a lens may bend it."""


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """Between two outlines of (N, 3) points in metres, N the same, counter-clockwise seen from above.

    Side i is the one from corner `pieces` * i to the next such corner; `normals` (sides, 2) point outwards, `middles`
    (sides, 2) are the sides' midpoints. A `smooth` prism is round and convex: it is shaded as a whole.
    """

    bottom: Ring
    top: Ring
    pieces: int
    colour: Colour
    smooth: bool
    normals: NDArray[np.float64]
    middles: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """Prisms from the floor upwards and all their `corners` (M, 3), bottom and top ring of each in turn; the picture on the
    top one at `height_m`, the outline of the shadow on the floor (N, 2), and a radius around all of it."""

    prisms: tuple[Prism, ...]
    corners: NDArray[np.float64]
    height_m: float
    roof: Texture | None
    shadow: NDArray[np.float64]
    radius_m: float


def vehicle_shape(spec: VehicleSpec, channels: int) -> Shape:
    """Wheels, body and roof; the roof with the tag lies at the tag's height."""
    outline = _counter_clockwise(np.array(spec.footprint))
    height, colour = spec.tag.height_m, ROOFS[spec.kind]
    dark: Colour = (20, 20, 21)
    levels: list[tuple[float, float, float, Colour]]
    if spec.kind == "turtlebot":  # plates on poles
        levels = [(0.0, 0.18, 0.9, dark), (0.18, 0.32, 1.0, colour), (0.32, 0.85, 0.82, dark), (0.85, 1.0, 1.0, colour)]
    elif spec.kind == "wifibot":  # wheels, a flat chassis, a box that carries the roof
        levels = [
            (0.0, 0.35, 1.0, dark),
            (0.35, 0.55, 0.96, colour),
            (0.55, 0.93, 0.75, dark),
            (0.93, 1.0, 1.0, colour),
        ]
    else:
        levels = [(0.0, 0.2, 0.95, dark), (0.2, 1.0, 1.0, colour)]
    prisms = tuple(
        _prism(outline * scale, low * height, outline * scale, high * height, tint) for low, high, scale, tint in levels
    )
    roof = roof_texture(spec, channels)
    far = np.abs(
        [
            (roof.x0, roof.y0),
            (roof.x0 + roof.pixels.shape[1] * roof.texel_m, roof.y0 + roof.pixels.shape[0] * roof.texel_m),
        ]
    ).max(axis=0)
    return Shape(prisms, _corners(prisms), height, roof, outline * 1.12, float(np.hypot(*far)))


def pallet_shape(channels: int) -> Shape:
    half = np.array([PALLET_LENGTH_M / 2, PALLET_WIDTH_M / 2])
    outline = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    wood: Colour = (80, 122, 156)
    gap: Colour = (22, 34, 46)
    levels = ((0.0, 0.15, wood), (0.15, 0.75, gap), (0.75, 1.0, wood))
    prisms = tuple(
        _prism(outline, low * PALLET_HEIGHT_M, outline, high * PALLET_HEIGHT_M, tint) for low, high, tint in levels
    )
    roof = slats_texture(PALLET_LENGTH_M, PALLET_WIDTH_M, channels)
    return Shape(prisms, _corners(prisms), PALLET_HEIGHT_M, roof, outline * 1.08, float(np.hypot(*half)) * 1.1)


def person_shape(object_id: str) -> Shape:
    """Legs, torso, arms' width at the shoulders, neck and head; clothes differ by id."""
    rng = np.random.default_rng(zlib.crc32(object_id.encode()))
    legs, shirt = rng.integers(45, 110, size=3).tolist(), rng.integers(95, 210, size=3).tolist()
    skin: Colour = (128, 158, 196)
    hair: Colour = (34, 44, 58)
    # heights as shares of the whole, half axes along and across the heading in metres
    body: list[tuple[float, float, float, float, Colour]] = [
        (0.00, 0.14, 0.15, 0.0, (30, 30, 32)),
        (0.04, 0.11, 0.15, 0.0, (legs[0], legs[1], legs[2])),
        (0.50, 0.12, 0.17, 0.0, (shirt[0], shirt[1], shirt[2])),
        (0.70, 0.13, 0.20, 0.0, (shirt[0], shirt[1], shirt[2])),
        (0.80, 0.12, 0.23, 0.0, (shirt[0], shirt[1], shirt[2])),
        (0.845, 0.07, 0.08, 0.0, skin),
        (0.89, 0.10, 0.08, 0.01, skin),
        (0.92, 0.10, 0.08, 0.0, hair),
        (0.97, 0.09, 0.07, 0.0, hair),
        (1.00, 0.04, 0.03, 0.0, hair),
    ]
    angles = np.linspace(0.0, 2.0 * np.pi, 20, endpoint=False)
    rings = [
        (PERSON_HEIGHT_M * level, np.column_stack((along * np.cos(angles) + ahead, across * np.sin(angles))), colour)
        for level, along, across, ahead, colour in body
    ]
    prisms = tuple(
        _prism(low, z0, high, z1, colour, smooth=True) for (z0, low, colour), (z1, high, _) in itertools.pairwise(rings)
    )
    return Shape(prisms, _corners(prisms), PERSON_HEIGHT_M, None, rings[2][1] * 1.3, 0.3)


def _prism(bottom: Ring, z0: float, top: Ring, z1: float, colour: Colour, *, smooth: bool = False) -> Prism:
    along = np.roll(bottom, -1, axis=0) - bottom
    normals = np.column_stack((along[:, 1], -along[:, 0])) / np.maximum(1e-9, np.hypot(*along.T))[:, None]
    pieces = 1 if smooth else _EDGE_PIECES
    rings = (_at(_cut(bottom, pieces), z0), _at(_cut(top, pieces), z1))
    return Prism(*rings, pieces, colour, smooth, normals, bottom + along / 2.0)


def _corners(prisms: tuple[Prism, ...]) -> Ring:
    return np.vstack([ring for prism in prisms for ring in (prism.bottom, prism.top)])


def _cut(outline: Ring, pieces: int) -> Ring:
    """Each edge in that many pieces of the same length."""
    share = np.arange(pieces)[None, :, None] / pieces
    following = np.roll(outline, -1, axis=0)
    return (outline[:, None] * (1.0 - share) + following[:, None] * share).reshape(-1, 2)


def _at(outline: Ring, z: float) -> Ring:
    return np.column_stack((outline, np.full(len(outline), z)))


def _counter_clockwise(outline: Ring) -> Ring:
    x, y = outline[:, 0], outline[:, 1]
    area = float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    return outline if area > 0 else outline[::-1].copy()
