"""The stitched floor picture: everything in its place, north up, seams faded."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from mapping.stitching import LONGEST_SIDE_PX, FloorPicture, stitch
from mapping.tiles import FloorTile
from protocol.errors import DecodeError


def tile(bounds: tuple[float, float, float, float], picture: NDArray[np.uint8]) -> FloorTile:
    low_x, low_y, high_x, high_y = bounds
    _, jpeg = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])
    return FloorTile(bounds, ((low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y)), jpeg.tobytes())


def grey(level: int, height: int, width: int) -> NDArray[np.uint8]:
    return np.full((height, width), level, np.uint8)


def pixels_of(picture: FloorPicture) -> NDArray[np.uint8]:
    decoded = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert decoded is not None
    assert decoded.shape == (picture.height, picture.width)
    return np.asarray(decoded, dtype=np.uint8)


def level_at(picture: FloorPicture, x: float, y: float) -> float:
    low_x, low_y, high_x, high_y = picture.bounds
    column = int((x - low_x) / (high_x - low_x) * picture.width)
    row = int((high_y - y) / (high_y - low_y) * picture.height)
    return float(pixels_of(picture)[row, column])


def test_a_mark_is_where_it_was_and_north_is_up() -> None:
    image = grey(50, 200, 300)
    image[0:20, 0:20] = 250  # north-west corner of the tile
    picture = stitch([tile((1.0, 1.0, 4.0, 3.0), image)], (0.0, 0.0, 5.0, 4.0))
    assert picture is not None
    assert picture.bounds == pytest.approx((0.0, 0.0, 5.0, 4.0))
    assert level_at(picture, 1.1, 2.9) == pytest.approx(250, abs=8)
    assert level_at(picture, 1.5, 2.9) == pytest.approx(50, abs=8)
    assert level_at(picture, 1.1, 1.1) == pytest.approx(50, abs=8)
    # The mark's centre of mass, to a centimetre.
    rows, columns = np.nonzero(pixels_of(picture) > 180)
    assert columns.mean() * 0.01 + 0.005 == pytest.approx(1.1, abs=0.01)
    assert 4.0 - (rows.mean() * 0.01 + 0.005) == pytest.approx(2.9, abs=0.01)


def test_overlapping_tiles_fade_into_each_other() -> None:
    left = tile((0.0, 0.0, 3.0, 2.0), grey(60, 200, 300))
    right = tile((2.0, 0.0, 5.0, 2.0), grey(120, 200, 300))
    picture = stitch([left, right], (0.0, 0.0, 5.0, 2.0))
    assert picture is not None
    across = pixels_of(picture)[100].astype(float)
    assert across[100] == pytest.approx(60, abs=3)
    assert across[400] == pytest.approx(120, abs=3)
    assert abs(np.diff(across)).max() < 8
    assert across[250] == pytest.approx(90, abs=6)


def test_a_large_hall_stays_small() -> None:
    picture = stitch([tile((0.0, 0.0, 3.0, 2.0), grey(60, 200, 300))], (0.0, 0.0, 60.0, 25.0))
    assert picture is not None
    assert max(picture.width, picture.height) <= LONGEST_SIDE_PX
    assert level_at(picture, 1.5, 1.0) == pytest.approx(60, abs=4)
    assert level_at(picture, 50.0, 20.0) == pytest.approx(40, abs=3)


def test_only_what_was_seen_is_shown() -> None:
    bounds = (0.0, 0.0, 2.0, 2.0)
    triangle = FloorTile(bounds, ((0.0, 0.0), (2.0, 0.0), (0.0, 2.0)), tile(bounds, grey(200, 200, 200)).jpeg)
    picture = stitch([triangle], bounds)
    assert picture is not None
    assert level_at(picture, 0.5, 0.5) == pytest.approx(200, abs=5)
    assert level_at(picture, 1.8, 1.8) == pytest.approx(40, abs=5)


def test_a_tile_without_a_picture_is_left_out() -> None:
    good = tile((0.0, 0.0, 1.0, 1.0), grey(90, 100, 100))
    for jpeg in (b"", b"no JPEG at all"):
        broken = FloorTile(good.bounds, good.outline, jpeg)
        assert stitch([broken], good.bounds) is None
        both = stitch([broken, good], good.bounds)
        assert both is not None
        assert level_at(both, 0.5, 0.5) == pytest.approx(90, abs=3)
    assert stitch([], good.bounds) is None


numbers = st.floats(-1e6, 1e6)


@given(
    st.tuples(numbers, numbers, st.floats(0.1, 100), st.floats(0.1, 100)),
    st.lists(st.tuples(numbers, numbers), min_size=3, max_size=20),
    st.binary(max_size=50),
)
def test_a_tile_survives_redis(
    place: tuple[float, float, float, float], outline: list[tuple[float, float]], jpeg: bytes
) -> None:
    x, y, width, height = place
    packed = FloorTile((x, y, x + width, y + height), tuple(outline), jpeg)
    assert FloorTile.unpack(packed.pack()) == packed


@given(st.binary(max_size=80))
def test_garbage_is_no_tile(data: bytes) -> None:
    with pytest.raises(DecodeError):
        FloorTile.unpack(data)


@pytest.mark.parametrize("bounds", [(0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 1.0)])
def test_a_tile_over_nothing_is_refused(bounds: tuple[float, float, float, float]) -> None:
    with pytest.raises(DecodeError):
        FloorTile.unpack(FloorTile(bounds, ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), b"").pack())
