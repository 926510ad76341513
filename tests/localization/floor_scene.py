"""A rendered floor under one camera, for the tests of floor obstacles: the simulated lab, half the usual resolution."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, SE3
from lab.rendering import CameraRenderer
from lab.rendering.optics import mount_rotation
from lab.world import World
from localization.floor import FloorObserver
from mapping.grid import FloorGrid
from protocol.frames import Frame
from protocol.lab import Intrinsics, Lab, load_lab
from protocol.messages import CameraExtrinsics, FloorRaster, SimulatedObject, TrackedPose

RATE_HZ = 15
_GULLIVER = load_lab("labs/gulliver.yaml")


def half_size(lab: Lab) -> Lab:
    """The lab with cameras of half the resolution, which render four times as fast."""
    cameras = tuple(
        camera.model_copy(
            update={
                "width": camera.width // 2,
                "height": camera.height // 2,
                "intrinsics": Intrinsics(
                    fx=camera.intrinsics.fx / 2,
                    fy=camera.intrinsics.fy / 2,
                    cx=(camera.intrinsics.cx + 0.5) / 2 - 0.5,
                    cy=(camera.intrinsics.cy + 0.5) / 2 - 0.5,
                    distortion=camera.intrinsics.distortion,
                ),
            }
        )
        for camera in lab.cameras
    )
    return lab.model_copy(update={"cameras": cameras})


LAB = half_size(_GULLIVER)
_RENDERERS: dict[str, CameraRenderer] = {}


def renderer(camera: str) -> CameraRenderer:
    """Shared by all tests: the floor takes long to render, and is the same for all."""
    if camera not in _RENDERERS:
        _RENDERERS[camera] = CameraRenderer(LAB, camera)
    return _RENDERERS[camera]


def true_extrinsics(camera: str) -> CameraExtrinsics:
    mount = LAB.simulation.mounts[camera]
    T_map_camera = SE3(mount_rotation(mount), np.array(mount.position))
    x, y, z = (float(value) for value in T_map_camera.rotvec())
    return CameraExtrinsics(camera, 1, (x, y, z), mount.position, 0.1, (0, 1, 2, 3))


def pallet(x: float, y: float, yaw: float = 0.0) -> SimulatedObject:
    return SimulatedObject(id="pallet", kind="pallet", x=x, y=y, yaw=yaw)


class Scene:
    """A world, and the camera that looks at it; vehicles stand outside of its view unless placed."""

    def __init__(self, observer: FloorObserver, camera: str = "cam0", world: World | None = None) -> None:
        self.observer = observer
        self.camera = camera
        self.extrinsics = true_extrinsics(camera)
        self.world = world or empty_world()
        self.drives: dict[str, tuple[float, float]] = {}
        self.with_poses = True
        self.gain = 1.0
        self.number = 0
        self._start_ns = self.world.stamp_ns
        self._rng = np.random.default_rng(5)
        self._poses: dict[str, TrackedPose] = {}

    def frame(self) -> Frame:
        """The next frame, a fifteenth of a second later."""
        self._poses = self._tracked()
        self.number += 1
        until_ns = self._start_ns + round(self.number * 1e9 / RATE_HZ)
        while self.world.stamp_ns < until_ns:
            for name, (linear, angular) in self.drives.items():
                self.world.set_drive(name, linear, angular)
            self.world.step()
        pixels = renderer(self.camera).render(self.world.snapshot(), self.number)
        if self.gain != 1.0:
            pixels = np.clip(pixels * self.gain, 0, 255).astype(np.uint8)
        return Frame(self.number, self.world.stamp_ns, pixels)

    def step(self) -> FloorRaster | None:
        """One frame through the observer, with the poses of the frame before: those of this one are not known yet."""
        return self.observer.observe(self.frame(), self.extrinsics, self._poses if self.with_poses else {})

    def rasters(self, seconds: float) -> Iterator[FloorGrid]:
        for _ in range(round(seconds * RATE_HZ)):
            raster = self.step()
            if raster is not None:
                yield FloorGrid.from_raster(raster)

    def run(self, seconds: float) -> FloorGrid:
        """The last raster after so long."""
        *_, last = self.rasters(seconds)
        return last

    def _tracked(self) -> dict[str, TrackedPose]:
        """The truth with a tracker's errors: 3 mm, half a degree, 2 cm/s."""
        truth = self.world.truth()
        poses: dict[str, TrackedPose] = {}
        for name, true in truth.vehicles.items():
            dx, dy, dyaw, dvx, dvy = (float(v) for v in self._rng.normal(0, (0.003, 0.003, 0.009, 0.02, 0.02)))
            pose = SE2(true.x + dx, true.y + dy, true.yaw + dyaw)
            vx, vy = true.linear_mps * math.cos(true.yaw) + dvx, true.linear_mps * math.sin(true.yaw) + dvy
            covariance = (1e-5, 0.0, 0.0, 1e-5, 0.0, 1e-4)
            poses[name] = TrackedPose(
                name, truth.stamp_ns, pose.x, pose.y, pose.yaw, vx, vy, true.angular_radps, covariance, (self.camera,)
            )
        return poses


def empty_world() -> World:
    """Nothing in view of cam0 and cam1."""
    world = World(LAB)
    for index, vehicle in enumerate(world.vehicle_ids):
        world.place(vehicle, SE2(7.6, 0.6 + index, 0.0))
    return world


def distances(points: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """From each point (N, 2) to the nearest of the others (M, 2), shape (N,)."""
    return np.linalg.norm(points[:, None] - others[None], axis=2).min(axis=1)
