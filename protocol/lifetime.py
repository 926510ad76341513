"""The life of a process that is a few endless asyncio tasks: until one fails, or until SIGTERM or SIGINT."""

import asyncio
import gc
import signal
from collections.abc import Coroutine
from typing import Any

import uvloop

_CANCEL_EVERY_S = 0.1
_COLLECT_AFTER = (20_000, 20, 20)
"""Containers that are new, then collections of each generation, before the next older one's (Python: 700, 10, 10)."""


def run(work: Coroutine[Any, Any, None]) -> None:
    """As `asyncio.run`, on libuv's loop: a process that mostly passes datagrams on takes a tenth less processor time.

    What was made before stays until the end, so the garbage collector need not look through it: imported modules are some
    hundred thousand objects, and a look through them holds up everything for a tenth of a second, several times a second where
    thousands of messages come and go.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(*_COLLECT_AFTER)
    with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
        runner.run(work)


async def run_until_signal(*works: Coroutine[Any, Any, None]) -> None:
    """Runs all of them; raises what the first one to fail raised, when all have ended.

    They are cancelled again and again until they have ended: redis-py (8.1) loses a cancellation that arrives while it
    connects, and a task that lost its only one would run for ever.
    """
    loop, asked = asyncio.get_running_loop(), asyncio.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, asked.set)
    tasks = [asyncio.ensure_future(work) for work in works]
    stop = asyncio.ensure_future(asked.wait())
    try:
        await asyncio.wait([stop, *tasks], return_when=asyncio.FIRST_COMPLETED)
    finally:
        running = {task for task in (stop, *tasks) if not task.done()}
        while running:
            for task in running:
                task.cancel()
            _, running = await asyncio.wait(running, timeout=_CANCEL_EVERY_S)
    for task in tasks:
        if not task.cancelled() and (error := task.exception()) is not None:
            raise error
