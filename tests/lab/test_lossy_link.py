"""The simulated network loses, doubles and delays as described."""

import pytest

from lab.network import LossyLink
from protocol.lab import SimulatedNetwork


def passed(network: SimulatedNetwork, count: int = 2000, seed: int = 1) -> list[int]:
    link: LossyLink[int] = LossyLink(network, [seed])
    for number in range(count):
        link.send(number, 0.0)
    return link.due(100.0)


def test_a_perfect_network_changes_nothing() -> None:
    assert passed(SimulatedNetwork()) == list(range(2000))


def test_loss_and_duplication_have_their_shares() -> None:
    lossy = passed(SimulatedNetwork(loss=0.2))
    assert len(lossy) == pytest.approx(1600, abs=100)
    assert lossy == sorted(set(lossy))
    doubled = passed(SimulatedNetwork(duplication=0.1))
    assert len(doubled) == pytest.approx(2200, abs=60)
    assert sorted(set(doubled)) == list(range(2000))


def test_delay_is_a_floor_and_jitter_changes_the_order() -> None:
    link: LossyLink[int] = LossyLink(SimulatedNetwork(delay_s=0.1, jitter_s=0.05), [1])
    for number in range(100):
        link.send(number, number * 0.01)
    assert link.due(0.0999) == []
    arrived = link.due(0.5)
    assert arrived
    assert max(arrived) <= 40, "nothing is early"
    arrived += link.due(10.0)
    assert sorted(arrived) == list(range(100))
    assert arrived != sorted(arrived)


def test_the_same_seed_loses_the_same() -> None:
    network = SimulatedNetwork(loss=0.3, duplication=0.1, jitter_s=0.1)
    assert passed(network, seed=4) == passed(network, seed=4) != passed(network, seed=5)
