"""The cameras' floor pictures put together to one: the ground of the console's map and of the 3D view."""

import logging
from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mapping.tiles import FloorTile

_logger = logging.getLogger(__name__)
LONGEST_SIDE_PX = 1400
_FINEST_M = 0.01
_FEATHER_M = 0.4
"""Over this width one camera's picture fades into the next one's."""
_UNSEEN = 40.0
"""Grey level of floor that no camera sees."""
_JPEG_QUALITY = 85


@dataclass(frozen=True, slots=True)
class FloorPicture:
    """A JPEG, map +y up, and what it covers: min x, min y, max x, max y in metres."""

    jpeg: bytes
    bounds: tuple[float, float, float, float]
    width: int
    height: int


def stitch(tiles: Iterable[FloorTile], bounds: tuple[float, float, float, float]) -> FloorPicture | None:
    """One picture of the lab's bounds (metres), None when no tile has a picture. Where tiles overlap, each weighs by its
    distance from the border of what its camera sees, so that seams fade."""
    low_x, low_y, high_x, high_y = bounds
    pixel_m = max(_FINEST_M, (high_x - low_x) / LONGEST_SIDE_PX, (high_y - low_y) / LONGEST_SIDE_PX)
    width, height = max(1, int((high_x - low_x) / pixel_m + 0.5)), max(1, int((high_y - low_y) / pixel_m + 0.5))
    covered = (low_x, high_y - height * pixel_m, low_x + width * pixel_m, high_y)
    total = np.zeros((height, width, 3), np.float32)
    weights = np.zeros((height, width), np.float32)
    for tile in tiles:
        picture = cv2.imdecode(np.frombuffer(tile.jpeg, np.uint8), cv2.IMREAD_COLOR) if tile.jpeg else None
        if picture is None:
            _logger.warning("a floor tile over %s holds no picture", tile.bounds)
            continue
        weight = _weight(tile, covered, pixel_m, (height, width))
        if not weight.any():
            continue
        placed = _placed(np.asarray(picture, dtype=np.uint8), tile, covered, pixel_m, (width, height))
        total += placed * weight[..., None]
        weights += weight
    if not weights.any():
        return None
    seen = weights > 0
    total[seen] /= weights[seen][:, None]
    total[~seen] = _UNSEEN
    done, jpeg = cv2.imencode(
        ".jpg", np.clip(np.rint(total), 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    )
    return FloorPicture(jpeg.tobytes(), covered, width, height) if done else None


def _weight(
    tile: FloorTile, covered: tuple[float, float, float, float], pixel_m: float, shape: tuple[int, int]
) -> NDArray[np.float32]:
    """0 outside of what the camera sees, growing to 1 at the feather's width inside its border; shape (height, width)."""
    outline = np.array(tile.outline)
    corners = np.column_stack(((outline[:, 0] - covered[0]) / pixel_m, (covered[3] - outline[:, 1]) / pixel_m)) - 0.5
    # A frame of one pixel around: at the picture's own edge the tile's border is a border too.
    mask = np.zeros((shape[0] + 2, shape[1] + 2), np.uint8)
    cv2.fillPoly(mask, [np.rint(np.clip(corners, -1e6, 1e6) + 1).astype(np.int32)], 1)
    mask[[0, -1], :] = 0
    mask[:, [0, -1]] = 0
    distance = cv2.distanceTransform(mask, cv2.DIST_L2, 3)[1:-1, 1:-1]
    return np.minimum(distance * (pixel_m / _FEATHER_M), 1.0).astype(np.float32)


def _placed(
    picture: NDArray[np.uint8],
    tile: FloorTile,
    covered: tuple[float, float, float, float],
    pixel_m: float,
    size: tuple[int, int],
) -> NDArray[np.float32]:
    """The tile's picture where it belongs in the whole, shape (height, width, 3)."""
    low_x, low_y, high_x, high_y = tile.bounds
    scale_x, scale_y = picture.shape[1] / (high_x - low_x), picture.shape[0] / (high_y - low_y)
    if scale_x * pixel_m > 1.5:
        # Shrinking by much: averaged first, else fine lines break up.
        smaller = (
            max(1, round(picture.shape[1] / (scale_x * pixel_m))),
            max(1, round(picture.shape[0] / (scale_y * pixel_m))),
        )
        picture = np.asarray(cv2.resize(picture, smaller, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        scale_x, scale_y = picture.shape[1] / (high_x - low_x), picture.shape[0] / (high_y - low_y)
    # From a pixel of the whole to one of the tile; pixel centres lie half a pixel in.
    a, b = pixel_m * scale_x, pixel_m * scale_y
    whole_to_tile = np.array(
        [
            [a, 0.0, 0.5 * a + (covered[0] - low_x) * scale_x - 0.5],
            [0.0, b, 0.5 * b + (high_y - covered[3]) * scale_y - 0.5],
        ]
    )
    placed = cv2.warpAffine(
        picture, whole_to_tile, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE
    )
    return placed.astype(np.float32)
