"""Whatever stops a robot stops the real agent's base: silence, emergency stops, its own scanner, orders to wait."""

import asyncio
from itertools import pairwise

import pytest

from agents.link.stops import LOOPBACK_BROADCAST
from agents.motion import STOP
from launcher.stop_broadcast import StopBroadcast
from protocol.messages import EmergencyStop, ReasonCode
from tests.agents.agent_world import KEY, LAB, ROBOT, World
from tests.agents.waiting import until


async def test_stands_still_without_a_command_and_says_why(world: World) -> None:
    await until(lambda: world.server.statuses and world.server.statuses[-1].x is not None, "a localized status")
    status = world.server.statuses[-1]
    assert status.stopped_by is not None and status.stopped_by.code is ReasonCode.COMMAND_STALE
    assert all(twist == STOP for _, twist in world.base.setpoints)
    await until(lambda: len(world.base.setpoints) > 10, "zero commanded, not just left unsaid")


@pytest.mark.alone
async def test_stops_half_a_second_after_commands_fall_silent(world: World) -> None:
    world.go()
    await world.moving()
    world.order = None
    await world.still()
    stopped_s = world.first_zero_after(world.last_command_s)
    assert stopped_s is not None
    assert 0.45 <= stopped_s - world.last_command_s <= 0.75
    await until(lambda: world.server.statuses[-1].stopped_by is not None, "the reason")
    reason = world.server.statuses[-1].stopped_by
    assert reason is not None and reason.code is ReasonCode.COMMAND_STALE


@pytest.mark.alone
async def test_stops_half_a_second_after_poses_fall_silent(world: World) -> None:
    world.go()
    await world.moving()
    world.camera_works = False
    silent_s = world.clock.monotonic_s()
    await world.still()
    stopped_s = world.first_zero_after(silent_s)
    assert stopped_s is not None and 0.3 <= stopped_s - silent_s <= 0.75
    world.camera_works = True
    await world.moving()


async def test_an_order_to_wait_is_obeyed_at_once(world: World) -> None:
    world.go()
    await world.moving()
    world.order = None
    before = len(world.base.setpoints)
    command = world.orders.waiting(world.clock.now_ns())
    assert world.agent is not None
    world.server.send(command)
    await until(lambda: any(t == STOP for _, t in world.base.setpoints[before:]), "the stop")
    await world.still()
    assert world.agent.pilot.gate.current == command


@pytest.mark.alone
async def test_an_emergency_stop_stops_at_once_and_holds_until_released(world: World) -> None:
    world.go()
    await world.moving()
    world.server.send(EmergencyStop(engaged=True, epoch=1, by="anna", reason="smoke"))
    sent_s = world.clock.monotonic_s()
    await world.still()
    stopped_s = world.first_zero_after(sent_s)
    assert stopped_s is not None and stopped_s - sent_s < 0.2  # of which 0.1 s is for a busy machine
    assert len([t for at, t in world.base.setpoints if at > sent_s and t != STOP]) <= 2, (
        "one on its way, one more at most"
    )
    await asyncio.sleep(0.7)
    assert not [t for at, t in world.base.setpoints if at > stopped_s and t != STOP]
    status = world.server.statuses[-1]
    assert status.stopped_by is not None and status.stopped_by.code is ReasonCode.EMERGENCY_STOP
    world.server.send(EmergencyStop(engaged=False, epoch=2))
    await world.moving()


@pytest.mark.alone
async def test_what_is_in_the_protective_field_stops_it_whatever_the_server_says(world: World) -> None:
    world.go()
    await world.moving()
    world.base.ranges_mm = [160] * 5  # 0.11 m before its front: at 0.25 m/s the field reaches 0.13 m
    seen_s = world.clock.monotonic_s()
    await world.still()
    stopped_s = world.first_zero_after(seen_s)
    assert stopped_s is not None and stopped_s - seen_s < 0.15  # of which 0.1 s is for a busy machine
    await until(lambda: world.server.statuses[-1].stopped_by is not None, "the reason")
    reason = world.server.statuses[-1].stopped_by
    assert reason is not None and reason.code is ReasonCode.PROTECTIVE_FIELD
    assert reason.since_ns is not None and 0 <= world.clock.now_ns() - reason.since_ns < 2_000_000_000
    world.base.ranges_mm = [0] * 5
    await world.moving()
    assert world.clock.monotonic_s() - stopped_s > 0.9, "clear for a while first"


async def test_a_silent_scanner_stops_it(world: World) -> None:
    world.go()
    await world.moving()
    world.base.scans = False
    await world.still()
    await until(lambda: world.server.statuses[-1].faults, "the fault")
    assert "safety scanner" in world.server.statuses[-1].faults[0]


async def test_answers_to_a_stop_by_broadcast_leave_no_gap_in_the_servers_statuses(world: World) -> None:
    clock, statuses = world.clock, world.server.statuses
    await until(lambda: len(statuses) > 1, "statuses")
    for number in range(3):
        stop = EmergencyStop(engaged=True, epoch=number + 1, stamp_ns=clock.now_ns(), by="anna")
        await StopBroadcast(KEY, clock, [ROBOT]).send(stop, [(LOOPBACK_BROADCAST, LAB.ports.stop_udp)], "127.0.0.1")
    told = len(statuses)
    await until(lambda: len(statuses) > told + 1, "more statuses")
    assert {later.sequence - before.sequence for before, later in pairwise(statuses)} == {1}


@pytest.mark.alone
async def test_a_stop_by_broadcast_stops_it_with_a_dead_server_and_until_a_newer_release(world: World) -> None:
    world.go()
    await world.moving()
    await world.server.stop()
    clock = world.clock
    stop = EmergencyStop(engaged=True, epoch=clock.now_ns() // 1_000_000, stamp_ns=clock.now_ns(), by="anna")
    broadcast = StopBroadcast(KEY, clock, [ROBOT])
    sent_s = clock.monotonic_s()
    await broadcast.send(stop, [(LOOPBACK_BROADCAST, LAB.ports.stop_udp)], "127.0.0.1")
    stopped_s = world.first_zero_after(sent_s)
    assert stopped_s is not None and stopped_s - sent_s < 0.2, "not after half a second without commands"
    assert broadcast.answers[ROBOT].stop_epoch == stop.epoch
    await world.server.start()
    await until(lambda: world.server.streams, "the stream")
    assert world.server.latch.engaged is False
    await asyncio.sleep(0.5)
    assert world.speed == 0.0
    await until(lambda: world.server.statuses[-1].stop_epoch == stop.epoch, "a status that tells the server")
    world.server.send(EmergencyStop(engaged=False, epoch=stop.epoch + 1))
    await world.moving()


async def test_an_emergency_stop_survives_a_restart_of_the_server(world: World) -> None:
    world.go()
    await world.moving()
    world.server.send(EmergencyStop(engaged=True, epoch=1))
    await world.still()
    await world.server.stop()
    await world.server.start()
    registrations = len(world.server.registrations)
    await until(lambda: world.server.streams, "a new stream", 10.0)
    await until(lambda: len(world.server.registrations) > registrations, "a new registration, before it is due", 2.0)
    await asyncio.sleep(0.4)
    assert world.speed == 0.0
    world.server.send(EmergencyStop(engaged=False, epoch=2))
    await world.moving()
