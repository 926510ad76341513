"""Which tags a simulated camera must see: the truth that detections are counted against."""

import numpy as np

from geometry import SE2
from lab.rendering.optics import Optics
from lab.truth import true_camera_model, true_vehicle
from protocol.lab import Lab

QUIET_ZONE = 10 / 8
"""A tag36h11 with its white border is ten cells wide, `size_m` measures the eight inside."""


class TagVisibility:
    """One camera of the simulated room as it truly is. `seed` None takes the lab description's; KeyError for an unknown
    camera, or one without a mount."""

    def __init__(self, lab: Lab, camera_id: str, seed: int | None = None) -> None:
        self._seed = lab.simulation.seed if seed is None else seed
        self._lab = lab
        spec = lab.camera(camera_id)
        self._optics = Optics(true_camera_model(lab, spec, self._seed), lab.simulation.mounts[camera_id])
        self._limits = np.array([spec.width - 1, spec.height - 1])
        self._heights = {vehicle.id: true_vehicle(lab, vehicle, self._seed).tag.height_m for vehicle in lab.vehicles}

    def sees(self, vehicle_id: str, pose: SE2) -> bool:
        """Whether the whole tag of the vehicle whose rotation centre is at `pose`, white border included, lies inside the
        image."""
        tag = self._lab.vehicle(vehicle_id).tag
        half = tag.size_m * QUIET_ZONE / 2
        corners = (pose @ tag.pose_on_vehicle()).apply([[-half, -half], [half, -half], [half, half], [-half, half]])
        pixels = self._optics.project(np.column_stack([corners, np.full(4, self._heights[vehicle_id])]))
        return pixels is not None and bool(((pixels >= 0) & (pixels <= self._limits)).all())
