"""The history's newest lines, each read once."""

import asyncio
import logging
from collections import deque
from collections.abc import Iterator
from typing import Any, cast

from protocol import keys
from protocol.bus import Bus
from protocol.channels import EVENTS
from protocol.codec import decode
from protocol.errors import DecodeError
from protocol.messages import Event

KEY = keys.stream(EVENTS.name)
_AT_FIRST, _AT_ONCE = 50, 200
_logger = logging.getLogger(__name__)


class NewestEvents:
    """`read` gets those that are new, or at first the last fifty; `taken` hands each out once."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._last: bytes | None = None
        self._new: deque[Event] = deque(maxlen=_AT_ONCE)
        self._reading = asyncio.Lock()

    async def read(self) -> bool:
        """Whether there were any. Raises redis-py's errors while Redis is out of reach."""
        async with self._reading:
            if self._last is None:
                entries = cast("list[Any]", await self._bus.redis.xrevrange(KEY, count=_AT_FIRST))[::-1]
            else:
                after = "(" + self._last.decode()
                entries = cast("list[Any]", await self._bus.redis.xrange(KEY, min=after, count=_AT_ONCE))
            for entry_id, fields in entries:
                self._last = entry_id
                try:
                    self._new.append(decode(Event, fields[b"m"]))
                except (DecodeError, KeyError):
                    _logger.warning("ignored a damaged event")
            return bool(entries)

    def taken(self) -> Iterator[Event]:
        """Oldest first."""
        while self._new:
            yield self._new.popleft()
