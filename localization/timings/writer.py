"""Writes one process's timings of a run in segments of limited size, the oldest of which are dropped; and drops old runs."""

import math
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import msgspec

from protocol.timings import SUFFIX, Header, encode_header, record_struct, segment_name

SEGMENTS = 8
"""A segment may have this fraction of a process's allowance: an eighth of the past goes at a time."""
_MOST_FILES = 100
"""A process that is started again and again leaves many small segments."""


@dataclass(frozen=True, slots=True)
class Timing:
    """A frame's capture time (ns since the epoch) and the milliseconds of its stages."""

    stamp_ns: int
    stages_ms: Mapping[str, float]


class SegmentWriter:
    """Appends records to the newest segment in `folder`; begins another when that is full, or when a frame has a stage that its
    header does not know. `cap_bytes` limits all segments of the process together. Raises OSError as the file system does, and
    may be used again afterwards."""

    def __init__(self, folder: Path, header: Header, cap_bytes: int, now_ns: Callable[[], int]) -> None:
        self._folder, self._header, self._now_ns = folder, header, now_ns
        self._cap_bytes, self._segment_bytes = cap_bytes, cap_bytes // SEGMENTS
        self._path: Path | None = None
        self._size = 0

    def write(self, timings: Sequence[Timing]) -> None:
        """All of them, in this order."""
        known = self._header.stages
        unknown = [stage for stage in dict.fromkeys(s for t in timings for s in t.stages_ms) if stage not in known]
        if unknown:
            self._header = msgspec.structs.replace(self._header, stages=(*known, *unknown))
            self._path = None
        record = record_struct(len(self._header.stages))
        data = b"".join(
            record.pack(t.stamp_ns, *(t.stages_ms.get(stage, math.nan) for stage in self._header.stages))
            for t in timings
        )
        at_once = max(1, self._segment_bytes // 2 // record.size) * record.size
        for start in range(0, len(data), at_once):
            self._append(data[start : start + at_once])

    def _append(self, data: bytes) -> None:
        if self._path is None or self._size + len(data) > self._segment_bytes:
            self._begin()
        assert self._path is not None
        path, self._path = self._path, None  # unless the file can be put in order, another segment follows a failure
        try:
            with path.open("ab") as file:
                file.write(data)
        except OSError:
            with suppress(OSError):
                os.truncate(path, self._size)  # a part of it may have been written
                self._path = path
            raise
        self._path, self._size = path, self._size + len(data)

    def _begin(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        present = sorted(self._folder.glob(f"{self._header.process}.??????{SUFFIX}"))
        self._make_room(present)
        number = int(present[-1].name.split(".")[-2]) + 1 if present else 1
        path = self._folder / segment_name(self._header.process, number)
        header = encode_header(msgspec.structs.replace(self._header, start_ns=self._now_ns()))
        try:
            path.write_bytes(header)
        except OSError:
            path.unlink(
                missing_ok=True
            )  # else a full disk, tried again and again, pushes out the past with empty files
            raise
        self._path, self._size = path, len(header)

    def _make_room(self, present: Sequence[Path]) -> None:
        sizes = [path.stat().st_size for path in present]
        total, files = sum(sizes), len(present)
        for path, size in zip(present, sizes, strict=True):
            if total + self._segment_bytes <= self._cap_bytes and files < _MOST_FILES:
                return
            path.unlink()
            total, files = total - size, files - 1


def prune(folder: Path, keep: str, most_runs: int, most_bytes: int) -> None:
    """Removes the runs that were written to longest ago, until no more than so many, of so many bytes together, are left; never
    the one called `keep`."""
    runs: list[tuple[int, int, Path]] = []
    for run in folder.iterdir() if folder.is_dir() else ():
        files = [path.stat() for path in run.glob(f"*{SUFFIX}")]
        if files:
            runs.append((max(file.st_mtime_ns for file in files), sum(file.st_size for file in files), run))
    total = 0
    for number, (_, size, run) in enumerate(sorted(runs, reverse=True), 1):
        total += size
        if run.name != keep and (number > most_runs or total > most_bytes):
            shutil.rmtree(run, ignore_errors=True)
