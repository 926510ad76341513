"""Introduces the robot to the server: at the start, as often as the server asks for, and after each reconnection."""

import asyncio
import logging
from collections.abc import Awaitable, Callable

import httpx
from pydantic import BaseModel, Field, ValidationError

from agents.link.backoff import Backoff, Trouble
from agents.link.http import SLOW_RETRY_S, is_hopeless, sentence
from protocol.clock import Clock

PERIOD_S = 5.0
"""Where the server does not say how soon to come again."""
_logger = logging.getLogger(__name__)


class Introduction(BaseModel):
    """The request's body: the kind of robot, where it listens for poses, and a name of this run of the agent."""

    kind: str
    udp_port: int
    session: str


class Welcome(BaseModel):
    """The answer: the server's UDP port for statuses, how often poses come, and how soon to register again (s). Later servers may
    say more."""

    robots_udp: int = Field(gt=0, lt=65536)
    pose_rate_hz: float = Field(ge=0)
    again_s: float = Field(default=PERIOD_S, ge=1.0, le=60.0)


class Registrar:
    """Keeps the registration alive; `on_welcome` learns where statuses go."""

    def __init__(
        self,
        client: httpx.AsyncClient,
        robot: str,
        introduction: Introduction,
        clock: Clock,
        on_welcome: Callable[[Welcome], Awaitable[None]],
    ) -> None:
        self.trouble = Trouble(_logger, "registration")
        self._client = client
        self._path = f"/api/robots/{robot}/registration"
        self._introduction = introduction
        self._clock = clock
        self._on_welcome = on_welcome
        self._wanted = asyncio.Event()

    def again(self) -> None:
        """Registers at once instead of when it is due: the server may be a new one."""
        self._wanted.set()

    async def run(self) -> None:
        """For ever."""
        backoff = Backoff()
        while True:
            self._wanted.clear()
            try:
                welcome = await self._register()
            except (httpx.HTTPError, ValidationError, OSError) as error:
                self.trouble.note(sentence(error))
                hopeless = isinstance(error, httpx.HTTPStatusError) and is_hopeless(error.response.status_code)
                await self._clock.sleep(SLOW_RETRY_S if hopeless else backoff.next_s())
                continue
            self.trouble.over()
            backoff.reset()
            await self._until_due(welcome.again_s)

    async def _register(self) -> Welcome:
        response = await self._client.post(self._path, json=self._introduction.model_dump())
        response.raise_for_status()
        welcome = Welcome.model_validate_json(response.content)
        await self._on_welcome(welcome)
        return welcome

    async def _until_due(self, seconds: float) -> None:
        waits = {asyncio.ensure_future(self._clock.sleep(seconds)), asyncio.ensure_future(self._wanted.wait())}
        try:
            await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for wait in waits:
                wait.cancel()
