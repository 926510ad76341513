"""Records cameras as they run. A disk that stutters costs no frame, one that is too slow loses some instead of falling behind."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from launcher.recorder.folder import RecordingFolder
from localization.sources import LiveSource, open_source
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
    cameras leave their frames. Ends early with the first error, LauncherError, and when it is interrupted."""
    start_s = clock.monotonic_s()
    sources = {spec.id: open_source(spec, state, clock) for spec in specs}
    try:
        ended = threading.Event()
        with ThreadPoolExecutor(max(1, len(sources))) as threads:
            pending = [threads.submit(_record, camera, source, folder, ended) for camera, source in sources.items()]
            try:
                # Until the time is over, or a writer has failed: none ends otherwise.
                while (past_s := clock.monotonic_s() - start_s) < seconds and not any(task.done() for task in pending):
                    on_progress(past_s / seconds)
                    clock.wait(min(_TIMEOUT_S, seconds - past_s))
            finally:
                ended.set()
            on_progress(1.0)
            for task in pending:
                task.result()
        return {camera: _count(source) for camera, source in sources.items()}
    finally:
        for source in sources.values():
            source.close()


def _record(camera: str, source: LiveSource, folder: RecordingFolder, ended: threading.Event) -> None:
    while not ended.is_set():
        frame = source.oldest(_TIMEOUT_S)
        if frame is not None:
            folder.add_picture(camera, frame.stamp_ns, frame.pixels)


def _count(source: LiveSource) -> LiveCount:
    state = source.state
    return LiveCount(state.skipped, state.broken, state.error)
