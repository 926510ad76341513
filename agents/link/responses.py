"""Delivers responses to the server: in order, each at least once, however long the server is away."""

import asyncio
import logging
from collections import deque

import httpx

from agents.link.backoff import Backoff, Trouble
from agents.link.http import SLOW_RETRY_S, sentence
from protocol.clock import Clock
from protocol.codec import encode
from protocol.messages import Response

CAPACITY = 256
_RETRIED = (401, 403, 408, 425, 429)
_logger = logging.getLogger(__name__)


class ResponseQueue:
    """Bounded: when the server is away for so long that it is full, the oldest responses are dropped and counted."""

    def __init__(self, client: httpx.AsyncClient, robot: str, clock: Clock) -> None:
        self.trouble = Trouble(_logger, "responses")
        self.dropped = 0
        self._client = client
        self._path = f"/api/robots/{robot}/responses"
        self._clock = clock
        self._waiting: deque[Response] = deque()
        self._filled = asyncio.Event()

    def put(self, response: Response) -> None:
        """Never waits."""
        if len(self._waiting) >= CAPACITY:
            self._waiting.popleft()
            self.dropped += 1
        self._waiting.append(response)
        self._filled.set()

    async def run(self) -> None:
        """For ever."""
        backoff = Backoff()
        while True:
            while not self._waiting:
                self._filled.clear()
                await self._filled.wait()
            response = self._waiting[0]
            delay_s = await self._deliver(response, backoff)
            if delay_s is not None:
                await self._clock.sleep(delay_s)
                continue
            if self._waiting and self._waiting[0] is response:
                self._waiting.popleft()

    async def _deliver(self, response: Response, backoff: Backoff) -> float | None:
        """None when the response is dealt with, else the time to wait before the next attempt."""
        try:
            answer = await self._client.post(
                self._path, content=encode(response), headers={"Content-Type": "application/json"}
            )
            answer.raise_for_status()
        except httpx.HTTPStatusError as error:
            status = error.response.status_code
            if 400 <= status < 500 and status not in _RETRIED:
                self.dropped += 1
                _logger.error(
                    "the server refuses a response (%d), it is dropped: %s", status, error.response.text[:200]
                )
                return None
            self.trouble.note(sentence(error))
            return SLOW_RETRY_S if status in (401, 403) else backoff.next_s()
        except httpx.HTTPError as error:
            self.trouble.note(sentence(error))
            return backoff.next_s()
        self.trouble.over()
        backoff.reset()
        return None
