"""Cameras that are read by FFmpeg: RTSP as a camera speaks it, and a video over HTTP; what they do when they fall silent."""

import itertools
from collections.abc import Generator
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import cv2
import numpy as np
import pytest

from localization.sources import CaptureError
from localization.sources.live import checked
from localization.sources.stream import StreamCapture
from localization.sources.video import VideoFileCapture
from protocol.clock import SystemClock
from protocol.lab import CameraSpec, Intrinsics
from tests.localization.rtsp_camera import RtspCamera

WIDTH, HEIGHT = 320, 240
PIXELS = np.add.outer(np.arange(HEIGHT) // 3, np.arange(WIDTH) // 2).astype(np.uint8)
SPEC = CameraSpec(
    id="cam",
    area="a",
    source="rtsp://",
    width=WIDTH,
    height=HEIGHT,
    rate_hz=30.0,
    intrinsics=Intrinsics(fx=300.0, fy=300.0, cx=160.0, cy=120.0),
)


def colour_jpeg() -> bytes:
    ok, data = cv2.imencode(".jpg", np.dstack([PIXELS] * 3), [cv2.IMWRITE_JPEG_QUALITY, 95])
    assert ok
    return data.tobytes()


@pytest.fixture
def camera() -> Generator[RtspCamera]:
    made = RtspCamera(colour_jpeg(), WIDTH, HEIGHT)
    yield made
    made.close()


@pytest.fixture
def video(tmp_path: Path) -> Generator[str]:
    """The address of a video of ten frames, ever lighter."""
    writer = cv2.VideoWriter(str(tmp_path / "v.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 30.0, (WIDTH, HEIGHT))
    for number in range(10):
        writer.write(np.full((HEIGHT, WIDTH, 3), 20 * number, np.uint8))
    writer.release()

    class Handler(SimpleHTTPRequestHandler):
        def __init__(self, *given: object) -> None:
            super().__init__(*given, directory=str(tmp_path))  # pyright: ignore[reportArgumentType]

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002  # the base class's name
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    yield f"http://127.0.0.1:{server.server_address[1]}/v.avi"
    server.shutdown()
    server.server_close()
    thread.join()


def test_rtsp_pictures_arrive_as_they_were_sent(camera: RtspCamera) -> None:
    capture = StreamCapture(camera.url, SystemClock())
    try:
        frames = [checked(capture.read(), SPEC) for _ in range(8)]
    finally:
        capture.close()
    assert all(np.abs(frame.pixels.astype(int) - PIXELS).max() < 12 for frame in frames)
    stamps = [frame.stamp_ns for frame in frames]
    assert all(before < after for before, after in itertools.pairwise(stamps))
    assert 0 <= SystemClock().now_ns() - stamps[-1] < 5e9


def test_an_rtsp_camera_that_falls_silent_is_over_within_seconds(camera: RtspCamera) -> None:
    capture = StreamCapture(camera.url, SystemClock())
    try:
        assert capture.read().pixels.shape == (HEIGHT, WIDTH, 3)
        camera.silent = True
        with pytest.raises(CaptureError, match="gives no more frames"):
            while True:
                capture.read()
    finally:
        capture.close()


def test_a_video_over_http_is_read_to_its_end(video: str) -> None:
    capture = StreamCapture(video, SystemClock())
    levels: list[float] = []
    try:
        with pytest.raises(CaptureError, match=r"v\.avi gives no more frames"):
            while True:
                levels.append(float(capture.read().pixels.mean()))
    finally:
        capture.close()
    # Without its buffers FFmpeg uses up the first picture to find out what it reads.
    assert levels[-9:] == pytest.approx([20 * number for number in range(1, 10)], abs=3)


def test_a_file_that_is_read_afterwards_has_its_first_frame(video: str, tmp_path: Path) -> None:
    StreamCapture(video, SystemClock()).close()
    frames = VideoFileCapture(tmp_path / "v.avi")
    try:
        assert frames.read().pixels.mean() == pytest.approx(0, abs=3)
    finally:
        frames.close()


@pytest.mark.parametrize("path", ["rtsp://me:secret@127.0.0.1:9/stream", "http://me:secret@127.0.0.1:9/v.avi"])
def test_nobody_there_is_said_without_the_password(path: str) -> None:
    with pytest.raises(CaptureError, match=r"127\.0\.0\.1:9/.* cannot be opened") as caught:
        StreamCapture(path, SystemClock())
    assert "secret" not in str(caught.value)
