"""Two listeners on the loopback, a clock that stands still, and the sender under test."""

from collections.abc import Iterator

import pytest

from localization.outputs import UdpSender
from protocol.clock import SimulatedClock
from tests.localization.outputs.listeners import Ear


@pytest.fixture
def ears() -> Iterator[tuple[Ear, Ear]]:
    made = Ear(), Ear()
    yield made
    for ear in made:
        ear.socket.close()


@pytest.fixture
def clock() -> SimulatedClock:
    return SimulatedClock()


@pytest.fixture
def sender(clock: SimulatedClock) -> Iterator[UdpSender]:
    with UdpSender(clock) as made:
        yield made
