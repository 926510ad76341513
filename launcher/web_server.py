"""Asks whether the server answers, with nothing but the standard library."""

import asyncio
from contextlib import suppress
from urllib.parse import urlsplit

_TIMEOUT_S = 2.0


async def answers(url: str, path: str = "/api/health") -> bool:
    """Whether an HTTP server at `url` (http://host:port) gives any answer to a GET of `path`."""
    parts = urlsplit(url)
    host, port = parts.hostname or "127.0.0.1", parts.port or 80
    request = f"GET {path} HTTP/1.1\r\nHost: {parts.netloc}\r\nConnection: close\r\n\r\n"
    try:
        async with asyncio.timeout(_TIMEOUT_S):
            reader, writer = await asyncio.open_connection(host, port)
            try:
                writer.write(request.encode())
                return (await reader.readline()).startswith(b"HTTP/1.")
            finally:
                writer.close()
                with suppress(OSError):
                    await writer.wait_closed()
    except (OSError, TimeoutError, ValueError):
        return False
