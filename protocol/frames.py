"""Frames in shared memory, from a simulated camera to the process that reads it: newest wins, the writer never waits.

A ring of slots in one mapped file (GulliView 2024, 3.1.1: single producer, single consumer). Each slot has a sequence
number that is odd while it is written; a reader copies the newest slot and takes the copy only if the number was even and
stayed the same. The file is made beside its name and renamed, so that a reader sees a whole ring or none; a new writer
makes a new file, and readers that hear nothing look whether theirs was replaced.
"""

import contextlib
import mmap
import os
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from protocol.errors import DecodeError

_MAGIC = b"LPFRAME1"
_HEADER = struct.Struct("<8sIIII")
_NEWEST = struct.Struct("<Q")
_NEWEST_OFFSET = 32
_SLOT = struct.Struct("<QQQ")
_SLOT_SIZE = 64
_PAGE = 4096
_SLOTS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """An image with its capture time (ns since the epoch) and number. `pixels` has shape (height, width) for grey or
    (height, width, 3) for BGR, dtype uint8. `decode_ms` is how long it took to make them from what the camera sent, 0 where
    nothing was to be decoded or the time is not known."""

    number: int
    stamp_ns: int
    pixels: NDArray[np.uint8]
    decode_ms: float = 0.0


class FrameWriter:
    """The producing side; one per ring."""

    def __init__(self, path: Path, width: int, height: int, *, color: bool = False) -> None:
        self._shape = (height, width, 3) if color else (height, width)
        self._bytes = width * height * (3 if color else 1)
        self._path = path
        self._number = 0
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        draft = path.with_name(f"{path.name}.{os.getpid()}.new")
        size = _PAGE + _SLOTS * _stride(self._bytes)
        with draft.open("w+b") as file:
            file.truncate(size)
            self._map = mmap.mmap(file.fileno(), size)
            self._identity = _identity(os.fstat(file.fileno()))
        _HEADER.pack_into(self._map, 0, _MAGIC, width, height, 3 if color else 1, _SLOTS)
        _NEWEST.pack_into(self._map, _NEWEST_OFFSET, 0)
        draft.replace(path)

    def write(self, pixels: NDArray[np.uint8], stamp_ns: int) -> int:
        """Copies the image into the oldest slot and returns its number (from 1). ValueError for another shape or dtype."""
        if pixels.shape != self._shape or pixels.dtype != np.uint8:
            raise ValueError(f"the ring holds uint8 {self._shape}, got {pixels.dtype} {pixels.shape}")
        number = self._number + 1
        offset, data = _slot_offsets(number % _SLOTS, self._bytes)
        _SLOT.pack_into(self._map, offset, 2 * number - 1, stamp_ns, number)
        np.frombuffer(self._map, np.uint8, self._bytes, data).reshape(self._shape)[...] = pixels
        _SLOT.pack_into(self._map, offset, 2 * number, stamp_ns, number)
        _NEWEST.pack_into(self._map, _NEWEST_OFFSET, number)
        self._number = number
        return number

    def close(self) -> None:
        """Removes the ring, unless a newer writer's has taken its place; readers keep what they have mapped."""
        with contextlib.suppress(FileNotFoundError):
            if _identity(self._path.stat()) == self._identity:
                self._path.unlink()
        self._map.close()


class FrameReader:
    """The consuming side. FileNotFoundError when there is no ring yet, DecodeError when the file is none."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with path.open("rb") as file:
            status = os.fstat(file.fileno())
            if status.st_size < _PAGE:
                raise DecodeError(f"{path} is not a frame ring: {status.st_size} bytes")
            self._map = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        magic, width, height, channels, slots = _HEADER.unpack_from(self._map, 0)
        self._bytes = int(width) * int(height) * int(channels)
        if magic != _MAGIC or slots != _SLOTS or status.st_size < _PAGE + _SLOTS * _stride(self._bytes):
            raise DecodeError(f"{path} is not a frame ring of this version")
        self._identity = _identity(status)
        self._shape = (height, width, 3) if channels == 3 else (height, width)
        self._seen = 0

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the images: (height, width) or (height, width, 3)."""
        return self._shape

    def newest(self) -> Frame | None:
        """The newest frame if it was not returned before, else None. The pixels are a copy."""
        for _ in range(_SLOTS):
            (number,) = _NEWEST.unpack_from(self._map, _NEWEST_OFFSET)
            if number <= self._seen:
                return None
            offset, data = _slot_offsets(number % _SLOTS, self._bytes)
            before, stamp_ns, _ = _SLOT.unpack_from(self._map, offset)
            if before != 2 * number:
                continue  # overwritten meanwhile: a newer one exists
            pixels = np.frombuffer(self._map, np.uint8, self._bytes, data).reshape(self._shape).copy()
            after, _, _ = _SLOT.unpack_from(self._map, offset)
            if after == before:
                self._seen = int(number)
                return Frame(int(number), int(stamp_ns), pixels)
        return None

    def replaced(self) -> bool:
        """Whether the file was removed or replaced by another writer's."""
        try:
            status = self._path.stat()
        except FileNotFoundError:
            return True
        return _identity(status) != self._identity

    def close(self) -> None:
        self._map.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _identity(status: os.stat_result) -> tuple[int, int]:
    return status.st_dev, status.st_ino


def _stride(data_bytes: int) -> int:
    return -(-(_SLOT_SIZE + data_bytes) // _PAGE) * _PAGE


def _slot_offsets(slot: int, data_bytes: int) -> tuple[int, int]:
    start = _PAGE + slot * _stride(data_bytes)
    return start, start + _SLOT_SIZE
