"""Flat pictures that lie on things: tags, roofs of vehicles, the slats of a pallet.

A tag's picture is the one of AprilTag's own library: OpenCV's drawing turned by 180 degrees (design, "The lab description").
Seen from above its x axis runs from the left-bottom to the right-bottom corner and its y axis up; `size_m` is the side of the
black border's outer edge, and one bit of white paper surrounds it.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from protocol.lab import VehicleSpec

UInt8 = NDArray[np.uint8]
Colour = tuple[int, int, int]
"""Blue, green, red: the brightness under full light at exposure 1."""

PAPER: Colour = (226, 229, 230)
INK: Colour = (24, 24, 25)
TAG_BITS = 8
"""A tag36h11 with its black border is this many bits wide."""
PLATE_BITS = TAG_BITS + 2
"""The same with the white paper around it."""
_TEXELS_PER_BIT = 20
_DICTIONARIES = {"tag36h11": cv2.aruco.DICT_APRILTAG_36h11}
_GREY_WEIGHTS = (0.114, 0.587, 0.299)
ROOFS: dict[str, Colour] = {
    "wifibot": (118, 112, 106),
    "turtlebot": (62, 58, 57),
    "agv": (60, 132, 214),
    "freke": (96, 128, 84),
}


@dataclass(frozen=True, slots=True, eq=False)
class Texture:
    """`pixels` (rows, columns, channels + 1), uint8: colour times coverage, then coverage. The centre of the texel in row r
    and column c lies at (x0 + c * texel_m, y0 + r * texel_m) of the thing that it lies on."""

    pixels: UInt8
    x0: float
    y0: float
    texel_m: float

    def prefiltered(self, sigma_m: float) -> "Texture":
        """Blurred as a sensor does that samples it with a Gaussian of this size."""
        blurred = cv2.GaussianBlur(self.pixels, (0, 0), max(0.05, sigma_m / self.texel_m))
        return Texture(np.asarray(blurred, dtype=np.uint8), self.x0, self.y0, self.texel_m)


def tone(colour: Colour, channels: int) -> tuple[int, ...]:
    """The colour for an image of 3 channels (BGR) or 1 (grey)."""
    if channels == 3:
        return colour
    return (round(sum(weight * part for weight, part in zip(_GREY_WEIGHTS, colour, strict=True))),)


def tag_texture(family: str, tag_id: int, size_m: float, channels: int) -> Texture:
    """A tag on its paper, in its own frame. ValueError for a family that cannot be drawn or an id that it lacks."""
    if family not in _DICTIONARIES:
        raise ValueError(f"tags of family {family!r} cannot be drawn (known: {', '.join(_DICTIONARIES)})")
    dictionary = cv2.aruco.getPredefinedDictionary(_DICTIONARIES[family])
    if not 0 <= tag_id < len(dictionary.bytesList):
        raise ValueError(f"{family} has no tag {tag_id}, its ids are 0 to {len(dictionary.bytesList) - 1}")
    opencv_drawing = np.asarray(dictionary.generateImageMarker(tag_id, TAG_BITS, borderBits=1))
    white = np.ones((PLATE_BITS, PLATE_BITS), dtype=bool)
    white[1:-1, 1:-1] = np.rot90(opencv_drawing, 2) > 127
    upwards = np.flipud(white)  # row 0 is the lowest y
    cells = np.kron(upwards, np.ones((_TEXELS_PER_BIT, _TEXELS_PER_BIT), dtype=bool))
    pixels = np.where(cells[..., None], (*tone(PAPER, channels), 255), (*tone(INK, channels), 255)).astype(np.uint8)
    texel = size_m / TAG_BITS / _TEXELS_PER_BIT
    edge = -size_m * PLATE_BITS / TAG_BITS / 2.0 + texel / 2.0
    # A transparent rim lets the paper's edge fade over half a texel on either side, wherever it is sampled.
    rim = cv2.copyMakeBorder(pixels, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=(0, 0, 0, 0))
    return Texture(np.asarray(rim, dtype=np.uint8), edge - texel, edge - texel, texel)


def roof_texture(spec: VehicleSpec, channels: int) -> Texture:
    """A vehicle's roof with its tag, seen from the rotation centre."""
    tag = tag_texture(spec.tag.family, spec.tag.id, spec.tag.size_m, channels)
    mount = spec.tag.pose_on_vehicle()
    half = spec.tag.size_m * PLATE_BITS / TAG_BITS / 2.0
    plate = mount.apply([[-half, -half], [half, -half], [half, half], [-half, half]])
    footprint = np.array(spec.footprint)
    low, high = np.vstack((plate, footprint)).min(axis=0), np.vstack((plate, footprint)).max(axis=0)
    texel = tag.texel_m
    pad = 8 * texel
    x0, y0 = float(low[0] - pad), float(low[1] - pad)
    columns, rows = (math.ceil((float(high[i] - low[i]) + 2 * pad) / texel) for i in (0, 1))
    image = np.zeros((rows, columns, channels + 1), dtype=np.uint8)
    colour = ROOFS[spec.kind]
    _fill(image, footprint, (x0, y0, texel), _shaded(colour, 0.8, channels))
    _fill(image, footprint * 0.95, (x0, y0, texel), _shaded(colour, 1.0, channels))
    front, half_width = float(footprint[:, 0].max()), float(footprint[:, 1].max()) * 0.35
    bar = np.array([[0.88, -1.0], [0.95, -1.0], [0.95, 1.0], [0.88, 1.0]]) * (front, half_width)
    _fill(image, bar, (x0, y0, texel), _shaded((90, 190, 235), 1.0, channels))
    return Texture(_laid_on(image, (x0, y0, texel), tag, mount), x0, y0, texel)


def slats_texture(length_m: float, width_m: float, channels: int) -> Texture:
    """The top of a pallet: boards along its length with gaps between."""
    texel = 0.002
    pad = 8 * texel
    x0, y0 = -length_m / 2 - pad, -width_m / 2 - pad
    rows, columns = (math.ceil((side + 2 * pad) / texel) for side in (width_m, length_m))
    image = np.zeros((rows, columns, channels + 1), dtype=np.uint8)
    whole = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (length_m / 2, width_m / 2)
    _fill(image, whole, (x0, y0, texel), _shaded((40, 62, 84), 1.0, channels))
    boards = 5
    pitch = width_m / boards
    for index in range(boards):
        low = -width_m / 2 + index * pitch
        board = np.array(
            [
                [-length_m / 2, low],
                [length_m / 2, low],
                [length_m / 2, low + 0.72 * pitch],
                [-length_m / 2, low + 0.72 * pitch],
            ]
        )
        _fill(image, board, (x0, y0, texel), _shaded((96, 144, 182), 0.9 + 0.05 * (index % 3), channels))
    return Texture(image, x0, y0, texel)


def _shaded(colour: Colour, light: float, channels: int) -> tuple[int, ...]:
    return (*(min(255, round(part * light)) for part in tone(colour, channels)), 255)


def _fill(image: UInt8, polygon: NDArray[np.float64], grid: tuple[float, float, float], value: tuple[int, ...]) -> None:
    x0, y0, texel = grid
    corners = (polygon - (x0, y0)) / texel * 16.0
    cv2.fillPoly(image, [np.rint(corners).astype(np.int32)], value, shift=4)


def _laid_on(image: UInt8, grid: tuple[float, float, float], tag: Texture, mount: SE2) -> UInt8:
    """`tag` at `mount` over the image."""
    x0, y0, texel = grid
    to_tag = mount.inverse()
    c, s = math.cos(to_tag.yaw), math.sin(to_tag.yaw)
    turn = np.array([[c, -s], [s, c]])
    offset = (turn @ (x0, y0) + (to_tag.x, to_tag.y) - (tag.x0, tag.y0)) / tag.texel_m
    matrix = np.column_stack((turn * texel / tag.texel_m, offset))
    size = (image.shape[1], image.shape[0])
    laid = cv2.warpAffine(tag.pixels, matrix, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    rest = (255 - laid[..., -1:].astype(np.uint16)) * image // 255
    return (rest + laid).clip(0, 255).astype(np.uint8)
