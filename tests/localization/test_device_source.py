"""Cameras at this machine: there is none where tests run, so a video device is played; what happens without one is real."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from localization.sources import BrokenFrameError, CaptureError
from localization.sources.device import DeviceCapture
from localization.sources.raw_buffers import FORMATS, image_of
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

    def __init__(self, clock: SimulatedClock, buffers: list[Any], captured_s: float | None, pixel_format: str) -> None:
        self.clock, self.buffers, self.captured_s = clock, buffers, captured_s
        self.fourcc = int.from_bytes(pixel_format.ljust(4).encode(), "little") if pixel_format else -1
        self.asked: dict[int, float] = {}
        self.opens = True
        self.released = False

    def isOpened(self) -> bool:
        return self.opens

    def set(self, propId: int, value: float) -> bool:
        self.asked[propId] = value
        return False  # as a driver that does as it likes

    def get(self, propId: int) -> float:
        if propId == cv2.CAP_PROP_FOURCC:
            return float(self.fourcc)
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
    tmp_path: Path, *buffers: Any, color: bool = False, captured_s: float | None = None, pixel_format: str = "GREY"
) -> tuple[DeviceCapture, PlayedVideo, SimulatedClock]:
    clock = SimulatedClock()
    clock.wait(100.0)
    video = PlayedVideo(clock, list(buffers), captured_s, pixel_format)
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


def buffer_of(pixel_format: str) -> NDArray[Any]:
    """PIXELS, without any colour, as a driver's buffer; luma spans 0 to 255 as cameras' does."""
    colourless = np.full_like(PIXELS, 128)
    match pixel_format:
        case "MJPG":
            return np.frombuffer(jpeg(PIXELS, 95), np.uint8).reshape(1, -1)
        case "YUYV" | "YVYU":
            return np.dstack([PIXELS, colourless])
        case "UYVY":
            return np.dstack([colourless, PIXELS])
        case "NV12" | "NV21" | "YU12" | "YV12":
            return np.vstack([PIXELS, colourless[: len(PIXELS) // 2]])
        case "Y10":
            return PIXELS.astype(np.uint16) * 4 + 3
        case "Y16":
            return PIXELS.astype(np.uint16) * 256 + 77
        case "BGR3":
            return np.dstack([PIXELS] * 3)
        case _:
            return PIXELS


@pytest.mark.parametrize("color", [False, True])
@pytest.mark.parametrize(
    "pixel_format", ["MJPG", "YUYV", "YVYU", "UYVY", "NV12", "NV21", "YU12", "YV12", "GREY", "Y10", "Y16", "BGR3"]
)
def test_buffers_of_every_format_become_images(tmp_path: Path, pixel_format: str, color: bool) -> None:
    capture, _, _ = played(tmp_path, buffer_of(pixel_format), color=color, pixel_format=pixel_format)
    pixels = capture.read().pixels
    assert pixels.dtype == np.uint8
    if not color:
        assert pixels.shape == (48, 64)
        assert np.abs(pixels.astype(int) - PIXELS).max() <= (8 if pixel_format == "MJPG" else 0)
        return
    assert pixels.shape == (48, 64, 3)
    # YUV's grey spans 16 to 235, so colours made of it are stretched.
    assert np.corrcoef(pixels[..., 1].ravel(), PIXELS.ravel())[0, 1] > 0.99
    assert np.ptp(pixels.astype(int), axis=2).max() <= 4


@pytest.mark.parametrize(("pixel_format", "named"), [("H264", "pixel format H264"), ("", "does not name")])
def test_a_format_that_is_not_understood_is_named(tmp_path: Path, pixel_format: str, named: str) -> None:
    with pytest.raises(CaptureError, match=rf"video7 sends .*{named}.*; understood are BGR3, GREY, .*MJPG"):
        played(tmp_path, PIXELS, pixel_format=pixel_format)


@given(
    pixel_format=st.sampled_from(FORMATS),
    shape=st.lists(st.integers(0, 9), min_size=0, max_size=4),
    dtype=st.sampled_from([np.uint8, np.uint16, np.int32, np.float64]),
    color=st.booleans(),
)
def test_a_buffer_that_is_not_what_its_format_says_is_broken(
    pixel_format: str, shape: list[int], dtype: type[np.generic], color: bool
) -> None:
    try:
        image = image_of(np.zeros(shape, dtype), pixel_format, color=color)
    except BrokenFrameError:
        return
    assert image.dtype == np.uint8
    assert image.ndim == (3 if color else 2)


def test_the_drivers_capture_time_is_kept_when_it_can_be(tmp_path: Path) -> None:
    capture, _, clock = played(tmp_path, PIXELS, captured_s=99.985)
    assert capture.read().stamp_ns == clock.now_ns() - 15_000_000
    for of_another_clock in (None, 5.0, 1e9):
        capture, _, clock = played(tmp_path, PIXELS, captured_s=of_another_clock)
        assert capture.read().stamp_ns == clock.now_ns()


def test_broken_buffers_are_told_from_the_end(tmp_path: Path) -> None:
    half, whole = (np.frombuffer(data, np.uint8).reshape(1, -1) for data in (b"\xff\xd8half", jpeg(PIXELS)))
    capture, video, _ = played(tmp_path, None, half, whole, pixel_format="MJPG")
    for _ in range(2):
        with pytest.raises(BrokenFrameError):
            capture.read()
    assert capture.read().number == 3
    with pytest.raises(CaptureError, match="gives no more frames"):
        capture.read()
    capture.close()
    assert video.released
