"""Serves the app with uvicorn: on sockets that do not wait for the dead, and ending at once when asked.

A client that takes nothing for ten seconds is cut off by the kernel (TCP_USER_TIMEOUT), so sockets of gone clients are
freed; small send buffers keep "the newest" new for slow ones.
"""

import resource
import socket
from contextlib import suppress

import uvicorn
from fastapi import FastAPI

from protocol import lifetime
from server.context import Context
from server.direct_writes import DirectWriteProtocol

_DEAD_AFTER_MS = 10_000
_SEND_BUFFER = 128 * 1024
_LARGEST_MESSAGE = 256 * 1024 * 1024
"""Of a WebSocket; the scene's messages are large."""
_SHUTDOWN_S = 1
_MOST_FILES = 65_536


class Server(uvicorn.Server):
    """Ends the robots' streams before it waits for connections to close."""

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        app = self.config.app
        context = getattr(app.state, "context", None) if isinstance(app, FastAPI) else None
        if isinstance(context, Context):
            context.hub.feeds.close()
        await super().shutdown(sockets)


def run(serving: Server, console: socket.socket) -> None:
    """Serves on that socket until told to end, on a loop that bears the streams of a thousand robots: libuv's does for each
    piece that is sent or received half of what asyncio's own does."""
    _allow_many_files()
    lifetime.run(serving.serve(sockets=[console]))


def _allow_many_files() -> None:
    """Every open stream counts as one; many systems allow a thousand unless asked."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = _MOST_FILES if hard == resource.RLIM_INFINITY else min(hard, _MOST_FILES)
    if soft < wanted:
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def server(app: FastAPI) -> Server:
    """A server for the app; run it with `serve(sockets=[listening(...)])`."""
    return Server(
        uvicorn.Config(
            app,
            http=DirectWriteProtocol,
            log_config=None,
            access_log=False,
            server_header=False,
            ws_max_size=_LARGEST_MESSAGE,
            ws_per_message_deflate=False,
            timeout_graceful_shutdown=_SHUTDOWN_S,
            lifespan="on",
        )
    )


def listening(host: str, port: int, dead_after_ms: int = _DEAD_AFTER_MS) -> socket.socket:
    """A listening socket; port 0 takes a free one. OSError when the port is in use."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    made = socket.socket(family, socket.SOCK_STREAM)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        made.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            made.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, dead_after_ms)
        made.bind((host, port))
        made.listen(2048)
        made.setblocking(False)
    except OSError:
        made.close()
        raise
    return made
