"""A drive for the tests of pose estimators: a plant with wheels that lie, odometry at 20 Hz, and a camera that is late."""

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from agents.estimation import PoseEstimator
from agents.motion import Twist
from geometry import SE2
from protocol.messages import TrackedPose
from tests.agents.plant import Plant, tracked

START_NS = 1_700_000_000_000_000_000
MS = 1_000_000


def weaving(t: float) -> Twist:
    """Half a metre a second in bends."""
    return Twist(0.5, 0.8 if int(t / 4.0) % 2 else -0.8)


@dataclass
class FusionDrive:
    """`camera_works`, `spoil` (what the camera makes of a pose) and `stamps_late_ms` may be changed on the way."""

    estimator: PoseEstimator
    twist: Callable[[float], Twist] = weaving
    camera_every_ms: int = 70
    delay_ms: int = 150
    noise_m: float = 0.01
    noise_rad: float = 0.02
    distance_scale: float = 1.0
    turn_scale: float = 1.0
    stamps_late_ms: int = 0
    camera_works: bool = True
    spoil: Callable[[SE2], SE2] = lambda pose: pose
    plant: Plant = field(init=False)
    ms: int = 0

    def __post_init__(self) -> None:
        self.plant = Plant(SE2(3.0, 1.0, 2.5), distance_scale=self.distance_scale, turn_scale=self.turn_scale)
        self._rng = random.Random(7)
        self._waiting: list[tuple[int, TrackedPose]] = []

    @property
    def now_ns(self) -> int:
        return START_NS + self.ms * MS

    def run(self, seconds: float) -> Iterator[float]:
        """Drives on; the position error (m) at 20 Hz, as soon as there is an estimate."""
        for _ in range(round(seconds * 200)):
            self.ms += 5
            self.plant.setpoint = self.twist(self.ms / 1e3)
            self.plant.step(0.005)
            if self.ms % self.camera_every_ms == 0 and self.camera_works:
                self._waiting.append((self.ms + self.delay_ms, self._seen()))
            while self._waiting and self._waiting[0][0] <= self.ms:
                self.estimator.add_camera_pose(self._waiting.pop(0)[1])
            if self.ms % 50 == 0:
                self.estimator.add_odometry(self.plant.reading(self.now_ns))
                pose = self.estimator.estimate(self.now_ns).pose
                if pose is not None:
                    yield pose.distance_to(self.plant.pose)

    def _seen(self) -> TrackedPose:
        noise, pose = self._rng.gauss, self.spoil(self.plant.pose)
        seen = SE2(
            pose.x + noise(0.0, self.noise_m), pose.y + noise(0.0, self.noise_m), pose.yaw + noise(0.0, self.noise_rad)
        )
        variance = self.noise_m**2
        return tracked(
            "r",
            seen,
            self.now_ns + self.stamps_late_ms * MS,
            covariance=(variance, 0.0, 0.0, variance, 0.0, self.noise_rad**2),
        )
