"""The history: who did what, and what went wrong; a capped stream."""

import logging

from protocol.bus import Bus
from protocol.channels import EVENTS, LAB_INSTANCE
from protocol.errors import BusUnavailableError
from protocol.messages import Event

_logger = logging.getLogger(__name__)


async def record(bus: Bus, event: Event) -> None:
    """Adds a line that is not part of a transaction; it only goes to the log while Redis is out of reach."""
    try:
        await bus.publish(EVENTS, LAB_INSTANCE, event)
    except BusUnavailableError as error:
        _logger.warning("%s (%s)", event.text, error)
