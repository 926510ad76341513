"""The network between the vehicles of a scene: each direction of each pair loses, delays and doubles for itself."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lab.network import LossyLink
from protocol.lab import SimulatedNetwork
from protocol.messages.zones import ZoneMessage

GOOD = SimulatedNetwork(delay_s=0.005)


@dataclass(frozen=True, slots=True)
class Cut:
    """Between the two times nothing gets from one robot to the other (None: from, or to, any)."""

    from_s: float
    until_s: float
    source: str | None = None
    target: str | None = None

    def hits(self, source: str, target: str, now_s: float) -> bool:
        return self.from_s <= now_s < self.until_s and self.source in (None, source) and self.target in (None, target)


@dataclass(frozen=True, slots=True)
class Impairment:
    """What is wrong with the network, and until when (s): after that it only delays as a good one does."""

    network: SimulatedNetwork = GOOD
    cuts: tuple[Cut, ...] = ()
    heals_s: float = np.inf


class SceneNetwork:
    """Messages from robot to robot."""

    def __init__(self, impairment: Impairment, seed: int) -> None:
        self._impairment = impairment
        self._seed = seed
        self._links: dict[tuple[str, str, bool], LossyLink[ZoneMessage]] = {}

    def send(self, message: ZoneMessage, recipients: Iterable[str], now_s: float) -> None:
        """One message to each of them."""
        healed = now_s >= self._impairment.heals_s
        for target in recipients:
            if not any(cut.hits(message.robot, target, now_s) for cut in self._impairment.cuts):
                self._link(message.robot, target, healed).send(message, now_s)

    def due(self, target: str, now_s: float) -> list[ZoneMessage]:
        """What has arrived at that robot."""
        return [message for key, link in self._links.items() if key[1] == target for message in link.due(now_s)]

    def _link(self, source: str, target: str, healed: bool) -> LossyLink[ZoneMessage]:
        key = source, target, healed
        if key not in self._links:
            seed = [self._seed, *source.encode(), 0, *target.encode(), int(healed)]
            self._links[key] = LossyLink(GOOD if healed else self._impairment.network, seed)
        return self._links[key]
