"""Keeps a part of a service going."""

import logging
from collections.abc import Awaitable, Callable

from protocol.clock import Clock

_RESTART_S = 1.0
_logger = logging.getLogger(__name__)


async def for_ever(function: Callable[[], Awaitable[None]], clock: Clock) -> None:
    """What fails for a reason that nobody foresaw is logged and begun again: one bad message must not end the service."""
    while True:
        try:
            await function()
        except Exception:
            _logger.exception("%s failed, beginning again", getattr(function, "__qualname__", function))
        await clock.sleep(_RESTART_S)
