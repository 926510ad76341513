"""The 3D scene (viser, in its own process on loopback) behind the session: HTTP under /viser/, its WebSocket at /viser.

viser has no authentication of its own. Its page opens a WebSocket at /viser with the subprotocol `viser-v<version>`, which
goes through both ways, without compression or a limit of size, and so do close codes; of HTTP it knows GET alone.
"""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import suppress

import httpx
from fastapi import APIRouter, Request, WebSocket, WebSocketDisconnect
from redis.exceptions import RedisError
from starlette.background import BackgroundTask
from starlette.responses import HTMLResponse, RedirectResponse, Response, StreamingResponse
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException
from websockets.typing import Subprotocol

from server.access import identify
from server.context import Context, Ctx
from server.errors import UnavailableError
from server.roles import Role
from server.routes.live import CHECK_EVERY_S, SESSION_ENDED, admitted, still_admitted

router = APIRouter(include_in_schema=False)

_FORWARDED = ("accept", "accept-encoding", "if-none-match", "if-modified-since", "range")
_RETURNED = ("content-type", "content-encoding", "content-length", "etag", "last-modified", "cache-control")
_SENDABLE = frozenset({1000, 1001, 1002, 1003, 1007, 1008, 1009, 1010, 1011, 1012, 1013, 1014})
_TRY_AGAIN = 1013
_OPEN_TIMEOUT_S, _CLOSE_TIMEOUT_S = 5.0, 0.5
_logger = logging.getLogger(__name__)

_PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>3D scene</title>{refresh}
<body style="font-family: system-ui, sans-serif; display: grid; place-items: center; height: 90vh; margin: 0;
color: #888; background: transparent"><p>{text}</p></body></html>"""
_REFRESH = '<meta http-equiv="refresh" content="2">'


@router.get("/viser")
async def scene_without_slash(request: Request) -> Response:
    """The scene's page lives in a folder."""
    query = f"?{request.url.query}" if request.url.query else ""
    return RedirectResponse(f"/viser/{query}")


@router.get("/viser/{path:path}")
async def scene_page(path: str, request: Request, context: Ctx) -> Response:
    """The scene's page and files; a page that says what is missing, and tries again, while the scene does not run."""
    try:
        identity = await identify(request, context)
    except (RedisError, OSError):
        return _page(503, "Redis is out of reach. Trying again …", retry=True)
    if identity is None:
        return _page(401, 'Log in to the <a href="/" target="_top">console</a> to see the scene.', retry=False)
    if not identity.has(Role.VIEWER):
        return _page(403, f"This needs the role viewer, {identity.role} is not enough.", retry=False)
    headers = {name: request.headers[name] for name in _FORWARDED if name in request.headers}
    upstream = context.scene.build_request("GET", httpx.URL(path=f"/{path}"), headers=headers)
    try:
        answer = await context.scene.send(upstream, stream=True)
    except httpx.HTTPError as error:
        _logger.info("the scene does not answer: %s", error)
        text = f"The 3D scene does not run (nothing answers on port {context.configuration.scene_port}). Trying again …"
        return _page(503, text, retry=True)
    returned = {name: answer.headers[name] for name in _RETURNED if name in answer.headers}
    returned.setdefault("cache-control", "no-cache")
    return StreamingResponse(
        _raw(answer), answer.status_code, headers=returned, background=BackgroundTask(answer.aclose)
    )


@router.websocket("/viser")
@router.websocket("/viser/")
async def scene_socket(socket: WebSocket, context: Ctx) -> None:
    """Passes messages both ways until either end closes."""
    if not await admitted(socket, context):
        return
    subprotocols = [Subprotocol(name) for name in socket.scope["subprotocols"] if name.startswith("viser-v")]
    try:
        upstream = await connect(
            f"ws://127.0.0.1:{context.configuration.scene_port}/",
            subprotocols=subprotocols or None,
            compression=None,
            max_size=None,
            proxy=None,
            open_timeout=_OPEN_TIMEOUT_S,
            close_timeout=_CLOSE_TIMEOUT_S,
            ping_interval=None,
        )
    except (OSError, TimeoutError, WebSocketException) as error:
        _logger.info("the scene does not answer: %s", error)
        await socket.send_denial_response(_page(503, "The 3D scene does not run.", retry=False))
        return
    try:
        await socket.accept(upstream.subprotocol)
        await _pass_both_ways(socket, upstream, context)
    finally:
        await upstream.close()


async def _pass_both_ways(socket: WebSocket, upstream: ClientConnection, context: Context) -> None:
    parts = _down(socket, upstream), _up(socket, upstream), _until_not_admitted(socket, context)
    tasks = [asyncio.create_task(part) for part in parts]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        if tasks[2].done() and not tasks[2].cancelled():
            with suppress(WebSocketDisconnect, RuntimeError, OSError):
                await socket.close(SESSION_ENDED, "the session has ended")


async def _until_not_admitted(socket: WebSocket, context: Context) -> None:
    """Returns when the session has ended."""
    while await still_admitted(socket, context):
        await context.clock.sleep(CHECK_EVERY_S)


async def _down(socket: WebSocket, upstream: ClientConnection) -> None:
    """From the scene to the browser; ends with the scene's close code."""
    try:
        async for message in upstream:
            if isinstance(message, str):
                await socket.send_text(message)
            else:
                await socket.send_bytes(message)
    except ConnectionClosed:
        pass
    code = upstream.close_code
    await socket.close(_sendable(code, _TRY_AGAIN), upstream.close_reason or "")


async def _up(socket: WebSocket, upstream: ClientConnection) -> None:
    """From the browser to the scene; ends with the browser's close code."""
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            await upstream.close(_sendable(message.get("code"), 1001), message.get("reason") or "")
            return
        data = message.get("bytes")
        try:
            await upstream.send(data if data is not None else message.get("text") or "")
        except ConnectionClosed:
            return


def _sendable(code: int | None, otherwise: int) -> int:
    """The code if it may stand in a close frame; `otherwise` for the absent (1005) and the broken (1006)."""
    return code if code is not None and (code in _SENDABLE or 3000 <= code < 5000) else otherwise


def _page(code: int, text: str, *, retry: bool) -> Response:
    html = _PAGE.format(text=text, refresh=_REFRESH if retry else "")
    headers = {"Cache-Control": "no-store", **({"Retry-After": "2"} if retry else {})}
    return HTMLResponse(html, status_code=code, headers=headers)


async def _raw(answer: httpx.Response) -> AsyncIterator[bytes]:
    try:
        async for chunk in answer.aiter_raw():
            yield chunk
    except httpx.HTTPError as error:
        raise UnavailableError("the scene broke off") from error
    finally:
        await answer.aclose()
