"""The agent goes on when server, base or itself was restarted, and says meanwhile what is wrong."""

import asyncio

import pytest

from agents.motion import STOP
from protocol.messages import Outcome, ReasonCode
from tests.agents.agent_world import KEY, ROBOT, World
from tests.agents.fake_base import FakeBase
from tests.agents.waiting import until


async def test_survives_a_restart_of_the_server(world: World) -> None:
    world.go()
    await world.moving()
    await world.server.stop()
    await world.still()
    await world.server.start()
    await world.moving()


async def test_notices_a_server_that_hangs(world: World) -> None:
    world.go()
    await world.moving()
    world.server.mute = True
    await world.still()
    before = world.server.requests
    await until(lambda: world.server.requests > before, "a new attempt", 3.0)
    world.server.mute = False
    await world.moving()


async def test_responses_are_delivered_though_the_server_fails_at_first(world: World) -> None:
    world.server.response_failures = 3
    world.order = world.orders.waiting
    await until(lambda: Outcome.ACCEPTED in [r.outcome for r in world.server.responses], "the response")


async def test_a_wrong_token_is_told_and_tried_again_slowly(caplog: pytest.LogCaptureFixture) -> None:
    world = World()
    await world.start(token="wrong")
    try:
        await until(lambda: world.server.requests >= 2, "requests")
        await asyncio.sleep(1.0)
        assert world.server.requests <= 4
        assert "does not know the token (401)" in caplog.text
        assert world.speed == 0.0
    finally:
        await world.stop()


async def test_a_restarted_base_stops_until_it_is_aligned_again(world: World) -> None:
    world.go()
    await world.moving()
    world.base.restart()
    await world.moving()
    assert world.base.plant.odometry.x < 2.0
    x = world.base.plant.pose.x + 0.6
    world.go(x, 1.0, speed=0.8)
    await until(lambda: Outcome.REACHED in [r.outcome for r in world.server.responses], "reached", 10.0)
    assert abs(world.base.plant.pose.y - 1.0) < 0.15


async def test_a_robot_whose_base_is_gone_says_so(world: World) -> None:
    world.go()
    await world.moving()
    port = world.base.port
    await world.base.stop()
    await until(lambda: world.server.statuses[-1].faults, "a fault in the status")
    reason = world.server.statuses[-1].stopped_by
    assert reason is not None and reason.code is ReasonCode.DRIVER_FAULT
    world.base = FakeBase(ROBOT, world.base.plant.pose, KEY)
    await world.base.start(port)
    await world.moving()


async def test_the_end_of_the_agent_stops_the_base(world: World) -> None:
    world.go()
    await world.moving()
    await world.stop_agent()
    ended_s = world.clock.monotonic_s()
    await world.still()
    assert world.base.setpoints[-1][1] == STOP
    assert world.base.setpoints[-1][0] <= ended_s + 0.1


async def test_a_restarted_agent_goes_on(world: World) -> None:
    world.go()
    await world.moving()
    await world.stop_agent()
    await world.still()
    await world.start_agent()
    await world.moving()
    assert world.server.registrations[0]["session"] != world.server.registrations[-1]["session"]
