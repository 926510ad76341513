"""Every kind of camera source keeps the same promises: rings, videos, folders of pictures, streams by URL."""

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from localization.sources import CaptureError, Patience, Source, open_source, recorded_capture
from protocol.clock import SystemClock
from protocol.frames import Frame, FrameWriter
from protocol.lab import CameraSpec, Intrinsics
from protocol.settings import frame_ring, frames_folder

WIDTH, HEIGHT, RATE_HZ = 64, 48, 50.0
PATIENCE = Patience(stall_s=0.3, abandon_s=1.0, first_retry_s=0.02, last_retry_s=0.1)
WITHIN_S = 10.0


def spec(source: str | int, color: bool = False) -> CameraSpec:
    intrinsics = Intrinsics(fx=60.0, fy=60.0, cx=32.0, cy=24.0)
    return CameraSpec(
        id="cam",
        area="a",
        source=source,
        width=WIDTH,
        height=HEIGHT,
        rate_hz=RATE_HZ,
        color=color,
        intrinsics=intrinsics,
    )


def grey(level: int, width: int = WIDTH, height: int = HEIGHT) -> NDArray[np.uint8]:
    return np.full((height, width), level, np.uint8)


def eventually(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + WITHIN_S
    while not condition():
        assert time.monotonic() < deadline, f"not within {WITHIN_S} s: {what}"
        time.sleep(0.005)


def next_frame(source: Source) -> Frame:
    deadline = time.monotonic() + WITHIN_S
    while time.monotonic() < deadline:
        frame = source.newest(0.1)
        if frame is not None:
            return frame
    raise AssertionError(f"no frame: {source.state}")


class Rig(ABC):
    """A camera of one kind, under the test's control."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @abstractmethod
    def name(self) -> str:
        """The lab description's `source`."""

    @abstractmethod
    def plug(self, width: int = WIDTH, height: int = HEIGHT) -> None:
        """From now on there are frames of that size."""

    @abstractmethod
    def unplug(self) -> None:
        """From now on there are none."""

    def clean(self) -> None:
        """Ends what runs."""
        self.unplug()


class RingRig(Rig):
    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def name(self) -> str:
        return "sim"

    def plug(self, width: int = WIDTH, height: int = HEIGHT) -> None:
        self._ended.clear()
        self._thread = threading.Thread(target=self._write, args=(width, height))
        self._thread.start()

    def _write(self, width: int, height: int) -> None:
        writer = FrameWriter(frame_ring(self.folder, "cam"), width, height)
        while not self._ended.wait(1 / RATE_HZ):
            writer.write(grey(100, width, height), time.time_ns())
        writer.close()

    def unplug(self) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def clean(self) -> None:
        super().clean()
        ring = frames_folder(self.folder)
        if ring.is_dir():
            ring.rmdir()


class FolderRig(Rig):
    def name(self) -> str:
        return str(self.folder / "pictures")

    def plug(self, width: int = WIDTH, height: int = HEIGHT) -> None:
        pictures = self.folder / "pictures"
        pictures.mkdir(exist_ok=True)
        for number in range(5):
            cv2.imwrite(str(pictures / f"{1000 + number * 20_000_000}.png"), grey(100, width, height))

    def unplug(self) -> None:
        for file in (self.folder / "pictures").glob("*.png"):
            file.unlink()


class VideoRig(Rig):
    def name(self) -> str:
        return str(self.folder / "video.avi")

    def plug(self, width: int = WIDTH, height: int = HEIGHT) -> None:
        self.unplug()
        codec = cv2.VideoWriter.fourcc(*"MJPG")
        draft = self.folder / "draft.avi"
        video = cv2.VideoWriter(str(draft), codec, RATE_HZ, (width, height))
        assert video.isOpened()
        for _ in range(10):
            video.write(np.full((height, width, 3), 100, np.uint8))
        video.release()
        draft.rename(self.name())

    def unplug(self) -> None:
        Path(self.name()).unlink(missing_ok=True)


class StreamRig(Rig):
    """A network camera: MJPEG over HTTP on loopback."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self._plugged = threading.Event()
        self._size = (WIDTH, HEIGHT)
        rig = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                rig.stream(self)

            def log_message(self, format: str, *args: object) -> None:  # noqa: A002  # the base class's name
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.02})
        self._thread.start()

    def stream(self, request: BaseHTTPRequestHandler) -> None:
        if not self._plugged.is_set():
            request.send_error(503)
            return
        request.send_response(200)
        request.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        request.end_headers()
        width, height = self._size
        _, jpeg = cv2.imencode(".jpg", grey(100, width, height))
        data = jpeg.tobytes()
        part = b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n%s\r\n" % (len(data), data)
        try:
            while self._plugged.is_set():
                request.wfile.write(part)
                time.sleep(1 / RATE_HZ)
        except OSError:
            pass  # the camera was closed

    def name(self) -> str:
        return f"http://127.0.0.1:{self._server.server_address[1]}/video"

    def plug(self, width: int = WIDTH, height: int = HEIGHT) -> None:
        self._size = (width, height)
        self._plugged.set()

    def unplug(self) -> None:
        self._plugged.clear()

    def clean(self) -> None:
        super().clean()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


@pytest.fixture(params=[RingRig, FolderRig, VideoRig, StreamRig])
def rig(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Rig]:
    made = request.param(tmp_path)
    yield made
    made.clean()


@pytest.fixture
def opened(rig: Rig) -> Iterator[Callable[..., Source]]:
    sources: list[Source] = []

    def opening(color: bool = False) -> Source:
        source = open_source(spec(rig.name(), color), rig.folder, SystemClock(), PATIENCE)
        sources.append(source)
        return source

    yield opening
    for source in sources:
        source.close()


def test_frames_arrive_grey_fresh_and_in_order(rig: Rig, opened: Callable[..., Source]) -> None:
    rig.plug()
    source = opened()
    frames = [next_frame(source) for _ in range(4)]
    now_ns = time.time_ns()
    for frame in frames:
        assert frame.pixels.shape == (HEIGHT, WIDTH)
        assert abs(int(frame.pixels.mean()) - 100) <= 3
        assert 0 <= now_ns - frame.stamp_ns < 5_000_000_000, "stamped with the time of capture"
    assert [frame.stamp_ns for frame in frames] == sorted({frame.stamp_ns for frame in frames})
    assert source.state.connected
    assert source.state.error is None
    assert source.state.received >= 4


def test_only_the_newest_frame_is_given(rig: Rig, opened: Callable[..., Source]) -> None:
    rig.plug()
    source = opened()
    eventually(lambda: source.state.received >= 4, "frames")
    received = source.state.received
    next_frame(source)
    assert source.state.skipped >= received - 1
    assert source.newest(0.0) is None or source.state.received > received


def test_a_camera_that_is_not_there_is_waited_for(rig: Rig, opened: Callable[..., Source]) -> None:
    source = opened()
    eventually(lambda: source.state.error not in (None, "no frame yet"), "an error")
    assert not source.state.connected
    assert source.newest(0.01) is None
    rig.plug()
    next_frame(source)
    assert source.state.error is None


def test_an_unplugged_camera_is_reported_and_found_again(rig: Rig, opened: Callable[..., Source]) -> None:
    rig.plug()
    source = opened()
    next_frame(source)
    rig.unplug()
    eventually(lambda: source.state.error is not None and not source.state.connected, "an error")
    source.newest(0.0)
    rig.plug()
    next_frame(source)
    eventually(lambda: source.state.error is None, "recovery")


def test_a_frame_of_another_size_is_reported_and_never_used(rig: Rig, opened: Callable[..., Source]) -> None:
    rig.plug(width=32, height=32)
    source = opened()
    expected = "a frame is 32 x 32, the lab description says 64 x 48; it is not used"
    eventually(lambda: source.state.error == expected, expected)
    eventually(lambda: source.state.broken >= 2, "broken frames are counted")
    assert source.newest(0.05) is None
    assert source.state.received == 0


def test_closing_is_quick(rig: Rig, opened: Callable[..., Source]) -> None:
    rig.plug()
    source = opened()
    next_frame(source)
    start = time.monotonic()
    source.close()
    assert time.monotonic() - start < 2.0
    source.newest(0.0)
    assert source.newest(0.2) is None


def test_a_recording_keeps_the_times_it_was_made_at(tmp_path: Path) -> None:
    FolderRig(tmp_path).plug()
    (tmp_path / "pictures/notes.txt").write_text("not a picture")
    (tmp_path / "pictures/cover.png").write_bytes(b"not named by a time")
    capture = recorded_capture(tmp_path / "pictures")
    stamps = [frame.stamp_ns for frame in iter_capture(capture.read)]
    assert stamps == [1000 + number * 20_000_000 for number in range(5)]
    VideoRig(tmp_path).plug()
    (tmp_path / "video.stamps").write_text("\n".join(str(7_000 + number) for number in range(10)))
    assert [frame.stamp_ns for frame in iter_capture(recorded_capture(tmp_path / "video.avi").read)] == [
        7_000 + number for number in range(10)
    ]
    (tmp_path / "video.stamps").write_text("7000\nseven\n")
    with pytest.raises(CaptureError, match=r"video\.stamps should hold one capture time"):
        recorded_capture(tmp_path / "video.avi")


def iter_capture(read: Callable[[], Frame | None]) -> Iterator[Frame]:
    while True:
        try:
            frame = read()
        except CaptureError:
            return
        assert frame is not None
        yield frame
