"""Waits for a condition with a deadline."""

import asyncio
from collections.abc import Callable


async def until(condition: Callable[[], object], what: str, seconds: float = 5.0) -> None:
    """AssertionError, with what was waited for, when it does not come about in time."""
    try:
        async with asyncio.timeout(seconds):
            while not condition():  # noqa: ASYNC110  # conditions of several parties, some of them uvicorn's
                await asyncio.sleep(0.005)
    except TimeoutError:
        raise AssertionError(f"not within {seconds} s: {what}") from None
