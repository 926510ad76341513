"""The way to the 3D scene: behind the session, both ways, subprotocol and close codes kept, sizes unlimited."""

import asyncio
import gzip
import http
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import asynccontextmanager

import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from server.routes import scene_proxy
from tests.server.service import PASSWORD, Service, free_port, served, until

VISER = "viser-v1.1.1"
PAGE = gzip.compress(b"<html>the scene</html>")
Handler = Callable[[ServerConnection], Awaitable[None]]


async def _echo(connection: ServerConnection) -> None:
    async for message in connection:
        await connection.send(message)


@asynccontextmanager
async def scene(port: int, handler: Handler = _echo) -> AsyncGenerator[list[str]]:
    """Stands for viser: websockets' server with pages by GET; yields the paths asked for."""
    asked: list[str] = []

    def pages(_connection: ServerConnection, request: Request) -> Response | None:
        if request.headers.get("Upgrade") == "websocket":
            return None
        asked.append(request.path)
        if request.path == "/":
            headers = Headers(
                {"Content-Type": "text/html", "Content-Encoding": "gzip", "Content-Length": str(len(PAGE))}
            )
            return Response(http.HTTPStatus.OK, "OK", headers, PAGE)
        return Response(http.HTTPStatus.NOT_FOUND, "NOT FOUND", Headers(), b"none")

    def first(_connection: ServerConnection, offered: object) -> Subprotocol | None:
        names: list[str] = list(offered)  # type: ignore[call-overload]
        return next((Subprotocol(name) for name in names if name.startswith("viser-v")), None)

    async with serve(
        handler, "127.0.0.1", port, process_request=pages, select_subprotocol=first, max_size=None, compression=None
    ):
        yield asked


@asynccontextmanager
async def through(service: Service, path: str = "/viser", who: str = "viewer") -> AsyncGenerator[ClientConnection]:
    async with connect(
        service.base_url.replace("http", "ws") + path,
        additional_headers={"Authorization": f"Bearer {service.tokens[who]}"},
        subprotocols=[Subprotocol("other"), Subprotocol(VISER)],
        proxy=None,
        max_size=None,
        close_timeout=2,
    ) as client:
        yield client


async def test_pages_come_as_they_are(redis_url: str) -> None:
    port = free_port()
    async with scene(port) as asked, served(redis_url, scene_port=port) as (service, _):
        viewer = service.http("viewer")
        page = await viewer.get("/viser/?hideViserLogo&darkMode")
        assert (page.status_code, page.text) == (200, "<html>the scene</html>")
        assert page.headers["content-encoding"] == "gzip"
        assert "'unsafe-eval'" in page.headers["content-security-policy"]
        assert (await viewer.get("/viser/missing.js")).status_code == 404
        assert asked == ["/", "/missing.js"]
        bare = await viewer.get("/viser?darkMode")
        assert (bare.status_code, bare.headers["location"]) == (307, "/viser/?darkMode")
        session = service.http()
        assert (await session.get("/viser/")).status_code == 401
        await session.post("/api/session", json={"user": "viewer", "password": PASSWORD})
        assert (await session.get("/viser/")).status_code == 200
        assert (await service.http("robot").get("/viser/")).status_code == 403


@pytest.mark.parametrize("path", ["/viser", "/viser/"])
async def test_messages_pass_both_ways(redis_url: str, path: str) -> None:
    port = free_port()
    async with scene(port), served(redis_url, scene_port=port) as (service, _), through(service, path) as client:
        assert client.subprotocol == VISER
        assert client.response is not None
        assert "Sec-WebSocket-Extensions" not in client.response.headers
        large = bytes(range(256)) * 80_000
        for message in (b"", b"\x00\xff", "text", large):
            await client.send(message)
            assert await client.recv() == message


async def test_the_scenes_close_code_arrives(redis_url: str) -> None:
    async def refuse(connection: ServerConnection) -> None:
        await connection.recv()
        await connection.close(1002, "another version")

    port = free_port()
    async with scene(port, refuse), served(redis_url, scene_port=port) as (service, _), through(service) as client:
        await client.send(b"hello")
        with pytest.raises(ConnectionClosed):
            await client.recv()
        assert (client.close_code, client.close_reason) == (1002, "another version")


async def test_the_browsers_close_code_arrives(redis_url: str) -> None:
    codes: list[int | None] = []

    async def note(connection: ServerConnection) -> None:
        await connection.wait_closed()
        codes.append(connection.close_code)

    port = free_port()
    async with scene(port, note), served(redis_url, scene_port=port) as (service, _):
        async with through(service) as client:
            await client.close(4000, "bye")
        await until(lambda: codes == [4000])
        async with through(service) as client:
            client.transport.abort()
        await until(lambda: len(codes) == 2)


async def test_a_scene_that_dies_closes_the_browsers_end(redis_url: str) -> None:
    async def die(connection: ServerConnection) -> None:
        connection.transport.abort()
        await asyncio.sleep(0)

    port = free_port()
    async with scene(port, die), served(redis_url, scene_port=port) as (service, _), through(service) as client:
        with pytest.raises(ConnectionClosed):
            await client.recv()
        assert client.close_code == 1013


async def test_without_a_scene_the_page_says_so_and_tries_again(redis_url: str) -> None:
    port = free_port()
    async with served(redis_url, scene_port=port) as (service, _):
        page = await service.http("viewer").get("/viser/")
        assert page.status_code == 503
        assert str(port) in page.text
        assert 'http-equiv="refresh"' in page.text
        with pytest.raises(InvalidStatus) as refused:
            async with through(service):
                pass
        assert refused.value.response.status_code == 503
        async with scene(port):
            assert (await service.http("viewer").get("/viser/")).status_code == 200
            async with through(service) as client:
                await client.send("back")
                assert await client.recv() == "back"


async def test_the_socket_needs_a_viewer_of_this_host(redis_url: str) -> None:
    port = free_port()
    async with scene(port), served(redis_url, scene_port=port) as (service, _):
        url = service.base_url.replace("http", "ws") + "/viser"
        token = {"Authorization": f"Bearer {service.tokens['viewer']}"}
        for headers, code in (({}, 401), ({**token, "Origin": "http://evil.example"}, 403)):
            with pytest.raises(InvalidStatus) as refused:
                async with connect(url, additional_headers=headers, proxy=None):
                    pass
            assert refused.value.response.status_code == code
        with pytest.raises(InvalidStatus) as refused:
            async with through(service, who="robot"):
                pass
        assert refused.value.response.status_code == 403


async def test_the_server_ends_with_open_scenes(redis_url: str) -> None:
    port = free_port()
    async with scene(port), served(redis_url, scene_port=port) as (service, serving), through(service) as client:
        await client.send("hello")
        await client.recv()
        serving.should_exit = True
        async with asyncio.timeout(2):
            with pytest.raises(ConnectionClosed):
                await client.recv()


async def test_the_passage_ends_with_the_session(redis_url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_proxy, "CHECK_EVERY_S", 0.05)
    port = free_port()
    async with scene(port), served(redis_url, scene_port=port) as (service, _), through(service) as client:
        await client.send("still here")
        assert await client.recv() == "still here"
        admin = service.http("admin")
        tokens = (await admin.get("/api/tokens")).json()
        (mine,) = [token["id"] for token in tokens if token["name"] == "viewer token"]
        assert (await admin.delete(f"/api/tokens/{mine}")).status_code == 204
        with pytest.raises(ConnectionClosed):
            await asyncio.wait_for(client.recv(), 5)
        assert client.close_code == 4401
