"""The agent end to end, a server over HTTP and UDP and a base over UDP: it obeys, reports, and believes nobody but them."""

import asyncio

import pytest

from agents.motion import STOP
from geometry import SE2
from protocol.datagram import Verdict
from protocol.messages import Outcome
from tests.agents.agent_world import ROBOT, World
from tests.agents.orders import Orders
from tests.agents.plant import distance, tracked
from tests.agents.waiting import until


async def test_obeys_reports_and_reaches(world: World) -> None:
    world.go(1.6, 1.0, speed=0.8)
    await until(lambda: Outcome.REACHED in [r.outcome for r in world.server.responses], "reached", 15.0)
    assert distance(world.base.plant.pose, 1.6, 1.0) <= 0.15
    await world.still()
    outcomes = [r.outcome for r in world.server.responses if r.outcome != Outcome.REFUSED]
    assert outcomes == [Outcome.ACCEPTED, Outcome.REACHED]
    reached = world.server.responses[-1]
    assert reached.reached_ns is not None and reached.reached_ns >= reached.command_stamp_ns
    registration = world.server.registrations[0]
    assert registration["kind"] == "wifibot" and registration["session"]
    statuses = world.server.statuses
    assert max(status.linear_mps for status in statuses) > 0.2
    last = statuses[-1]
    assert (last.robot, last.area, last.ip, last.faults, last.stopped_by) == (ROBOT, "camp", "127.0.0.1", (), None)
    assert last.x is not None and last.y is not None
    assert distance(world.base.plant.pose, last.x, last.y) < 0.03
    assert last.battery == pytest.approx(0.9)


@pytest.mark.alone
async def test_statuses_come_ten_times_a_second(world: World) -> None:
    await until(lambda: world.server.statuses, "a status")
    before = len(world.server.statuses)
    await asyncio.sleep(1.0)
    assert 8 <= len(world.server.statuses) - before <= 12
    numbers = [status.sequence for status in world.server.statuses]
    assert numbers == sorted(set(numbers))


async def test_refuses_an_older_guidance(world: World) -> None:
    world.orders = Orders(ROBOT, epoch=7)
    world.order = world.orders.waiting
    await until(lambda: Outcome.ACCEPTED in [r.outcome for r in world.server.responses], "waiting")
    older = Orders(ROBOT, epoch=6)
    for _ in range(5):
        world.server.send(older.move_to(world.clock.now_ns(), 7.0, 1.0))
        await asyncio.sleep(0.05)
    await until(lambda: "newer guidance" in world.server.responses[-1].reason, "a refusal")
    assert [r.command_order[0] for r in world.server.responses if "newer guidance" in r.reason] == [6]
    assert all(twist == STOP for _, twist in world.base.setpoints)


async def test_garbage_on_the_command_stream_changes_nothing(world: World) -> None:
    world.go()
    await world.moving()
    for text in ("", "{}", "not JSON", '{"robot": "wifibot-14", "movement": "Fly"}', "[" * 2000):
        world.server.send(text)
    foreign = Orders("wifibot-15").waiting(world.clock.now_ns()).model_copy(update={"epoch": 99})
    world.server.send(foreign)
    await asyncio.sleep(0.5)
    assert world.speed > 0.25


async def test_forged_old_repeated_and_foreign_poses_have_no_effect(world: World) -> None:
    await until(lambda: world.server.statuses and world.server.statuses[-1].x is not None, "localized")
    assert world.agent is not None
    counts, here = world.agent.socket.counts, world.base.plant.pose
    wrong, now_ns = SE2(5.0, 3.0, 1.0), world.clock.now_ns()
    good = world.server.send_pose(tracked(ROBOT, here, now_ns))
    before = counts.undecodable, counts.foreign, dict(counts.verdicts)
    world.server.send_pose(tracked(ROBOT, wrong, now_ns + 1), key=b"not the key")
    world.server.send_bytes(b"LP" + b"\0" * 40)
    world.server.send_bytes(b"L")
    world.server.send_bytes(good)
    world.server.send_pose(tracked(ROBOT, wrong, now_ns + 2), sequence=7)
    world.server.send_pose(tracked("wifibot-15", wrong, now_ns + 3))
    await until(lambda: counts.foreign == before[1] + 1, "all datagrams")
    assert counts.undecodable == before[0] + 3
    assert counts.verdicts[Verdict.DUPLICATE] == before[2][Verdict.DUPLICATE] + 1
    assert counts.verdicts[Verdict.OUT_OF_ORDER] == before[2][Verdict.OUT_OF_ORDER] + 1
    seen = len(world.server.statuses)
    await until(lambda: len(world.server.statuses) > seen + 2, "more statuses")
    for status in world.server.statuses:
        if status.x is not None and status.y is not None:
            assert distance(here, status.x, status.y) < 0.01
