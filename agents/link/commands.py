"""The stream of commands and emergency stops: server-sent events, reconnected for ever.

The server sends something at least every 0.5 s, a comment line if nothing else, so a second of silence means that the
connection is dead. The first event of each stream is the state of the emergency stop.
"""

import logging
from collections.abc import Callable
from contextlib import aclosing

import httpx
from httpx_sse import ServerSentEvent, SSEError, aconnect_sse

from agents.link.backoff import Backoff, Trouble
from agents.link.http import SLOW_RETRY_S, is_hopeless, sentence
from protocol.clock import Clock
from protocol.codec import decode
from protocol.errors import DecodeError
from protocol.messages import Command, EmergencyStop

SILENCE_S = 1.0
_logger = logging.getLogger(__name__)


class CommandStream:
    """Hands each event to its handler in the order in which they come; what does not decode is counted and left out."""

    def __init__(
        self,
        client: httpx.AsyncClient,
        robot: str,
        clock: Clock,
        *,
        on_open: Callable[[], None],
        on_command: Callable[[Command], None],
        on_emergency_stop: Callable[[EmergencyStop], None],
    ) -> None:
        self.trouble = Trouble(_logger, "commands")
        self._client = client
        self._path = f"/api/robots/{robot}/commands"
        self._clock = clock
        self._on_open = on_open
        self._on_command = on_command
        self._on_emergency_stop = on_emergency_stop
        self._backoff = Backoff()

    async def run(self) -> None:
        """For ever."""
        while True:
            delay_s: float | None = None
            try:
                await self._follow()
                self.trouble.note("the server ended the stream")
            except (httpx.HTTPError, SSEError) as error:
                self.trouble.note(sentence(error))
                if isinstance(error, httpx.HTTPStatusError) and is_hopeless(error.response.status_code):
                    delay_s = SLOW_RETRY_S
            await self._clock.sleep(self._backoff.next_s() if delay_s is None else delay_s)

    async def _follow(self) -> None:
        """One connection, until it ends."""
        timeout = httpx.Timeout(SILENCE_S)
        async with aconnect_sse(self._client, "GET", self._path, timeout=timeout) as source:
            source.response.raise_for_status()
            self._on_open()
            async with aclosing(source.aiter_sse()) as events:
                async for event in events:
                    self._backoff.reset()
                    self.trouble.over()
                    self._dispatch(event)

    def _dispatch(self, event: ServerSentEvent) -> None:
        """Kinds of events that this agent does not know are left to newer ones."""
        try:
            if event.event == "emergency_stop":
                self._on_emergency_stop(decode(EmergencyStop, event.data))
            elif event.event == "command":
                self._on_command(decode(Command, event.data))
        except DecodeError as error:
            _logger.warning("ignored an event of the command stream: %s", error)
