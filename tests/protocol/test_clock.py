"""The simulated clock wakes sleepers in order and at their own time; the system's clock agrees with the machine."""

import asyncio
import time

from hypothesis import given
from hypothesis import strategies as st

from protocol.clock import Clock, SimulatedClock, SystemClock


async def test_sleepers_wake_in_the_order_of_their_deadlines() -> None:
    clock = SimulatedClock()
    woken: list[tuple[str, float]] = []

    async def sleeper(name: str, *seconds: float) -> None:
        for each in seconds:
            await clock.sleep(each)
            woken.append((name, clock.monotonic_s()))

    async with asyncio.TaskGroup() as group:
        group.create_task(sleeper("a", 0.3, 0.3))
        group.create_task(sleeper("b", 0.1, 0.1, 0.1, 0.1))
        await clock.advance(0.35)
        assert woken == [("b", 0.1), ("b", 0.2), ("a", 0.3), ("b", 0.3)]
        await clock.advance(1.0)
    assert woken[4:] == [("b", 0.4), ("a", 0.6)]
    assert clock.monotonic_s() == 1.35


async def test_equal_deadlines_wake_in_the_order_of_falling_asleep() -> None:
    clock = SimulatedClock()
    woken: list[int] = []

    async def sleeper(number: int) -> None:
        await clock.sleep(1.0)
        woken.append(number)

    async with asyncio.TaskGroup() as group:
        for number in range(5):
            group.create_task(sleeper(number))
        await clock.advance(1.0)
    assert woken == list(range(5))


async def test_nobody_wakes_early_and_a_cancelled_sleeper_holds_nothing_up() -> None:
    clock = SimulatedClock()
    task = asyncio.ensure_future(clock.sleep(1.0))
    other = asyncio.ensure_future(clock.sleep(2.0))
    await clock.advance(0.999)
    assert not task.done()
    task.cancel()
    await clock.advance(1.001)
    assert task.cancelled()
    assert other.done()


async def test_sleeping_no_time_lets_others_run() -> None:
    clock = SimulatedClock()
    await asyncio.wait_for(clock.sleep(0.0), 1)
    await asyncio.wait_for(clock.sleep(-1.0), 1)
    assert clock.monotonic_s() == 0.0


@given(st.lists(st.floats(0, 100), max_size=20))
def test_waiting_moves_both_clocks_by_the_same(steps: list[float]) -> None:
    clock = SimulatedClock(start_ns=1000)
    for step in steps:
        clock.wait(step)
    assert clock.now_ns() - 1000 == round(clock.monotonic_s() * 1e9)
    assert abs(clock.monotonic_s() - sum(steps)) < 1e-6


async def test_the_system_clock_is_the_machines() -> None:
    clock: Clock = SystemClock()
    before = time.time_ns(), time.monotonic()
    clock.wait(0.001)
    clock.wait(-1.0)
    await clock.sleep(0.001)
    await clock.sleep(-1.0)
    after = time.time_ns(), time.monotonic()
    assert before[0] <= clock.now_ns() - 0 <= after[0] + 10**9
    assert before[1] + 0.002 <= clock.monotonic_s() <= after[1] + 1
