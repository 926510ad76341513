"""A small scene for tests: tags on planes seen by a camera, drawn ray by ray, with the truth at hand."""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE2, SE3, CameraModel
from protocol.lab import Lab, parse_lab

_DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
_CELL = 24
_SUPERSAMPLING = 3


@dataclass(frozen=True)
class PlacedTag:
    """A printed tag in the map: centre and yaw of its own x axis, height and size of the black square."""

    tag_id: int
    pose: SE2
    height_m: float
    size_m: float


def mount(x: float, y: float, z: float, yaw: float = 0.0, tilt_x: float = 0.0, tilt_y: float = 0.0) -> SE3:
    """T_map_camera = translate Rz(yaw) Rx(pi + tilt_x) Ry(tilt_y), as the lab description has it."""
    rz = SE3.from_rotvec([0, 0, yaw], [x, y, z])
    rx = SE3.from_rotvec([np.pi + tilt_x, 0, 0], [0, 0, 0])
    return rz @ rx @ SE3.from_rotvec([0, tilt_y, 0], [0, 0, 0])


SMALL_LAB = """
name: small
areas: [{id: room, outline: [[-0.5, -0.5], [3.5, -0.5], [3.5, 1.5], [-0.5, 1.5]]}]
cameras:
  - &camera
    id: left
    area: room
    source: sim
    width: 960
    height: 540
    rate_hz: 15
    intrinsics: {fx: 620.0, fy: 618.0, cx: 478.0, cy: 272.0, distortion: [-0.06, 0.02, 0.0005, -0.0003, 0.0]}
  - {<<: *camera, id: right}
floor_tags:
  family: tag36h11
  size_m: 0.16
  poses:
    {0: [0.0, 0.0, 0.0], 1: [0.0, 1.0, 1.5708], 2: [1.5, 0.0, 0.3], 3: [1.5, 1.0, 0.0], 4: [3.0, 0.0, 0.0],
     5: [3.0, 1.0, 3.0]}
vehicles:
  - &robot
    id: robot-10
    kind: wifibot
    footprint: [[-0.15, -0.16], [0.15, -0.16], [0.15, 0.16], [-0.15, 0.16]]
    tag: {family: tag36h11, id: 10, size_m: 0.16, height_m: 0.3, offset: [0.05, 0.02, 0.4]}
    limits: {speed_mps: 1.0, yaw_rate_radps: 1.5, acceleration_mps2: 1.0, braking_mps2: 2.0, yaw_acceleration_radps2: 4.0}
  - {<<: *robot, id: robot-11, tag: {family: tag36h11, id: 11, size_m: 0.16, height_m: 0.3}}
simulation:
  mounts:
    left: {position: [0.75, 0.5, 2.2]}
    right: {position: [2.25, 0.5, 2.2]}
"""


def small_lab() -> Lab:
    """Two 960 x 540 cameras over a 4 x 2 m floor with six floor tags and two vehicles."""
    return parse_lab(SMALL_LAB, "small.yaml")


MOUNTS = {
    "left": mount(0.75, 0.5, 2.2, 0.02, 0.015, -0.01),
    "right": mount(2.25, 0.52, 2.25, -0.03, -0.012, 0.008),
}
"""Where the cameras of `small_lab` truly hang."""


def floor_tags(lab: Lab) -> list[PlacedTag]:
    size = lab.floor_tags.size_m
    return [PlacedTag(tag_id, SE2(*pose), 0.0, size) for tag_id, pose in lab.floor_tags.poses.items()]


def vehicle_tag(lab: Lab, vehicle_id: str, pose: SE2) -> PlacedTag:
    """The tag of a vehicle whose rotation centre is at `pose`."""
    tag = lab.vehicle(vehicle_id).tag
    return PlacedTag(tag.id, pose @ SE2(*tag.offset), tag.height_m, tag.size_m)


def render(
    model: CameraModel,
    T_map_camera: SE3,
    tags: Iterable[PlacedTag],
    *,
    seed: int = 0,
    noise: float = 2.0,
    blur_px: float = 0.6,
    background: float | NDArray[np.float32] = 60.0,
) -> NDArray[np.uint8]:
    """A grey picture of the tags on a plain floor (or on one drawn before), shape (height, width)."""
    image = draw(model, T_map_camera, tags, background)
    if blur_px > 0:
        image = cv2.GaussianBlur(image, (0, 0), blur_px).astype(np.float32)
    image += noise * np.random.default_rng(seed).standard_normal(image.shape, dtype=np.float32)
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def draw(
    model: CameraModel,
    T_map_camera: SE3,
    tags: Iterable[PlacedTag],
    background: float | NDArray[np.float32] = 60.0,
) -> NDArray[np.float32]:
    """The tags as a perfect lens and sensor would see them, shape (height, width)."""
    image = np.empty((model.height, model.width), np.float32)
    image[...] = background
    for tag in sorted(tags, key=lambda tag: tag.height_m):
        _draw(image, model, T_map_camera, tag)
    return image


def printed(tag_id: int) -> NDArray[np.uint8]:
    """The tag with one cell of white border, as OpenCV draws it."""
    inner = cv2.aruco.generateImageMarker(_DICTIONARY, tag_id, 8 * _CELL)
    return cv2.copyMakeBorder(inner, _CELL, _CELL, _CELL, _CELL, cv2.BORDER_CONSTANT, value=255).astype(np.uint8)


def _draw(image: NDArray[np.float32], model: CameraModel, T_map_camera: SE3, tag: PlacedTag) -> None:
    reach = tag.size_m * 10 / 16
    outline = tag.pose.apply(np.array([[-reach, -reach], [reach, -reach], [reach, reach], [-reach, reach]]))
    corners = np.column_stack([outline, np.full(4, tag.height_m)])
    T_camera_map = T_map_camera.inverse()
    if (T_camera_map.apply(corners)[:, 2] < 0.1).any():
        return
    projected, _ = cv2.projectPoints(
        corners, T_camera_map.rotvec(), np.array(T_camera_map.translation), model.matrix(), model.distortion_array()
    )
    pixels = projected.reshape(-1, 2)
    left, top = (max(0, int(v)) for v in np.floor(pixels.min(axis=0)) - 2)
    right = min(model.width, int(np.ceil(pixels[:, 0].max())) + 3)
    bottom = min(model.height, int(np.ceil(pixels[:, 1].max())) + 3)
    if right <= left or bottom <= top:
        return
    n = _SUPERSAMPLING
    u = left - 0.5 + (np.arange((right - left) * n) + 0.5) / n
    v = top - 0.5 + (np.arange((bottom - top) * n) + 0.5) / n
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 1, 2)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 15, 1e-9)
    rays = cv2.undistortPoints(grid, model.matrix(), model.distortion_array(), criteria=criteria).reshape(-1, 2)
    directions = np.column_stack([rays, np.ones(len(rays))]) @ T_map_camera.rotation.T
    eye = T_map_camera.translation
    scale = (tag.height_m - eye[2]) / directions[:, 2]
    local = tag.pose.inverse().apply(eye[:2] + scale[:, None] * directions[:, :2])
    # OpenCV draws the tag turned by half a turn against its own axes, and pictures have y down.
    cell_m = tag.size_m / 8
    column = (5 * cell_m - local[:, 0]) / cell_m * _CELL - 0.5
    row = (5 * cell_m + local[:, 1]) / cell_m * _CELL - 0.5
    shape = (len(v), len(u))
    texture = cv2.remap(
        printed(tag.tag_id).astype(np.float32),
        column.reshape(shape).astype(np.float32),
        row.reshape(shape).astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=-1.0,
    )
    fine = np.where(texture < 0, np.repeat(np.repeat(image[top:bottom, left:right], n, 0), n, 1), texture)
    image[top:bottom, left:right] = cv2.resize(
        fine.astype(np.float32), (right - left, bottom - top), interpolation=cv2.INTER_AREA
    )
