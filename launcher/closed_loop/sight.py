"""What the ceiling cameras, the tracker and the mapper would say, from the truth: poses and the map of what is on the floor, each
as of its capture time."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from geometry import SE2
from mapping.grid import FloorGrid
from protocol.channels import LAB_INSTANCE
from protocol.lab import Lab
from protocol.messages import FloorRaster, TrackedPose, TruePose

_NOISE_M, _NOISE_RAD = 0.004, 0.005
_COVARIANCE = (_NOISE_M**2, 0.0, 0.0, _NOISE_M**2, 0.0, _NOISE_RAD**2)


class Sight:
    """Every place is seen by the camera that hangs nearest along x; those in `dark` see nothing."""

    def __init__(self, lab: Lab, seed: int) -> None:
        self.dark: set[str] = set()
        self._lab = lab
        self._rng = np.random.default_rng([seed, 7])
        self._mounts = {camera: mount.position[0] for camera, mount in lab.simulation.mounts.items()}
        self._grid = FloorGrid.covering(lab.bounds())
        columns = np.arange(self._grid.columns)
        x = self._grid.origin_x + (columns + 0.5) * self._grid.cell_m
        self._column_camera = [self.camera_at(float(value)) for value in x]
        self._blank = np.zeros_like(self._grid.occupied)

    def camera_at(self, x: float) -> str:
        """The camera that sees this place."""
        return min(self._mounts, key=lambda camera: abs(self._mounts[camera] - x))

    def poses(self, truth: Mapping[str, TruePose], stamp_ns: int) -> dict[str, TrackedPose]:
        """The tracked pose of every vehicle that a camera sees."""
        seen: dict[str, TrackedPose] = {}
        for vehicle, pose in truth.items():
            camera = self.camera_at(pose.x)
            dx, dy, turn = (float(value) for value in self._rng.standard_normal(3))
            if camera in self.dark:
                continue
            area = self._lab.area_at(pose.x, pose.y)
            seen[vehicle] = TrackedPose(
                vehicle=vehicle,
                stamp_ns=stamp_ns,
                x=pose.x + _NOISE_M * dx,
                y=pose.y + _NOISE_M * dy,
                yaw=SE2(0.0, 0.0, pose.yaw + _NOISE_RAD * turn).yaw,
                vx=pose.linear_mps * math.cos(pose.yaw),
                vy=pose.linear_mps * math.sin(pose.yaw),
                yaw_rate=pose.angular_radps,
                covariance=_COVARIANCE,
                cameras=(camera,),
                area=None if area is None else area.id,
            )
        return seen

    def raster(self, things: Sequence[BaseGeometry], stamp_ns: int) -> FloorRaster:
        """The obstacle map: cells that a thing on the floor touches, where a camera sees them."""
        grid = self._grid
        observed = np.ones_like(self._blank)
        if self.dark:
            observed[:, [camera in self.dark for camera in self._column_camera]] = False
        occupied = self._occupied(things) & observed if things else self._blank
        return grid.with_cells(occupied, observed).to_raster(LAB_INSTANCE, stamp_ns)

    def _occupied(self, things: Sequence[BaseGeometry]) -> NDArray[np.bool_]:
        grid, occupied = self._grid, self._blank.copy()
        for thing in things:
            widened = thing.buffer(grid.cell_m / 2, join_style="mitre")
            corners = np.asarray(widened.exterior.coords[:-1])  # pyright: ignore[reportAttributeAccessIssue]  # outlines have one
            all_cells = grid.with_cells(np.ones_like(occupied), np.ones_like(occupied))
            for x, y in all_cells.look(corners).occupied:
                row, column = int((y - grid.origin_y) / grid.cell_m), int((x - grid.origin_x) / grid.cell_m)
                occupied[row, column] = True
        return occupied
