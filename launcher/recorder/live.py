"""Records cameras as they run: newest wins, so a disk that is too slow loses frames instead of falling behind."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from launcher.recorder.folder import RecordingFolder
from localization.sources import Source, open_source
from protocol.clock import Clock
from protocol.lab import CameraSpec

_TIMEOUT_S = 0.2


@dataclass(frozen=True, slots=True)
class LiveCount:
    """How one camera did: frames that were not written because a newer one came first, unusable ones, and what is wrong."""

    skipped: int
    broken: int
    error: str | None


def record_live(
    specs: Sequence[CameraSpec],
    state: Path,
    folder: RecordingFolder,
    clock: Clock,
    *,
    seconds: float,
    on_progress: Callable[[float], None] = lambda _: None,
) -> dict[str, LiveCount]:
    """Writes what the cameras' sources give for `seconds`; by camera. `state` is the running system's folder, in which simulated
    cameras leave their frames."""
    start_s = clock.monotonic_s()
    sources = {spec.id: open_source(spec, state, clock) for spec in specs}
    try:
        with ThreadPoolExecutor(max(1, len(sources))) as threads:
            pending = [
                threads.submit(_record, camera, source, folder, clock, start_s + seconds)
                for camera, source in sources.items()
            ]
            while not all(task.done() for task in pending):
                clock.wait(_TIMEOUT_S)
                on_progress(min(1.0, (clock.monotonic_s() - start_s) / seconds))
            for task in pending:
                task.result()
        return {camera: _count(source) for camera, source in sources.items()}
    finally:
        for source in sources.values():
            source.close()


def _record(camera: str, source: Source, folder: RecordingFolder, clock: Clock, end_s: float) -> None:
    while clock.monotonic_s() < end_s:
        frame = source.newest(_TIMEOUT_S)
        if frame is not None:
            folder.add_picture(camera, frame.stamp_ns, frame.pixels)


def _count(source: Source) -> LiveCount:
    state = source.state
    return LiveCount(state.skipped, state.broken, state.error)
