"""Frames of several recorded cameras in the order of their capture times, decoded ahead by other threads.

An instant is a run of neighbouring frames, at most one per camera; its frames can be searched side by side, since none is
needed to know where to look in another. Memory holds one instant and one frame per camera.
"""

from collections.abc import Generator, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from localization.offline.frames import FrameReader, Grey, RecordedCamera
from localization.sources import BrokenFrameError
from protocol.frames import Frame


@dataclass(frozen=True, slots=True, eq=False)
class RecordedFrame:
    """A frame of a camera; `frame` is None for one that cannot be decoded, and `problem` says why."""

    camera: str
    stamp_ns: int
    frame: Frame | None
    problem: str = ""


def instants(cameras: Sequence[RecordedCamera], executor: Executor) -> Generator[list[RecordedFrame], None, None]:
    """All frames, in the order of capture time (then of `cameras`). RecordingError for a frame of another size than the lab
    file's and for a video that does not open."""
    window_ns = _window_ns(cameras)
    readers = [_AheadReader(camera, executor) for camera in cameras]
    try:
        while True:
            instant = _next_instant(readers, window_ns)
            if not instant:
                return
            yield [frame for frame in instant if frame is not None]
    finally:
        for reader in readers:
            reader.close()


class _AheadReader:
    """Decodes the next frame while the one before is being searched."""

    def __init__(self, camera: RecordedCamera, executor: Executor) -> None:
        self._id, self._executor = camera.spec.id, executor
        self._reader: FrameReader = camera.open()
        self._number = 0
        self._ahead: Future[Grey | None] | None = None
        self.stamp_ns: int | None = None
        self._request()

    def take(self) -> tuple[int, int, "Future[Grey | None]"]:
        """Stamp, number and picture of the next frame; the one after it is being decoded from then on."""
        assert self.stamp_ns is not None and self._ahead is not None
        taken = self.stamp_ns, self._number, self._ahead
        self._number += 1
        self._request(after=self._ahead)
        return taken

    def frame(self, stamp_ns: int, number: int, picture: "Future[Grey | None]") -> RecordedFrame | None:
        """The frame once it is decoded; None when the video ended before it."""
        try:
            pixels = picture.result()
        except BrokenFrameError as error:
            return RecordedFrame(self._id, stamp_ns, None, str(error))
        return None if pixels is None else RecordedFrame(self._id, stamp_ns, Frame(number, stamp_ns, pixels))

    def close(self) -> None:
        if self._ahead is not None and not self._ahead.cancel():
            self._ahead.exception()
        self._reader.close()

    def _request(self, after: "Future[Grey | None] | None" = None) -> None:
        """A reader serves one thread at a time, so the frame before must be there."""
        if after is not None:
            after.exception()
        self.stamp_ns = self._reader.next_ns
        self._ahead = None if self.stamp_ns is None else self._executor.submit(self._reader.read)


def _next_instant(readers: Sequence[_AheadReader], window_ns: int) -> list[RecordedFrame | None]:
    """The frames from the earliest one on, until the window closes or a camera's turn would come twice: equal stamps never
    fall into two instants."""
    first_ns = min((reader.stamp_ns for reader in readers if reader.stamp_ns is not None), default=None)
    if first_ns is None:
        return []
    end_ns = first_ns + window_ns
    taken: list[tuple[_AheadReader, int, int, Future[Grey | None]]] = []
    while True:
        due = [reader for reader in readers if reader.stamp_ns is not None and reader.stamp_ns <= end_ns]
        if not due:
            break
        reader = min(due, key=lambda reader: reader.stamp_ns or 0)
        taken.append((reader, *reader.take()))
        if reader.stamp_ns is not None:
            end_ns = min(end_ns, reader.stamp_ns - 1)
    return [reader.frame(stamp_ns, number, picture) for reader, stamp_ns, number, picture in taken]


def _window_ns(cameras: Sequence[RecordedCamera]) -> int:
    """Half of the shortest time between two frames of one camera, as it usually is."""
    medians = [
        float(np.median([after - before for before, after in pairwise(camera.stamps_ns)]))
        for camera in cameras
        if len(camera.stamps_ns) > 1
    ]
    return round(0.5 * min(medians)) if medians else 0
