"""The file of stage timings: a header that describes itself, then records of one size.

| bytes | content |
|---|---|
| 8 | `LPTIMES1` |
| 4 | length of the header, little-endian |
| n | the header as JSON (`Header`) |
| 8 + 4 k | per record: the frame's capture time (int64), its milliseconds in each of the header's k stages (float32) |

Capture times are nanoseconds since the epoch; a stage that a frame did not have is NaN; records are little-endian. A
process that dies leaves an incomplete record at the end, which is ignored. A process writes several segments,
`PROCESS.000001.timings` and so on, so that the oldest can be dropped.
"""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from protocol.errors import DecodeError

MAGIC = b"LPTIMES1"
SUFFIX = ".timings"
_PREFIX = struct.Struct("<8sI")
_LARGEST_HEADER = 1 << 20

StageName = Annotated[str, msgspec.Meta(pattern="^[a-z][a-z0-9_]{0,31}$")]


class Header(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a segment is of. `kind` is the process's row of the process table (`camera`), `process` its own name
    (`camera-cam0`); `run_start_ns` is when the run began, `start_ns` when this segment did; `settings` is what the process was
    told that its times depend on."""

    run: str
    run_start_ns: int
    start_ns: int
    process: str
    kind: str
    lab: str
    machine: str
    version: str
    stages: tuple[StageName, ...]
    settings: dict[str, str | int | float | bool | None] = {}


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A segment as read: `stamps_ns` has shape (n,), int64, `ms` (n, k), float32, a column per stage of the header."""

    header: Header
    stamps_ns: NDArray[np.int64]
    ms: NDArray[np.float32]


def segment_name(process: str, number: int) -> str:
    """The file name of a process's segment; later ones sort behind earlier ones."""
    return f"{process}.{number:06d}{SUFFIX}"


def encode_header(header: Header) -> bytes:
    """What a segment begins with."""
    content = msgspec.json.encode(header)
    return _PREFIX.pack(MAGIC, len(content)) + content


def record_struct(stages: int) -> struct.Struct:
    """Packs a record: the stamp, then the milliseconds of so many stages."""
    return struct.Struct(f"<q{stages}f")


def read_header(path: Path) -> Header:
    """The header alone. DecodeError, naming the file, when it is none; OSError when it cannot be read."""
    with path.open("rb") as file:
        prefix = file.read(_PREFIX.size)
        announced = _PREFIX.unpack(prefix)[1] if len(prefix) == _PREFIX.size else 0
        return _header(path, prefix + file.read(min(announced, _LARGEST_HEADER)))[0]


def read_segment(path: Path) -> Segment:
    """A segment with all its whole records. DecodeError, naming the file, when it is none; OSError when it cannot be read."""
    data = path.read_bytes()
    header, offset = _header(path, data)
    dtype: Any = np.dtype([("stamp_ns", "<i8"), ("ms", "<f4", (len(header.stages),))])
    count = (len(data) - offset) // dtype.itemsize
    records: Any = np.frombuffer(data, dtype, count, offset)
    return Segment(header, records["stamp_ns"].astype(np.int64), records["ms"].astype(np.float32))


def _header(path: Path, data: bytes) -> tuple[Header, int]:
    if len(data) < _PREFIX.size:
        raise DecodeError(f"{path}: {len(data)} bytes are no timing log")
    magic, size = _PREFIX.unpack_from(data)
    if magic != MAGIC:
        raise DecodeError(f"{path}: begins with {magic!r}, a timing log with {MAGIC!r}")
    if size > _LARGEST_HEADER or len(data) < _PREFIX.size + size:
        raise DecodeError(f"{path}: its header of {size} bytes is not whole")
    try:
        header = msgspec.json.decode(data[_PREFIX.size : _PREFIX.size + size], type=Header)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise DecodeError(f"{path}: damaged header: {error}") from error
    return header, _PREFIX.size + size
