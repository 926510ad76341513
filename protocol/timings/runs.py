"""Runs: the folders in which the segments of one start of the system lie together, read back as one."""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from protocol.errors import DecodeError
from protocol.settings import is_run_name
from protocol.timings.segment import SUFFIX, Header, Segment, read_header, read_segment

_SLACK_S = 60.0


@dataclass(frozen=True, slots=True, eq=False)
class ProcessTimings:
    """All that a process wrote in a run, oldest first: `stamps_ns` (n,) int64, `ms` (n, k) float32 with a column per stage."""

    process: str
    kind: str
    stages: tuple[str, ...]
    stamps_ns: NDArray[np.int64]
    ms: NDArray[np.float32]

    def since(self, stamp_ns: int) -> "ProcessTimings":
        """The same with the records from that time on."""
        recent = self.stamps_ns >= stamp_ns
        return replace(self, stamps_ns=self.stamps_ns[recent], ms=self.ms[recent])


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A run's timings. `header` is that of the process that began first."""

    name: str
    header: Header
    processes: tuple[ProcessTimings, ...]

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of processes, in the order of their names."""
        return tuple(sorted({process.kind for process in self.processes}))

    def stages(self, kind: str) -> tuple[str, ...]:
        """The stages of a kind of process, in the order in which they were written."""
        return tuple(dict.fromkeys(stage for each in self.processes if each.kind == kind for stage in each.stages))

    def values(self, kind: str, stage: str) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Stamps (n,) and milliseconds (n,) of a stage over all processes of a kind, NaN left out."""
        stamps: list[NDArray[np.int64]] = []
        values: list[NDArray[np.float32]] = []
        for process in self.processes:
            if process.kind == kind and stage in process.stages:
                column = process.ms[:, process.stages.index(stage)]
                known = ~np.isnan(column)
                stamps.append(process.stamps_ns[known])
                values.append(column[known])
        if not stamps:
            return np.empty(0, np.int64), np.empty(0, np.float32)
        return np.concatenate(stamps), np.concatenate(values)

    @property
    def span_ns(self) -> tuple[int, int]:
        """The oldest and the newest stamp; zeros for a run without records."""
        stamped = [process.stamps_ns for process in self.processes if process.stamps_ns.size]
        if not stamped:
            return 0, 0
        return min(int(stamps.min()) for stamps in stamped), max(int(stamps.max()) for stamps in stamped)

    def last(self, seconds: float) -> "Run":
        """The same with the last seconds before its newest record alone."""
        since_ns = self.span_ns[1] - round(seconds * 1e9)
        return replace(self, processes=tuple(process.since(since_ns) for process in self.processes))


@dataclass(frozen=True, slots=True)
class RunSummary:
    """What is known of a run without reading its records; `newest_ns` is when it was last written to."""

    name: str
    header: Header
    processes: tuple[str, ...]
    size_bytes: int
    newest_ns: int


def timings_folder(state: Path) -> Path:
    """Where the runs of a state folder lie."""
    return state / "timings"


def run_name(start_ns: int) -> str:
    """The name of a run that began then: UTC, so that names sort by time."""
    return datetime.fromtimestamp(start_ns * 1e-9, UTC).strftime("%Y%m%dT%H%M%SZ")


def list_runs(folder: Path) -> list[RunSummary]:
    """The runs in a folder, oldest first; none when it does not exist. What is no run, or is damaged, is left out."""
    found = (summarize(path) for path in _folders(folder))
    return sorted((run for run in found if run is not None), key=lambda run: (run.header.run_start_ns, run.name))


def summarize(folder: Path) -> RunSummary | None:
    """One run in short; None when it has no segment that can be read."""
    headers: list[Header] = []
    size, newest_ns = 0, 0
    for path in _segments(folder):
        try:
            status = path.stat()
            headers.append(read_header(path))
        except (OSError, DecodeError):
            continue  # dropped for a newer one in this moment, or cut short by a crash
        size, newest_ns = size + status.st_size, max(newest_ns, status.st_mtime_ns)
    if not headers:
        return None
    processes = tuple(sorted({header.process for header in headers}))
    first = min(headers, key=lambda header: (header.run_start_ns, header.start_ns))
    return RunSummary(folder.name, first, processes, size, newest_ns)


def read_run(folder: Path, last_s: float | None = None) -> Run:
    """A run with its records, or those of its last so many seconds. DecodeError when none can be read."""
    found = _run(folder.name, _segments(folder), last_s, where=str(folder))
    return found if last_s is None else found.last(last_s)


def read_files(paths: Sequence[Path]) -> Run:
    """Segments given by name, as one run. DecodeError when one is no timing log; OSError when one cannot be read."""
    return _joined(paths[0].stem, [read_segment(path) for path in paths])


def _run(name: str, paths: Iterable[Path], last_s: float | None, where: str) -> Run:
    segments: list[Segment] = []
    problem = "no timing log in it"
    for path in _written_lately(paths, last_s):
        try:
            segments.append(read_segment(path))
        except FileNotFoundError:
            continue  # dropped for a newer one in this moment
        except (OSError, DecodeError) as error:
            problem = str(error)
    if not segments:
        raise DecodeError(f"{where}: {problem}")
    return _joined(name, segments)


def _written_lately(paths: Iterable[Path], last_s: float | None) -> list[Path]:
    """Without the segments that were finished too long before the run's end to hold any record of its last seconds: a run may
    be large. Records are written within a second; a minute more does no harm."""
    written: dict[Path, int] = {}
    for path in paths:
        with suppress(FileNotFoundError):  # dropped for a newer one in this moment
            written[path] = path.stat().st_mtime_ns
    if last_s is None or not written:
        return list(written)
    since_ns = max(written.values()) - round((last_s + _SLACK_S) * 1e9)
    return [path for path, stamp_ns in written.items() if stamp_ns >= since_ns]


def _joined(name: str, segments: Sequence[Segment]) -> Run:
    ordered = sorted(segments, key=lambda segment: segment.header.start_ns)
    by_process: dict[str, list[Segment]] = {}
    for segment in ordered:
        by_process.setdefault(segment.header.process, []).append(segment)
    processes = tuple(_process(by_process[process]) for process in sorted(by_process))
    first = min((s.header for s in segments), key=lambda header: (header.run_start_ns, header.start_ns))
    return Run(name, first, processes)


def _process(segments: Sequence[Segment]) -> ProcessTimings:
    stages = tuple(dict.fromkeys(stage for segment in segments for stage in segment.header.stages))
    stamps = np.concatenate([segment.stamps_ns for segment in segments])
    ms = np.full((stamps.size, len(stages)), np.nan, np.float32)
    row = 0
    for segment in segments:
        columns = [stages.index(stage) for stage in segment.header.stages]
        ms[row : row + len(segment.ms), columns] = segment.ms
        row += len(segment.ms)
    header = segments[0].header
    return ProcessTimings(header.process, header.kind, stages, stamps, ms)


def _folders(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    return sorted(path for path in folder.iterdir() if path.is_dir() and is_run_name(path.name))


def _segments(folder: Path) -> list[Path]:
    return sorted(folder.glob(f"*{SUFFIX}")) if folder.is_dir() else []
