"""Processes of a few endless tasks end when told, also when a library loses the cancellation."""

import asyncio
import os
import signal
from contextlib import suppress

import pytest

from protocol.lifetime import run_until_signal


async def deaf() -> None:
    """Loses its first cancellation, as redis-py does while it connects."""
    with suppress(asyncio.CancelledError):
        await asyncio.Event().wait()
    await asyncio.Event().wait()


async def test_a_signal_ends_even_what_loses_a_cancellation() -> None:
    ended: list[str] = []

    async def polite() -> None:
        try:
            await asyncio.Event().wait()
        finally:
            ended.append("polite")

    asyncio.get_running_loop().call_later(0.05, os.kill, os.getpid(), signal.SIGTERM)
    async with asyncio.timeout(5):
        await run_until_signal(deaf(), polite())
    assert ended == ["polite"]


async def test_what_fails_ends_the_rest_and_is_raised() -> None:
    async def fails() -> None:
        raise ValueError("broken")

    async with asyncio.timeout(5):
        with pytest.raises(ValueError, match="broken"):
            await run_until_signal(deaf(), fails())
