"""Floor tags as surveyed rooms show them to their cameras, without pictures: the truth of a seed, projected by the lens's own
formulas (Brown-Conrady), with noise on every corner."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, CameraModel
from lab.rendering.optics import mount_rotation
from lab.truth import true_camera_model, true_floor_tags
from localization.calibration import FloorSighting
from localization.tags import tag_corners
from protocol.lab import Accuracy, Lab, SimulatedMount, SimulatedSurvey

Array = NDArray[np.float64]

BIAS_PX = 0.03
FRAMES = 10
_MARGIN_PX = 4.0


@dataclass(frozen=True)
class TrueCamera:
    """A camera with its true lens, where it truly hangs."""

    model: CameraModel
    mount: SimulatedMount

    def project(self, points: Array) -> Array:
        """Pixels (N, 2) of map points (N, 3)."""
        seen = (points - np.array(self.mount.position)) @ mount_rotation(self.mount)
        x, y = seen[:, 0] / seen[:, 2], seen[:, 1] / seen[:, 2]
        k1, k2, p1, p2, k3 = self.model.distortion
        r2 = x * x + y * y
        radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
        u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return np.column_stack([self.model.fx * u + self.model.cx, self.model.fy * v + self.model.cy])

    def shows(self, pixels: Array) -> bool:
        limits = (self.model.width - 1 - _MARGIN_PX, self.model.height - 1 - _MARGIN_PX)
        return bool(((pixels >= _MARGIN_PX) & (pixels <= limits)).all())


def surveyed(lab: Lab, floor_tag_m: float, focal: float = 0.0, center_px: float = 0.0) -> Lab:
    """The lab measured with these standard deviations, and knowing it."""
    survey = SimulatedSurvey(floor_tag_m=floor_tag_m, focal=focal, center_px=center_px)
    accuracy = Accuracy(floor_tag_m=max(1e-4, floor_tag_m), focal=max(1e-5, focal), center_px=max(0.01, center_px))
    simulation = lab.simulation.model_copy(update={"survey": survey})
    return lab.model_copy(update={"simulation": simulation, "accuracy": accuracy})


def true_cameras(lab: Lab, seed: int) -> dict[str, TrueCamera]:
    return {
        camera.id: TrueCamera(true_camera_model(lab, camera, seed), lab.simulation.mounts[camera.id])
        for camera in lab.cameras
    }


def sightings(lab: Lab, seed: int, tags: Mapping[int, SE2] | None = None) -> list[FloorSighting]:
    """What every camera sees, averaged over frames; `tags` are where the floor tags truly lie (of the seed when not given)."""
    tags = true_floor_tags(lab, seed) if tags is None else tags
    square = tag_corners(lab.floor_tags.size_m)
    rng = np.random.default_rng([seed, 7])
    result: list[FloorSighting] = []
    for name, camera in true_cameras(lab, seed).items():
        corners: dict[int, Array] = {}
        for tag, place in tags.items():
            pixels = camera.project(np.column_stack([place.apply(square), np.zeros(4)]))
            if camera.shows(pixels):
                corners[tag] = pixels + rng.normal(0.0, BIAS_PX, (4, 2))
        result.append(FloorSighting(name, 1_000_000, FRAMES, corners, 0.01))
    return result


def spread_places(camera: TrueCamera, height_m: float, rng: np.random.Generator, count: int) -> Array:
    """Points (N, 3) at a height that the camera shows, drawn evenly over its view."""
    x, y, _ = camera.mount.position
    reach = math.hypot(camera.model.width, camera.model.height) / camera.model.fx * camera.mount.position[2] / 2
    found: list[Array] = []
    while len(found) < count:
        point = np.array([x + rng.uniform(-reach, reach), y + rng.uniform(-reach, reach), height_m])
        if camera.shows(camera.project(point[None])):
            found.append(point)
    return np.array(found)
