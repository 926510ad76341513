"""The Kalman filter's last seconds as a chain of moments: a camera's pose is put in at its capture time, and all that came later
is driven again (rewind and replay), in whatever order poses arrive."""

from bisect import bisect_right
from dataclasses import dataclass

from agents.estimation.ekf_belief import Belief, predicted, updated
from agents.estimation.ekf_model import Motion, Sight
from agents.estimation.ekf_noise import NoiseModel
from geometry import SE2

_MOST_NODES = 1200
"""However fast a base talks, memory and the longest replay stay bounded."""


@dataclass(slots=True)
class Node:
    """A moment of the chain: a reading of odometry, or a sight that was used. `belief` is the one after it."""

    stamp_ns: int
    T_odom_robot: SE2
    belief: Belief
    sight: Sight | None = None


class Chain:
    """Empty until `begin`; the oldest node is the ground that the others stand on."""

    def __init__(self, noise: NoiseModel) -> None:
        self._noise = noise
        self._nodes: list[Node] = []

    @property
    def newest(self) -> Node | None:
        return self._nodes[-1] if self._nodes else None

    def before(self, stamp_ns: int) -> Node | None:
        """The newest node that is not newer than the moment; None where the chain does not reach."""
        place = bisect_right(self._nodes, stamp_ns, key=_stamp)
        return self._nodes[place - 1] if place else None

    def last_before(self, stamp_ns: int) -> Node | None:
        """The same, or the oldest node; None when the chain is empty."""
        return self.before(stamp_ns) or (self._nodes[0] if self._nodes else None)

    def driven(self, node: Node, stamp_ns: int, T_odom_robot: SE2) -> Belief:
        """The belief at a moment, when odometry was there, from a node before it."""
        dt_s = (stamp_ns - node.stamp_ns) / 1e9
        if dt_s <= 0.0:
            return node.belief
        return predicted(node.belief, Motion.between(node.T_odom_robot, T_odom_robot, dt_s), self._noise)

    def begin(self, stamp_ns: int, T_odom_robot: SE2, belief: Belief) -> None:
        """A new chain of one node; what was before is forgotten."""
        self._nodes = [Node(stamp_ns, T_odom_robot, belief)]

    def insert(self, stamp_ns: int, T_odom_robot: SE2, sight: Sight | None = None) -> None:
        """Puts a moment in its place and drives it and all later ones anew. Moments before the oldest node change nothing."""
        place = bisect_right(self._nodes, stamp_ns, key=_stamp)
        if place == 0:
            return
        self._nodes.insert(place, Node(stamp_ns, T_odom_robot, self._nodes[place - 1].belief, sight))
        for before, after in zip(self._nodes[place - 1 :], self._nodes[place:], strict=False):
            belief = self.driven(before, after.stamp_ns, after.T_odom_robot)
            after.belief = belief if after.sight is None else updated(belief, after.sight, self._noise)

    def forget(self, before_ns: int) -> None:
        """Drops the nodes that no pose goes back to any more; the newest of them stays as the ground."""
        keep_from = max(bisect_right(self._nodes, before_ns, key=_stamp) - 1, len(self._nodes) - _MOST_NODES, 0)
        del self._nodes[:keep_from]

    def clear(self) -> None:
        self._nodes.clear()


def _stamp(node: Node) -> int:
    return node.stamp_ns
