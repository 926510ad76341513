"""A simulated ceiling camera: the floor rendered once, then in each frame only what moves, and the sensor's noise."""

import math

import numpy as np

from geometry import SE2
from lab.rendering.floor import light_at, render_floor
from lab.rendering.layers import Layer, LayerPainter, Window
from lab.rendering.noise import SensorNoise
from lab.rendering.optics import Optics
from lab.rendering.shapes import Shape, pallet_shape, person_shape, vehicle_shape
from lab.rendering.textures import UInt8
from lab.snapshot import ObjectSnapshot, Snapshot, VehicleSnapshot
from lab.truth import true_camera_model, true_vehicle
from protocol.lab import Lab

_COVER_LEVEL = 12


class CameraRenderer:
    """Renders what one camera of the lab sees. Not for several threads at once; same seed, snapshots and frame numbers:
    same pixels. `seed` None takes the lab description's. KeyError for an unknown camera, ValueError for one without a mount.

    Faults: `covered` is a part of the image (x0, y0, x1, y1 in pixels) that something hangs in front of; `frozen` shows
    the next frame for ever.
    """

    def __init__(self, lab: Lab, camera_id: str, seed: int | None = None) -> None:
        self.spec = lab.camera(camera_id)
        mount = lab.simulation.mounts.get(camera_id)
        if mount is None:
            raise ValueError(f"camera {camera_id!r} has no entry in simulation.mounts")
        seed = lab.simulation.seed if seed is None else seed
        image = lab.simulation.image
        self.covered: Window | None = None
        self.frozen = False
        self._lab = lab
        self._channels = 3 if self.spec.color else 1
        self._optics = Optics(true_camera_model(lab, self.spec, seed), mount)
        self._floor = render_floor(lab, self._optics, seed, self._channels)
        self._canvas = self._floor.copy()
        self._painter = LayerPainter(self._optics, self._channels, image.blur_sigma_px)
        self._noise = SensorNoise(self._floor.shape, image.noise_std, seed, camera_id)
        simulated = [true_vehicle(lab, vehicle, seed) for vehicle in lab.vehicles if vehicle.driver == "sim"]
        self._vehicles = {vehicle.id: vehicle_shape(vehicle, self._channels) for vehicle in simulated}
        self._pallet = pallet_shape(self._channels)
        self._people: dict[str, Shape] = {}
        self._layers: dict[str, tuple[VehicleSnapshot | ObjectSnapshot, Layer | None]] = {}
        self._dirty: list[Window] = []
        self._last: UInt8 | None = None
        rays = self._optics.slopes.reshape(-1, 2)
        drop = self._optics.position[2]
        self._view_low = self._optics.position[:2] + drop * rays.min(axis=0)
        self._view_high = self._optics.position[:2] + drop * rays.max(axis=0)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the images: (height, width) for grey, (height, width, 3) for BGR."""
        height, width, _ = self._floor.shape
        return (height, width) if self._channels == 1 else (height, width, 3)

    def render(self, snapshot: Snapshot, frame_number: int, out: UInt8 | None = None) -> UInt8:
        """The frame whose exposure is centred on the snapshot's instant, dtype uint8; written to `out` when given."""
        target = np.empty(self.shape, dtype=np.uint8) if out is None else out
        if self.frozen and self._last is not None:
            np.copyto(target, self._last)
            return target
        for x0, y0, x1, y1 in self._dirty:
            self._canvas[y0:y1, x0:x1] = self._floor[y0:y1, x0:x1]
        self._dirty.clear()
        layers = self._seen(snapshot)
        for layer in layers:
            layer.darken(self._canvas)
        for layer in layers:
            layer.draw(self._canvas)
            self._dirty.extend(layer.windows())
        if self.covered is not None:
            x0, y0, x1, y1 = self.covered
            self._canvas[y0:y1, x0:x1] = _COVER_LEVEL
            self._dirty.append(self.covered)
        self._noise.add(self._canvas, frame_number, target.reshape(self._floor.shape))
        self._last = target.copy() if self.frozen else None
        return target

    def _seen(self, snapshot: Snapshot) -> list[Layer]:
        """Layers from the back to the front: a ray from the ceiling meets what is nearer to the camera's foot first."""
        foot_x, foot_y = float(self._optics.position[0]), float(self._optics.position[1])
        present: list[tuple[float, str, Layer]] = []
        known = self._layers
        self._layers = {}
        for item in (*snapshot.vehicles, *snapshot.objects):
            shape = self._shape_of(item)
            if shape is None or not self._may_see(item, shape):
                continue
            key = f"{type(item).__name__}:{item.id}"
            before = known.get(key)
            # What stands still looks the same as in the frame before.
            layer = before[1] if before is not None and before[0] == item else self._paint(item, shape)
            self._layers[key] = (item, layer)
            if layer is not None:
                present.append((math.hypot(item.x - foot_x, item.y - foot_y), key, layer))
        return [layer for _, _, layer in sorted(present, key=lambda entry: (-entry[0], entry[1]))]

    def _paint(self, item: VehicleSnapshot | ObjectSnapshot, shape: Shape) -> Layer | None:
        speed, turning = (
            (item.linear_mps, item.angular_radps) if isinstance(item, VehicleSnapshot) else (item.speed_mps, 0.0)
        )
        exposure_s = self._lab.simulation.image.exposure_s
        poses = self._painter.shutter_poses(shape, SE2(item.x, item.y, item.yaw), speed, turning, exposure_s)
        return self._painter.paint(shape, poses, float(light_at(self._lab, item.x)))

    def _may_see(self, item: VehicleSnapshot | ObjectSnapshot, shape: Shape) -> bool:
        low, high = self._view_low - shape.radius_m, self._view_high + shape.radius_m
        return bool(low[0] < item.x < high[0] and low[1] < item.y < high[1])

    def _shape_of(self, item: VehicleSnapshot | ObjectSnapshot) -> Shape | None:
        if isinstance(item, VehicleSnapshot):
            return self._vehicles.get(item.id)
        if item.kind == "pallet":
            return self._pallet
        if item.id not in self._people:
            self._people[item.id] = person_shape(item.id)
        return self._people[item.id]
