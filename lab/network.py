"""A network that loses, doubles and delays (style: simulated devices have seeded knobs for their faults)."""

import heapq
import itertools
from typing import Generic, TypeVar

import numpy as np

from protocol.lab import SimulatedNetwork

T = TypeVar("T")


class LossyLink(Generic[T]):
    """One direction of a link. What goes in with `send` comes out of `due` once its delay is over: never, once or twice.
    Jitter may change the order, as it does on a real network."""

    def __init__(self, network: SimulatedNetwork, seed: list[int]) -> None:
        self._network = network
        self._rng = np.random.default_rng(seed)
        self._waiting: list[tuple[float, int, T]] = []
        self._order = itertools.count()

    def send(self, item: T, now_s: float) -> None:
        n = self._network
        if n.loss > 0 and self._rng.random() < n.loss:
            return
        copies = 2 if n.duplication > 0 and self._rng.random() < n.duplication else 1
        for _ in range(copies):
            # Half-normal: a delay has a floor and a tail.
            late_s = n.delay_s + (abs(float(self._rng.standard_normal())) * n.jitter_s if n.jitter_s > 0 else 0.0)
            heapq.heappush(self._waiting, (now_s + late_s, next(self._order), item))

    def due(self, now_s: float) -> list[T]:
        """Everything that has arrived by now, in the order of arrival."""
        arrived: list[T] = []
        while self._waiting and self._waiting[0][0] <= now_s:
            arrived.append(heapq.heappop(self._waiting)[2])
        return arrived
