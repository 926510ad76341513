"""Cameras for experiments: those of a lab at another resolution and rate, and the clock that their frames are stamped with."""

from protocol.clock import SystemClock
from protocol.lab import CameraSpec, Lab

RESOLUTIONS = {"fullhd": (1920, 1080), "uhd": (3840, 2160)}
"""Names in the experiments' keys, and width and height in pixels."""


class FrameClock(SystemClock):
    """Says that it is now `stamp_ns`, when the newest frame was taken; durations are measured for real."""

    def __init__(self, stamp_ns: int = 1_700_000_000_000_000_000) -> None:
        self.stamp_ns = stamp_ns

    def now_ns(self) -> int:
        return self.stamp_ns


def with_cameras(lab: Lab, resolution: str, rate_hz: float) -> Lab:
    """The lab with all its cameras at that resolution (a key of RESOLUTIONS) and rate, behind the same lenses: the intrinsics
    grow with the width. KeyError for an unknown resolution."""
    width, height = RESOLUTIONS[resolution]
    return lab.model_copy(update={"cameras": tuple(_resized(each, width, height, rate_hz) for each in lab.cameras)})


def _resized(camera: CameraSpec, width: int, height: int, rate_hz: float) -> CameraSpec:
    scale = width / camera.width
    i = camera.intrinsics
    # The first pixel's centre is (0, 0), so its edge is at -0.5, at any resolution.
    centre = {"cx": (i.cx + 0.5) * scale - 0.5, "cy": (i.cy + 0.5) * scale - 0.5}
    intrinsics = i.model_copy(update={"fx": i.fx * scale, "fy": i.fy * scale, **centre})
    return camera.model_copy(update={"width": width, "height": height, "rate_hz": rate_hz, "intrinsics": intrinsics})
