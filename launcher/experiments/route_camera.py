"""The ceiling camera of the route experiment: what the tracker would tell of one vehicle, made from the truth while it drives."""

import heapq
import math

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from launcher.experiments.fusion_camera import Camera
from protocol.lab import VehicleSpec
from protocol.messages import TrackedPose, TruePose

_OUTLIER_M = (0.1, 2.0)
_JITTER = 0.2


class CeilingCamera:
    """Sees the vehicle's tag with the noise, the outliers and the delay of its `Camera`; the tag's place on the vehicle is
    rotated out with the tag's noisy heading, as the tracker does it. Gaps are not made."""

    def __init__(self, camera: Camera, vehicle: VehicleSpec, seed: int) -> None:
        self._camera = camera
        self._vehicle = vehicle
        self._rng = np.random.default_rng([seed, 78])
        self._next_s = float(self._rng.uniform(0.0, 1.0 / camera.rate_hz))
        self._on_the_way: list[tuple[int, int, TrackedPose]] = []

    def look(self, true: TruePose, now_ns: int, now_s: float) -> list[TrackedPose]:
        """Captures when it is time; the poses that have arrived by now."""
        while now_s >= self._next_s:
            self._next_s += 1.0 / self._camera.rate_hz
            delay_s = self._camera.delay_s * (1.0 + float(self._rng.uniform(-_JITTER, _JITTER)))
            heapq.heappush(self._on_the_way, (now_ns + round(delay_s * 1e9), now_ns, self._seen(true, now_ns)))
        arrived: list[TrackedPose] = []
        while self._on_the_way and self._on_the_way[0][0] <= now_ns:
            arrived.append(heapq.heappop(self._on_the_way)[2])
        return arrived

    def _seen(self, true: TruePose, now_ns: int) -> TrackedPose:
        camera, tag = self._camera, self._vehicle.tag.pose_on_vehicle()
        noise = self._rng.standard_normal(3) * (camera.sigma_m, camera.sigma_m, camera.sigma_rad)
        noise += self._outlier()
        at = SE2(true.x, true.y, true.yaw) @ tag
        pose = SE2(at.x + float(noise[0]), at.y + float(noise[1]), at.yaw + float(noise[2])) @ tag.inverse()
        # An error of the heading moves the rotation centre around the tag.
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        gx, gy = s * tag.x + c * tag.y, -c * tag.x + s * tag.y
        own, turned = camera.sigma_m**2, camera.sigma_rad**2
        covariance = (
            own + turned * gx * gx,
            turned * gx * gy,
            turned * gx,
            own + turned * gy * gy,
            turned * gy,
            turned,
        )
        return TrackedPose(
            vehicle=self._vehicle.id,
            stamp_ns=now_ns,
            x=pose.x,
            y=pose.y,
            yaw=pose.yaw,
            vx=true.linear_mps * math.cos(true.yaw),
            vy=true.linear_mps * math.sin(true.yaw),
            yaw_rate=true.angular_radps,
            covariance=covariance,
            cameras=("camera",),
        )

    def _outlier(self) -> NDArray[np.float64]:
        """What is added to a pose (3,): nothing but for the share; half of the wrong ones are turned too."""
        chosen = self._rng.random() < self._camera.outliers
        distance = math.exp(self._rng.uniform(*np.log(_OUTLIER_M)))
        direction, turn = self._rng.uniform(-math.pi, math.pi, 2)
        turned = turn if self._rng.random() < 0.5 else 0.0
        return np.array([distance * math.cos(direction), distance * math.sin(direction), turned]) * chosen
