"""A camera's picture of its part of the floor, as it is kept in Redis (`keys.FLOOR_TILES`).

Layout: 4 bytes length of the header (big-endian), the header as JSON (bounds, outline), the JPEG.
"""

import math
import struct
from typing import Self

import msgspec
from msgspec import Struct

from protocol.errors import DecodeError

_LENGTH = struct.Struct(">I")


class _Header(Struct, frozen=True, forbid_unknown_fields=True):
    bounds: tuple[float, float, float, float]
    outline: tuple[tuple[float, float], ...]


class FloorTile(Struct, frozen=True):
    """A JPEG of the floor seen from above, map +y up, over `bounds` (min x, min y, max x, max y, metres). Only what lies
    within the polygon `outline` (metres) was seen."""

    bounds: tuple[float, float, float, float]
    outline: tuple[tuple[float, float], ...]
    jpeg: bytes

    def pack(self) -> bytes:
        """The bytes for Redis."""
        header = msgspec.json.encode(_Header(self.bounds, self.outline))
        return _LENGTH.pack(len(header)) + header + self.jpeg

    @classmethod
    def unpack(cls, data: bytes) -> Self:
        """DecodeError when the bytes are no tile; the JPEG itself is not looked at."""
        if len(data) < _LENGTH.size:
            raise DecodeError(f"a floor tile of {len(data)} bytes")
        (length,) = _LENGTH.unpack_from(data)
        try:
            header = msgspec.json.decode(data[_LENGTH.size : _LENGTH.size + length], type=_Header)
        except (msgspec.MsgspecError, UnicodeDecodeError) as error:
            raise DecodeError(f"not a floor tile: {error}") from error
        low_x, low_y, high_x, high_y = header.bounds
        if not (all(map(math.isfinite, header.bounds)) and low_x < high_x and low_y < high_y):
            raise DecodeError(f"a floor tile over {header.bounds}")
        if len(header.outline) < 3 or not all(math.isfinite(v) for corner in header.outline for v in corner):
            raise DecodeError("a floor tile's outline has three or more finite corners")
        return cls(header.bounds, header.outline, data[_LENGTH.size + length :])
