"""Poses leave by every output that is switched on; Redis out of reach costs the others nothing."""

import asyncio
import logging

import pytest

from localization.outputs import RedisPoses, UdpSender, outputs_of
from protocol.bus import Bus
from protocol.channels import POSES
from protocol.clock import SimulatedClock
from protocol.lab import GulliViewOutput, Output
from protocol.lab import Outputs as OutputsSettings
from tests.localization.outputs.listeners import Ear, pose
from tests.localization.synthetic import small_lab
from tests.redis_fixture import RedisServer


@pytest.mark.parametrize("bus_on", [True, False])
async def test_outputs_are_as_the_lab_says(
    redis_server: RedisServer,
    sender: UdpSender,
    clock: SimulatedClock,
    ears: tuple[Ear, Ear],
    caplog: pytest.LogCaptureFixture,
    bus_on: bool,
) -> None:
    settings = OutputsSettings(
        redis=Output(enabled=bus_on),
        datagrams=Output(enabled=not bus_on),
        gulliview=(
            GulliViewOutput(layout="gulliview-2023", host="127.0.0.1", port=ears[1].port),
            GulliViewOutput(layout="gulliview-2025", host="127.0.0.1", port=ears[1].port, enabled=False),
        ),
    )
    lab = small_lab().model_copy(update={"outputs": settings})
    bus = Bus.connect(redis_server.url)
    outputs = outputs_of(lab, bus, sender, clock, None)
    outputs.register(ears[0].registration("robot-10"))
    outputs.send([pose()])
    await outputs.publish([pose()])
    assert len(ears[0].all()) == (0 if bus_on else 1)
    assert len(ears[1].all()) == 1
    assert await bus.latest_all(POSES) == ({"robot-10": pose()} if bus_on else {})
    assert "area 'room' reaches x = -0.5 m and y = -0.5 m" in caplog.text
    assert ("outputs.redis is off" in caplog.text) == (not bus_on)
    await bus.close()


async def test_redis_out_of_reach_costs_nobody_a_datagram(
    redis_server: RedisServer, sender: UdpSender, clock: SimulatedClock, ears: tuple[Ear, Ear]
) -> None:
    bus = Bus.connect(redis_server.url)
    poses = RedisPoses(bus, clock, Output())
    await poses.publish([pose()])
    redis_server.kill()
    await poses.publish([pose()])
    assert poses.published == 1
    assert bus.dropped == 1
    await bus.close()


async def test_what_was_sent_stands_in_the_log(
    redis_server: RedisServer,
    sender: UdpSender,
    clock: SimulatedClock,
    ears: tuple[Ear, Ear],
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.INFO)
    bus = Bus.connect(redis_server.url)
    outputs = outputs_of(small_lab(), bus, sender, clock, None)
    running = asyncio.ensure_future(outputs.run(clock))
    outputs.register(ears[0].registration("robot-10"))
    await asyncio.sleep(0)
    outputs.send([pose()])
    await clock.advance(61)
    assert "poses out: datagrams to robot-10: 1 sent, 0 failed; Redis: 0 published" in caplog.text
    running.cancel()
    with pytest.raises(asyncio.CancelledError):
        await running
    await bus.close()
