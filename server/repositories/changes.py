"""The feed of changed documents: tells which hash to read again, survives a restart of Redis.

Whoever obeys or shows documents reads all of them when the feed begins or has reconnected (`None`), and after that only
the hashes that it names.
"""

import logging
from collections.abc import AsyncGenerator
from typing import Any, cast

from protocol.bus import UNAVAILABLE, Bus
from protocol.clock import Clock
from server.repositories.documents import CHANGED

_logger = logging.getLogger(__name__)
_FIRST_RETRY_S, _LAST_RETRY_S = 0.05, 1.0
_IDLE_S = 1.0


async def changes(bus: Bus, clock: Clock) -> AsyncGenerator[str | None, None]:
    """Keys of changed hashes for ever; None whenever some may have been missed (the start, a reconnection).

    Cancel the task or close the generator to end it.
    """
    delay_s = _FIRST_RETRY_S
    while True:
        try:
            async with bus.redis.pubsub(ignore_subscribe_messages=True) as pubsub:
                await pubsub.subscribe(CHANGED)
                await pubsub.ping()  # pyright: ignore[reportGeneralTypeIssues]  # raises unless Redis has us
                yield None
                delay_s = _FIRST_RETRY_S
                while True:
                    item = cast("dict[str, Any] | None", await pubsub.get_message(timeout=_IDLE_S))
                    if item is None:
                        await pubsub.ping()  # pyright: ignore[reportGeneralTypeIssues]  # notices a dead connection
                    elif item["type"] == "message":
                        yield cast("bytes", item["data"]).decode(errors="replace")
        except UNAVAILABLE as error:
            _logger.warning("Redis is out of reach, retrying in %.2f s: %s", delay_s, error)
            await clock.sleep(delay_s)
            delay_s = min(_LAST_RETRY_S, delay_s * 2)
