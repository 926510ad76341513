"""Packets of the existing systems, read as their receivers do."""

import asyncio
import math
import struct

import pytest

from localization.outputs import GulliViewReceiver, UdpSender
from localization.outputs.resolving import UnresolvedHostError
from protocol.clock import SimulatedClock
from protocol.lab import GulliViewLayout, GulliViewOutput, Lab
from tests.localization.outputs.listeners import STAMP_NS, Ear, pose, until
from tests.localization.synthetic import small_lab


def receiver(
    sender: UdpSender,
    clock: SimulatedClock,
    layout: GulliViewLayout,
    ear: Ear,
    *,
    lab: Lab | None = None,
    **more: object,
) -> GulliViewReceiver:
    output = GulliViewOutput.model_validate({"layout": layout, "host": "127.0.0.1", "port": ear.port, **more})
    return GulliViewReceiver(sender, clock, lab or small_lab(), output)


def test_a_receiver_of_2025_unpacks_the_tag(sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]) -> None:
    sent = receiver(sender, clock, "gulliview-2025", ears[0])
    sent.send([pose()])
    (data,) = ears[0].all()
    assert len(data) == 256
    assert struct.unpack_from(">IIIQQII", data) == (1, 2, 0, STAMP_NS // 10**6, 0, 1, 1)
    tag_id, time_msec, x, y, z, theta, speed, camera = struct.unpack_from(">IQIIIffI", data, 36)
    assert (tag_id, time_msec, z, camera) == (10, STAMP_NS // 10**6, 300, 1)
    # The tag sits at (0.05, 0.02, 0.4) on the vehicle, which stands at (1.0, 0.5, 0.3).
    tag_x = 1.0 + 0.05 * math.cos(0.3) - 0.02 * math.sin(0.3)
    tag_y = 0.5 + 0.05 * math.sin(0.3) + 0.02 * math.cos(0.3)
    assert (y / 1000, x / 1000) == pytest.approx((tag_x, tag_y), abs=0.5e-3)
    assert math.pi / 2 - theta == pytest.approx(0.3 + 0.4, abs=1e-6)
    assert speed == pytest.approx(0.5)


def test_a_receiver_of_2023_unpacks_the_rotation_centre(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    sent = receiver(sender, clock, "gulliview-2023", ears[0], point="vehicle")
    sent.send([pose()])
    (data,) = ears[0].all()
    assert struct.unpack_from(">IIIQQII", data) == (1, 2, 0, STAMP_NS // 10**6, 0, 0, 1)
    tag_id, x, y, theta, speed, camera = struct.unpack_from(">IIIffI", data, 36)
    assert (tag_id, camera) == (10, 1)
    assert (x / 1298, y / 1298) == pytest.approx((1.0, 0.5), abs=0.5 / 1298)
    assert -theta == pytest.approx(0.3)
    assert speed == pytest.approx(0.5)


def test_the_gap_is_averaged_and_seq_rises_over_split_packets(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    lab = small_lab()
    crowd = tuple(
        lab.vehicles[0].model_copy(update={"id": f"v{n}", "tag": lab.vehicles[0].tag.model_copy(update={"id": 20 + n})})
        for n in range(14)
    )
    sent = receiver(sender, clock, "gulliview-2025", ears[0], lab=lab.model_copy(update={"vehicles": crowd}))
    for _ in range(3):
        sent.send([pose(f"v{n}") for n in range(14)])
        clock.wait(0.016)
    headers = [struct.unpack_from(">IIIQQII", data) for data in ears[0].all()]
    assert [header[2] for header in headers] == list(range(9))
    assert [header[4] for header in headers] == [0] * 3 + [16] * 6
    assert [header[6] for header in headers] == [6, 6, 2] * 3
    sent.send([])
    assert ears[0].all() == []


def test_several_receivers_have_rates_of_their_own(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    slow = receiver(sender, clock, "gulliview-2023", ears[0], rate_hz=5)
    fast = receiver(sender, clock, "gulliview-2025a", ears[1])
    for _ in range(60):
        for each in (slow, fast):
            each.send([pose()])
        clock.wait(1 / 60)
    assert len(ears[0].all()) in (5, 6)
    assert len(ears[1].all()) == 60


def test_negative_places_are_told_once_per_vehicle(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear], caplog: pytest.LogCaptureFixture
) -> None:
    sent = receiver(sender, clock, "gulliview-2025", ears[0], point="vehicle")
    for _ in range(2):
        sent.send([pose(x=-0.35), pose("robot-11")])
    assert [r.message for r in caplog.records if "negative" in r.message] == [
        "robot-10 is at (-0.35, 0.50) m: receivers of gulliview-2025 packets read negative coordinates as huge positive ones"
    ]
    data = ears[0].all()[0]
    assert struct.unpack_from(">IQII", data, 36)[3] == 2**32 - 350


async def test_a_receiver_by_name_is_looked_up_until_it_is_found(
    sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear], caplog: pytest.LogCaptureFixture
) -> None:
    known: dict[str, str] = {}

    def lookup(host: str) -> str:
        if host not in known:
            raise UnresolvedHostError(f"{host!r} has no IPv4 address: unknown")
        return known[host]

    output = GulliViewOutput(layout="gulliview-2025", host="robots.example", port=ears[0].port)
    sent = GulliViewReceiver(sender, clock, small_lab(), output, lookup)
    running = asyncio.ensure_future(sent.run())
    await until(lambda: "no gulliview-2025 packets for robots.example" in caplog.text)
    sent.send([pose()])
    assert ears[0].all() == []
    known["robots.example"] = "127.0.0.1"
    heard: list[bytes] = []

    async def found() -> None:
        while not heard:
            await clock.advance(5.0)
            await asyncio.sleep(0.002)
            sent.send([pose()])
            heard.extend(ears[0].all())

    await asyncio.wait_for(found(), 10)
    running.cancel()
    with pytest.raises(asyncio.CancelledError):
        await running
