"""The server's side of the robots' protocol (docs/architecture.md, "REST"), reduced to what an agent sees of it."""

import asyncio
import socket
from collections.abc import AsyncIterator, Generator
from contextlib import contextmanager
from typing import Any

import uvicorn
from fastapi import FastAPI, HTTPException, Request
from fastapi.responses import StreamingResponse

from protocol.clock import SystemClock
from protocol.codec import decode, encode
from protocol.datagram import Datagram, Sequencer, pack, unpack
from protocol.messages import Command, EmergencyStop, Response, Status, TrackedPose

KEEP_ALIVE_S = 0.4


class _Server(uvicorn.Server):
    @contextmanager
    def capture_signals(self) -> Generator[None, None, None]:
        yield  # the test run keeps its own handlers


class _StatusSocket(asyncio.DatagramProtocol):
    def __init__(self, owner: "FakeServer") -> None:
        self._owner = owner

    def datagram_received(self, data: bytes, addr: tuple[str | int, int]) -> None:
        message = unpack(data, self._owner.key).message
        assert isinstance(message, Status)
        self._owner.statuses.append(message)


class FakeServer:
    """`events` goes to every open stream; `latch` is the first event of each; `mute` makes streams hang silently;
    `refuse` is a status code that every request gets."""

    def __init__(self, robot: str, token: str = "secret", key: bytes | None = None) -> None:
        self.robot = robot
        self.token = token
        self.key = key
        self.latch = EmergencyStop(engaged=False)
        self.mute = False
        self.refuse: int | None = None
        self.response_failures = 0
        self.registrations: list[dict[str, Any]] = []
        self.responses: list[Response] = []
        self.statuses: list[Status] = []
        self.requests = 0
        self.port = 0
        self.clock = SystemClock()
        self._streams: set[asyncio.Queue[bytes]] = set()
        self._sequencer = Sequencer(self.clock.now_ns())
        self._udp: asyncio.DatagramTransport | None = None
        self._server: _Server | None = None
        self._task: asyncio.Task[None] | None = None

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def streams(self) -> int:
        return len(self._streams)

    async def start(self) -> None:
        """On the port of the last start, if there was one."""
        loop = asyncio.get_running_loop()
        self._udp, _ = await loop.create_datagram_endpoint(lambda: _StatusSocket(self), local_addr=("127.0.0.1", 0))
        listener = socket.create_server(("127.0.0.1", self.port))
        self.port = listener.getsockname()[1]
        config = uvicorn.Config(self._app(), log_level="critical", ws="none", lifespan="off")
        self._server = _Server(config)
        self._task = asyncio.create_task(self._server.serve(sockets=[listener]))
        while not self._server.started:  # noqa: ASYNC110  # uvicorn offers no event
            await asyncio.sleep(0.005)

    async def stop(self) -> None:
        if self._server is not None and self._task is not None and self._udp is not None:
            self._server.should_exit = self._server.force_exit = True
            for queue in self._streams:
                queue.put_nowait(b"")
            await self._task
            self._udp.close()
            await asyncio.sleep(0)

    def send(self, message: Command | EmergencyStop | str) -> None:
        """To every open stream; text goes as the data of a command event."""
        if isinstance(message, EmergencyStop):
            self.latch = message
        for queue in self._streams:
            queue.put_nowait(_event(message))

    def send_pose(self, pose: TrackedPose, *, key: bytes | None = None, sequence: int | None = None) -> bytes:
        """A POSE datagram to the registered port; returns its bytes."""
        number = self._sequencer.next() if sequence is None else sequence
        data = pack(Datagram("tracker", number, self.clock.now_ns(), pose), key or self.key)
        self.send_bytes(data)
        return data

    def send_bytes(self, data: bytes) -> None:
        if self._udp is None or self._udp.is_closing():
            return  # the server is down, and the tracker with it
        self._udp.sendto(data, ("127.0.0.1", self.registrations[-1]["udp_port"]))

    def _app(self) -> FastAPI:
        app = FastAPI()

        def check(request: Request) -> None:
            self.requests += 1
            if self.refuse is not None:
                raise HTTPException(self.refuse)
            if request.headers.get("Authorization") != f"Bearer {self.token}":
                raise HTTPException(401)

        async def register(request: Request) -> dict[str, float]:
            check(request)
            assert self._udp is not None
            self.registrations.append(await request.json())
            return {"robots_udp": self._udp.get_extra_info("sockname")[1], "pose_rate_hz": 15.0}

        async def commands(request: Request) -> StreamingResponse:
            check(request)
            return StreamingResponse(self._stream(), media_type="text/event-stream")

        async def respond(request: Request) -> None:
            check(request)
            if self.response_failures > 0:
                self.response_failures -= 1
                raise HTTPException(503)
            self.responses.append(decode(Response, await request.body()))

        root = f"/api/robots/{self.robot}"
        app.add_api_route(f"{root}/registration", register, methods=["POST"])
        app.add_api_route(f"{root}/commands", commands, methods=["GET"], response_model=None)
        app.add_api_route(f"{root}/responses", respond, methods=["POST"])
        return app

    async def _stream(self) -> AsyncIterator[bytes]:
        queue: asyncio.Queue[bytes] = asyncio.Queue()
        self._streams.add(queue)
        try:
            yield _event(self.latch)
            while self._server is not None and not self._server.should_exit:
                try:
                    data = await asyncio.wait_for(queue.get(), KEEP_ALIVE_S)
                except TimeoutError:
                    data = b": keep-alive\n\n"
                if not self.mute:
                    yield data
        finally:
            self._streams.discard(queue)


def _event(message: Command | EmergencyStop | str) -> bytes:
    if isinstance(message, str):
        return f"event: command\ndata: {message}\n\n".encode()
    name = "emergency_stop" if isinstance(message, EmergencyStop) else "command"
    return b"event: " + name.encode() + b"\ndata: " + encode(message) + b"\n\n"
