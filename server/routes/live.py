"""The live stream: everything that a console shows, over one WebSocket."""

import asyncio
import logging
from contextlib import suppress

from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from redis.exceptions import RedisError
from starlette.responses import JSONResponse

from server.access import identify, same_origin
from server.context import Context, Ctx
from server.live.hub import LiveClient
from server.roles import Role

router = APIRouter()

_LEAST_S = 0.05
CHECK_EVERY_S = 10.0
SESSION_ENDED = 4401
"""Close code: log in again."""
_logger = logging.getLogger(__name__)


@router.websocket("/live")
async def live(socket: WebSocket, context: Ctx) -> None:
    """First a LiveSnapshot, then LiveChanges at most 20 times a second; what the client sends is ignored."""
    if not await admitted(socket, context):
        return
    await socket.accept()
    async with context.hub.client() as client, asyncio.TaskGroup() as group:
        sending = group.create_task(_send(socket, context, client))
        await until_gone(socket)
        sending.cancel()


async def admitted(socket: WebSocket, context: Context) -> bool:
    """Whether a viewer of this host's own pages asks; else answers the handshake with 401, 403 or 503."""
    if not same_origin(socket):
        await _deny(socket, 403, "a WebSocket must come from this host's own pages")
        return False
    try:
        identity = await identify(socket, context)
    except (RedisError, OSError):
        await _deny(socket, 503, "Redis is out of reach")
        return False
    if identity is None:
        await _deny(socket, 401, "log in, or send an API token as `Authorization: Bearer TOKEN`")
        return False
    if not identity.has(Role.VIEWER):
        await _deny(socket, 403, f"this needs the role viewer, {identity.name} has {identity.role}")
        return False
    return True


async def still_admitted(socket: WebSocket, context: Context) -> bool:
    """Whether whoever opened the socket is a viewer still, as far as Redis says."""
    try:
        identity = await identify(socket, context)
    except (RedisError, OSError):
        return True
    return identity is not None and identity.has(Role.VIEWER)


async def until_gone(socket: WebSocket) -> None:
    """Returns when the other end has closed or the server ends."""
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            return


async def _send(socket: WebSocket, context: Context, client: LiveClient) -> None:
    checked_s = context.clock.monotonic_s()
    with suppress(WebSocketDisconnect, RuntimeError, OSError):
        while True:
            await socket.send_text((await client.next()).decode())
            await context.clock.sleep(_LEAST_S)
            if context.clock.monotonic_s() - checked_s > CHECK_EVERY_S:
                checked_s = context.clock.monotonic_s()
                if not await still_admitted(socket, context):
                    await socket.close(SESSION_ENDED, "the session has ended")
                    return


async def _deny(socket: WebSocket, code: int, detail: str) -> None:
    await socket.send_denial_response(JSONResponse({"detail": detail}, status_code=code))
