"""What the cameras of the small lab would send of its floor tags, projected from where they truly hang."""

import numpy as np

from geometry import SE2, SE3
from localization.calibration import FloorSighting
from localization.calibration_link import sighting_message
from localization.projection import CameraView
from localization.tags import tag_corners
from protocol.lab import Lab, camera_basis
from protocol.messages import FloorTagSighting
from tests.localization.synthetic import MOUNTS, small_lab

LAB = small_lab()
SEES = {"left": (0, 1, 2, 3), "right": (2, 3, 4, 5)}
NOISE_PX = 0.03


def sighting(
    camera: str,
    stamp_ns: int,
    *,
    mount: SE3 | None = None,
    lab: Lab = LAB,
    floor_tags: dict[int, SE2] | None = None,
    seed: int = 1,
) -> FloorSighting:
    """`mount` is T_map_camera, `floor_tags` where the tags truly lie (default: as described)."""
    rng = np.random.default_rng([seed, len(camera)])
    view = CameraView(lab.camera(camera).model(), mount or MOUNTS[camera])
    square = tag_corners(lab.floor_tags.size_m)
    places = {tag: SE2(*pose) for tag, pose in lab.floor_tags.poses.items()} | (floor_tags or {})
    corners: dict[int, np.ndarray] = {}
    for tag in SEES[camera]:
        pixels, _ = view.project(np.column_stack([places[tag].apply(square), np.zeros(4)]))
        corners[tag] = pixels + rng.normal(0, NOISE_PX, pixels.shape)
    return FloorSighting(camera, stamp_ns, 10, corners, NOISE_PX)


def message(seen: FloorSighting, extrinsics_ns: int, request: int = 0, lab: Lab = LAB) -> FloorTagSighting:
    """As the camera's process sends it."""
    return sighting_message(seen, extrinsics_ns, camera_basis(lab.camera(seen.camera)), request)
