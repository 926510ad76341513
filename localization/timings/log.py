"""The timing log of one process: `add` costs a few microseconds; a thread of its own writes once a second."""

import logging
import os
import platform
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from localization.timings.writer import SegmentWriter, Timing, prune
from protocol.clock import Clock
from protocol.settings import Settings
from protocol.timings import Header, run_name, timings_folder
from protocol.version import project_version

_logger = logging.getLogger(__name__)

WRITE_EVERY_S = 1.0
_MOST_WAITING = 60_000
"""Frames that wait for a disk that does not take them; more are not remembered."""
_MOST_RUNS, _MOST_BYTES = 50, 500_000_000


class TimingLog:
    """Remembers the stage timings of frames; without a writer it forgets them."""

    def __init__(self, writer: SegmentWriter | None) -> None:
        self._writer = writer
        self._waiting: list[Timing] = []
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._failing = False
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begins to write once a second."""
        if self._writer is not None:
            self._thread = threading.Thread(target=self._write_for_ever, name="timings", daemon=True)
            self._thread.start()

    def add(self, stamp_ns: int, stages_ms: Mapping[str, float]) -> None:
        """A frame's capture time and its stages in milliseconds; the mapping must not change afterwards. Never waits for a
        disk, never raises."""
        if self._writer is None:
            return
        with self._lock:
            if len(self._waiting) < _MOST_WAITING:
                self._waiting.append(Timing(stamp_ns, stages_ms))

    def write(self) -> None:
        """Writes what waits. What cannot be written is lost, and the first of such failures logged."""
        with self._lock:
            taken, self._waiting = self._waiting, []
        if self._writer is None or not taken:
            return
        try:
            self._writer.write(taken)
        except OSError as error:
            if not self._failing:
                _logger.warning("stage timings are not kept: %s", error)
            self._failing = True
        else:
            self._failing = False

    def close(self) -> None:
        """Writes what waits and ends."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join(2 * WRITE_EVERY_S)
        self.write()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _write_for_ever(self) -> None:
        while not self._ended.wait(WRITE_EVERY_S):
            self.write()


def open_timing_log(
    settings: Settings,
    clock: Clock,
    lab: str,
    kind: str,
    stages: Sequence[str],
    instance: str = "",
    noted: Mapping[str, str | int | float | bool | None] | None = None,
) -> TimingLog:
    """The log of a process in its run: `kind` and `instance` (a camera's id) make its name, `stages` are those it expects
    (others are taken too), `noted` are settings on which its times depend. With an allowance of zero (LILLIPUT_TIMINGS_MB)
    nothing is kept. Old runs are removed."""
    if settings.timings_mb <= 0:
        return TimingLog(None)
    now_ns = clock.now_ns()
    run = settings.run or run_name(now_ns)
    folder = timings_folder(settings.state)
    try:
        prune(folder, run, _MOST_RUNS, _MOST_BYTES)
    except OSError as error:  # another process prunes at the same time, or may not
        _logger.debug("old timings stay: %s", error)
    header = Header(
        run=run,
        run_start_ns=now_ns,
        start_ns=now_ns,
        process=f"{kind}-{instance}" if instance else kind,
        kind=kind,
        lab=lab,
        machine=f"{platform.node()}, {platform.machine()}, {_processor()}",
        version=project_version(),
        stages=tuple(stages),
        settings=dict(noted or {}),
    )
    return TimingLog(SegmentWriter(folder / run, header, round(settings.timings_mb * 1e6), clock.now_ns))


def _processor() -> str:
    """The processor's model where the system tells it (Linux), and how many there are."""
    count = os.cpu_count() or 1
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{count} x {names[0]}" if names else f"{count} processors"
