"""Cameras at this machine: there is none where tests run, so a video device is played; what happens without one is real."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from localization.sources import BrokenFrameError, CaptureError
from localization.sources.device import DeviceCapture
from protocol.clock import SimulatedClock
from protocol.lab import CameraSpec, Intrinsics
from tests.localization.mjpeg_camera import jpeg

PIXELS = np.add.outer(np.arange(48), 2 * np.arange(64)).astype(np.uint8)


def spec(source: str | int, *, color: bool = False) -> CameraSpec:
    lens = Intrinsics(fx=60.0, fy=60.0, cx=32.0, cy=24.0)
    return CameraSpec(
        id="cam", area="a", source=source, width=64, height=48, rate_hz=60.0, color=color, intrinsics=lens
    )


class PlayedVideo:
    """Gives the buffers that it was given, as the V4L2 backend of OpenCV does."""

    def __init__(self, clock: SimulatedClock, buffers: list[Any], captured_s: float | None) -> None:
        self.clock, self.buffers, self.captured_s = clock, buffers, captured_s
        self.asked: dict[int, float] = {}
        self.opens = True
        self.released = False

    def isOpened(self) -> bool:
        return self.opens

    def set(self, propId: int, value: float) -> bool:
        self.asked[propId] = value
        return False  # as a driver that does as it likes

    def get(self, propId: int) -> float:
        assert propId == cv2.CAP_PROP_POS_MSEC
        return 0.0 if self.captured_s is None else self.captured_s * 1e3

    def grab(self) -> bool:
        return bool(self.buffers)

    def retrieve(self) -> tuple[bool, Any]:
        buffer = self.buffers.pop(0)
        return buffer is not None, buffer

    def release(self) -> None:
        self.released = True


def played(
    tmp_path: Path, *buffers: Any, color: bool = False, captured_s: float | None = None
) -> tuple[DeviceCapture, PlayedVideo, SimulatedClock]:
    clock = SimulatedClock()
    clock.wait(100.0)
    video = PlayedVideo(clock, list(buffers), captured_s)
    node = tmp_path / "video7"
    node.touch()
    return DeviceCapture(str(node), spec(str(node), color=color), clock, lambda _: video), video, clock


def test_a_device_that_is_not_there_is_named_with_those_that_are() -> None:
    with pytest.raises(
        CaptureError, match=r"^/dev/video97 does not exist \((there are /dev/video|this machine has no)"
    ):
        DeviceCapture(97, spec(97), SimulatedClock())
    with pytest.raises(CaptureError, match="/dev/video98 does not exist"):
        DeviceCapture("98", spec("98"), SimulatedClock())


def test_what_is_no_camera_is_refused_by_the_real_backend(tmp_path: Path) -> None:
    node = tmp_path / "video0"
    node.write_bytes(b"no camera")
    with pytest.raises(CaptureError, match="cannot be opened: is it a camera, free"):
        DeviceCapture(str(node), spec(str(node)), SimulatedClock())


def test_it_is_asked_for_the_size_rate_and_format_of_the_lab_file(tmp_path: Path) -> None:
    _, video, _ = played(tmp_path)
    assert video.asked[cv2.CAP_PROP_FRAME_WIDTH] == 64
    assert video.asked[cv2.CAP_PROP_FRAME_HEIGHT] == 48
    assert video.asked[cv2.CAP_PROP_FPS] == 60
    assert video.asked[cv2.CAP_PROP_FOURCC] == cv2.VideoWriter.fourcc(*"MJPG")
    assert video.asked[cv2.CAP_PROP_CONVERT_RGB] == 0


@pytest.mark.parametrize("color", [False, True])
def test_buffers_of_every_kind_become_images(tmp_path: Path, color: bool) -> None:
    compressed = np.frombuffer(jpeg(PIXELS, 95), np.uint8).reshape(1, -1)
    yuyv = np.dstack([PIXELS, np.full_like(PIXELS, 128)])
    bgr = np.dstack([PIXELS] * 3)
    capture, _, _ = played(tmp_path, compressed, yuyv, bgr, color=color)
    for _ in range(2):
        pixels = capture.read().pixels
        assert pixels.shape == ((48, 64, 3) if color else (48, 64))
        # YUV's grey spans 16..235
        assert np.corrcoef((pixels[..., 1] if color else pixels).ravel(), PIXELS.ravel())[0, 1] > 0.99
    assert capture.read().pixels.shape == (48, 64, 3)


def test_the_drivers_capture_time_is_kept_when_it_can_be(tmp_path: Path) -> None:
    capture, _, clock = played(tmp_path, PIXELS, captured_s=99.985)
    assert capture.read().stamp_ns == clock.now_ns() - 15_000_000
    for of_another_clock in (None, 5.0, 1e9):
        capture, _, clock = played(tmp_path, PIXELS, captured_s=of_another_clock)
        assert capture.read().stamp_ns == clock.now_ns()


def test_broken_buffers_are_told_from_the_end(tmp_path: Path) -> None:
    capture, video, _ = played(tmp_path, None, np.frombuffer(b"\xff\xd8half", np.uint8).reshape(1, -1), PIXELS)
    for _ in range(2):
        with pytest.raises(BrokenFrameError):
            capture.read()
    assert capture.read().number == 3
    with pytest.raises(CaptureError, match="gives no more frames"):
        capture.read()
    capture.close()
    assert video.released
