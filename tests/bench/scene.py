"""The frames that all methods get: four cameras over vehicles on circles, rendered once, kept as grey JPEG with the truth.

The circles close after a whole number of frames, so a short recording plays on without a jump for as long as a method needs.
"""

import math
from pathlib import Path

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from lab.rendering import CameraRenderer
from lab.snapshot import Snapshot, VehicleSnapshot
from launcher.experiments.cameras import with_cameras
from launcher.experiments.visibility import TagVisibility
from localization.sources.jpeg import decode_jpeg
from protocol.lab import Lab

RATE_HZ = 60.0
SPEED_MPS = 0.6
JPEG_QUALITY = 95
LOOP_FRAMES = {"fullhd": 120, "uhd": 60}
FIRST_TAG = 20
VEHICLE_COUNTS = (1, 4, 20)
_PLACES = {
    1: [(4.0, 1.6)],
    4: [(0.8, 1.6), (2.4, 2.6), (4.0, 1.6), (7.2, 2.6)],
    20: [(0.8 + 1.6 * column, 0.6 + row) for column in range(5) for row in range(4)],
}
"""Centres of the circles in the reports' room (m): every camera sees somebody, and who is at x = 2.4, 4.0 and 5.6 passes from one
camera's view into another's."""


class RecordedFrame(msgspec.Struct, frozen=True):
    """A grey JPEG, how long after the loop's begin it was taken, and T_map_tag (x, y, yaw) of every vehicle tag that is wholly
    visible, by tag id."""

    jpeg: bytes
    offset_ns: int
    truth: dict[int, tuple[float, float, float]]


class Recording(msgspec.Struct, frozen=True):
    """One camera's loop; frame n of the endless film is frame n modulo the length, and each round takes `period_ns`. `floor` is a
    grey JPEG of the floor before anybody drove on it, for methods that are calibrated apart."""

    camera: str
    floor: bytes
    period_ns: int
    frames: tuple[RecordedFrame, ...]

    def stamp_ns(self, number: int, start_ns: int) -> int:
        """Capture time of frame `number` (from 0) of the endless film."""
        rounds, index = divmod(number, len(self.frames))
        return start_ns + rounds * self.period_ns + self.frames[index].offset_ns


def bench_lab(lab: Lab, resolution: str, count: int) -> Lab:
    """The reports' room at that resolution and 60 Hz with `count` vehicles like its first one."""
    first = lab.vehicles[0]
    vehicles = tuple(
        first.model_copy(
            update={"id": f"vehicle-{tag}", "driver": "sim", "tag": first.tag.model_copy(update={"id": tag})}
        )
        for tag in range(FIRST_TAG, FIRST_TAG + count)
    )
    simulation = lab.simulation.model_copy(update={"starts": {}, "tours": {}})
    return with_cameras(lab, resolution, RATE_HZ).model_copy(update={"vehicles": vehicles, "simulation": simulation})


def vehicles_at(lab: Lab, phase: float) -> tuple[VehicleSnapshot, ...]:
    """Everybody at that share of the round, each on a circle of its own driven at SPEED_MPS, one after the other turned."""
    loop_s = LOOP_FRAMES[resolution_of(lab)] / RATE_HZ
    radius_m, turning = SPEED_MPS * loop_s / math.tau, math.tau / loop_s
    found: list[VehicleSnapshot] = []
    for index, (vehicle, (x, y)) in enumerate(zip(lab.vehicles, _PLACES[len(lab.vehicles)], strict=True)):
        angle = math.tau * phase + 2.4 * index
        at = SE2(x, y, angle) @ SE2(radius_m, 0.0, math.pi / 2)
        found.append(VehicleSnapshot(vehicle.id, at.x, at.y, at.yaw, SPEED_MPS, turning))
    return tuple(found)


def resolution_of(lab: Lab) -> str:
    """The name of its cameras' resolution."""
    return "fullhd" if lab.cameras[0].width == 1920 else "uhd"


def record(labs: list[Lab], camera_id: str, frames: int | None, seed: int, files: list[Path]) -> None:
    """Renders one camera's loop for each of the labs, which differ in their vehicles only, into a file each. `frames` cuts the
    loop short, for tests."""
    cv2.setNumThreads(1)
    most = max(labs, key=lambda lab: len(lab.vehicles))
    renderer, visibility = CameraRenderer(most, camera_id, seed), TagVisibility(most, camera_id, seed)
    # Free-running cameras do not expose at the same instant.
    late = [camera.id for camera in most.cameras].index(camera_id) / len(most.cameras)
    length = LOOP_FRAMES[resolution_of(most)]
    floor = _jpeg(renderer.render(Snapshot(0, (), ()), 0))
    for lab, file in zip(labs, files, strict=True):
        recorded: list[RecordedFrame] = []
        for index in range(frames or length):
            present = vehicles_at(lab, (index + late) / length)
            jpeg = _jpeg(renderer.render(Snapshot(0, present, ()), index + 1))
            truth = {
                lab.vehicle(each.id).tag.id: _tag_pose(lab, each)
                for each in present
                if visibility.sees(each.id, SE2(each.x, each.y, each.yaw))
            }
            recorded.append(RecordedFrame(jpeg, round((index + late) / RATE_HZ * 1e9), truth))
        period_ns = round(len(recorded) / RATE_HZ * 1e9)
        file.write_bytes(msgspec.msgpack.encode(Recording(camera_id, floor, period_ns, tuple(recorded))))


def read_recording(file: Path) -> Recording:
    return msgspec.msgpack.decode(file.read_bytes(), type=Recording)


def decoded(jpeg: bytes) -> NDArray[np.uint8]:
    """The picture as a camera process decodes it: grey, shape (height, width)."""
    return decode_jpeg(jpeg, color=False)


def _jpeg(pixels: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()


def _tag_pose(lab: Lab, vehicle: VehicleSnapshot) -> tuple[float, float, float]:
    tag = SE2(vehicle.x, vehicle.y, vehicle.yaw) @ lab.vehicle(vehicle.id).tag.pose_on_vehicle()
    return tag.x, tag.y, tag.yaw
