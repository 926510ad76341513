"""`python -m server` as a process: starts, answers, ends within two seconds of SIGTERM with open streams, refuses clearly."""

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
import redis.asyncio
from websockets.asyncio.client import connect

from protocol.channels import EMERGENCY_STOP
from server.__main__ import main
from server.auth import issue_token
from server.intake.__main__ import main as take_in
from tests.redis_fixture import RedisServer
from tests.server.service import ROBOT, ROOT, free_port, until


@contextmanager
def process(redis_url: str, folder: Path, **changes: str) -> Generator[tuple[subprocess.Popen[bytes], str]]:
    """The service on free ports; its output is in folder/log."""
    lab = folder / "lab.yaml"
    text = (ROOT / "labs" / "gulliver.yaml").read_text()
    ports = f"ports: {{http: {free_port()}, robots_udp: {free_port()}, scene: {free_port()}, lab_udp: {free_port()}}}"
    lines = [ports if line.startswith("ports:") else line for line in text.splitlines()]
    lab.write_text("\n".join(lines))
    port = free_port()
    environment = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "LILLIPUT_LAB": str(lab),
        "LILLIPUT_STATE": str(folder),
        "LILLIPUT_HTTP_PORT": str(port),
        "REDIS_URL": redis_url,
        **changes,
    }
    with (folder / "log").open("wb") as log:
        child = subprocess.Popen(
            [sys.executable, "-P", "-m", "server"], cwd=ROOT, env=environment, stdout=log, stderr=subprocess.STDOUT
        )
        try:
            yield child, f"http://127.0.0.1:{port}"
        finally:
            if child.poll() is None:
                child.kill()
            child.wait(10)


async def _answering(client: httpx.AsyncClient, url: str) -> None:
    async def answers() -> bool:
        try:
            return (await client.get(f"{url}/api/health")).status_code == 200
        except httpx.TransportError:
            return False

    await until(answers, within_s=30)


async def test_it_ends_at_once_with_open_streams_and_keeps_the_latch(redis_server: RedisServer, tmp_path: Path) -> None:
    async with redis.asyncio.Redis.from_url(redis_server.url) as store:
        viewer = {"Authorization": f"Bearer {await issue_token(store, 'viewer', 'operator')}"}
        robot = {"Authorization": f"Bearer {await issue_token(store, 'robot', 'robot', ROBOT)}"}
        with process(redis_server.url, tmp_path) as (child, url):
            async with httpx.AsyncClient(trust_env=False, timeout=10) as client:
                await _answering(client, url)
                engaged = (await client.post(f"{url}/api/estop", json={"reason": "fire"}, headers=viewer)).json()
                stream = client.build_request("GET", f"{url}/api/robots/{ROBOT}/commands", headers=robot)
                live = url.replace("http", "ws") + "/api/live"
                opened = await client.send(stream, stream=True)
                async with connect(
                    live, additional_headers=viewer, proxy=None, max_size=None, close_timeout=1
                ) as socket_:
                    await socket_.recv()
                    started = time.monotonic()
                    child.send_signal(signal.SIGTERM)
                    await asyncio.to_thread(child.wait, 5)
                    assert time.monotonic() - started < 2
                await opened.aclose()
        log = (tmp_path / "log").read_text()
        assert "Traceback" not in log, log
        assert json.loads(await store.hget(f"lilliput:live:{EMERGENCY_STOP.name}", "lab")) == engaged  # type: ignore[misc,arg-type]


async def test_it_starts_without_redis(redis_server: RedisServer, tmp_path: Path) -> None:
    redis_server.kill()
    with process(redis_server.url, tmp_path) as (child, url):
        async with httpx.AsyncClient(trust_env=False, timeout=10) as client:
            await _answering(client, url)
            assert (await client.get(f"{url}/api/health")).json()["redis_reachable"] is False
            redis_server.start()

            async def reachable() -> bool:
                return (await client.get(f"{url}/api/health")).json()["redis_reachable"]

            await until(reachable)
        assert child.poll() is None


@pytest.fixture
def environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> pytest.MonkeyPatch:
    """As the launcher sets it, with a free port for the console and a taken one for robots."""
    monkeypatch.setenv("LILLIPUT_LAB", str(ROOT / "labs" / "gulliver.yaml"))
    monkeypatch.setenv("LILLIPUT_HOST", "127.0.0.1")
    monkeypatch.setenv("LILLIPUT_HTTP_PORT", str(free_port()))
    monkeypatch.setenv("REDIS_URL", f"unix://{tmp_path}/none.sock")
    return monkeypatch


def test_a_port_in_use_is_named(environment: pytest.MonkeyPatch) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        environment.setenv("LILLIPUT_HTTP_PORT", port)
        with pytest.raises(SystemExit, match=f"^cannot listen on 127.0.0.1:{port}: .*in use.*set LILLIPUT_HTTP_PORT"):
            main()


def test_a_udp_port_in_use_is_named(environment: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        lab = tmp_path / "lab.yaml"
        text = (ROOT / "labs" / "gulliver.yaml").read_text()
        lab.write_text(text.replace("robots_udp: 2020", f"robots_udp: {port}"))
        environment.setenv("LILLIPUT_LAB", str(lab))
        with pytest.raises(
            SystemExit, match=rf"^cannot listen on 127.0.0.1:{port} \(UDP\): .*in use.*set ports.robots_udp in "
        ):
            take_in()


def test_an_address_of_another_machine_is_named(environment: pytest.MonkeyPatch) -> None:
    environment.setenv("LILLIPUT_HOST", "203.0.113.1")
    with pytest.raises(SystemExit, match=r"^cannot listen on 203.0.113.1:\d+: .*Set LILLIPUT_HOST"):
        main()


@pytest.mark.parametrize("port", ["0", "x", "70000", "²"])
def test_a_port_that_is_none_is_named(environment: pytest.MonkeyPatch, port: str) -> None:
    environment.setenv("LILLIPUT_HTTP_PORT", port)
    with pytest.raises(SystemExit, match="LILLIPUT_HTTP_PORT must be a port"):
        main()


def test_a_lab_file_that_is_wrong_is_named(environment: pytest.MonkeyPatch, tmp_path: Path) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text("name: x\ncolour: red\n")
    environment.setenv("LILLIPUT_LAB", str(bad))
    with pytest.raises(SystemExit, match=r"bad.yaml:2: colour: unknown key"):
        main()


def test_the_openapi_document_needs_nothing(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-P", "-m", "server.openapi"],
        cwd=tmp_path,
        env={"PYTHONPATH": str(ROOT), "PATH": os.environ["PATH"]},
        capture_output=True,
        check=True,
        timeout=60,
    )
    document = json.loads(done.stdout)
    assert {"LiveSnapshot", "LiveChanges", "RobotView"} <= document["components"]["schemas"].keys()
