"""Clients of the streams: server-sent events of a robot, with deadlines."""

import asyncio
from types import TracebackType
from typing import Self

import httpx

from tests.server.service import Service


class EventStream:
    """A robot's stream of commands."""

    def __init__(self, service: Service, who: str, robot: str) -> None:
        self._client = service.http(who)
        self._path = f"/api/robots/{robot}/commands"
        self.comments = 0

    async def __aenter__(self) -> Self:
        request = self._client.build_request("GET", self._path)
        self.response = await self._client.send(request, stream=True)
        assert self.response.status_code == 200, await self.response.aread()
        assert self.response.headers["content-type"].startswith("text/event-stream")
        self._lines = self.response.aiter_lines()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.response.aclose()

    async def event(self, within_s: float = 15.0) -> tuple[str, str]:
        """Name and data of the next event; comments are counted."""
        name = ""
        async with asyncio.timeout(within_s):
            async for line in self._lines:
                if line.startswith(":"):
                    self.comments += 1
                elif line.startswith("event: "):
                    name = line.removeprefix("event: ")
                elif line.startswith("data: "):
                    return name, line.removeprefix("data: ")
        raise httpx.RemoteProtocolError("the stream has ended")

    async def comment(self, within_s: float = 15.0) -> None:
        """Returns at the next comment."""
        async with asyncio.timeout(within_s):
            async for line in self._lines:
                if line.startswith(":"):
                    self.comments += 1
                    return
        raise httpx.RemoteProtocolError("the stream has ended")

    async def ended(self, within_s: float = 15.0) -> bool:
        """Whether the stream ends within the time."""
        try:
            async with asyncio.timeout(within_s):
                async for _ in self._lines:
                    pass
        except TimeoutError:
            return False
        except httpx.HTTPError:
            pass
        return True
