"""Where vehicles truly were, from moment to moment, while something else was done."""

import math
import threading
from collections.abc import Sequence
from typing import cast

from protocol import keys
from protocol.channels import GROUND_TRUTH, LAB_INSTANCE
from protocol.codec import decode
from protocol.messages import GroundTruth
from tests.e2e.system import RunningSystem


class Odyssey:
    """Every true pose of the vehicles from entering on, as the lab publishes them."""

    def __init__(self, system: RunningSystem) -> None:
        self._redis = system.redis
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self.truths: list[GroundTruth] = []

    def __enter__(self) -> "Odyssey":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(5)

    def nearest_m(self, vehicle: str, point: tuple[float, float]) -> float:
        """How close the vehicle's rotation centre came to the point."""
        poses = [truth.vehicles[vehicle] for truth in self.truths]
        return min(math.dist(point, (pose.x, pose.y)) for pose in poses)

    def all_stand_since(self, stamp_ns: float, vehicles: Sequence[str]) -> int | None:
        """When, after `stamp_ns`, none of them moved for the first time."""
        for truth in self.truths:
            if truth.stamp_ns > stamp_ns and all(abs(truth.vehicles[name].linear_mps) < 1e-3 for name in vehicles):
                return truth.stamp_ns
        return None

    def _run(self) -> None:
        while not self._stop.wait(0.01):
            raw = cast("bytes | None", self._redis.hget(keys.live(GROUND_TRUTH.name), LAB_INSTANCE))
            if raw is not None:
                truth = decode(GroundTruth, raw)
                if not self.truths or truth.stamp_ns > self.truths[-1].stamp_ns:
                    self.truths.append(truth)
