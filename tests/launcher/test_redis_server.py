"""The private Redis: keeps its data through kill -9 and a cut-off file, on the same socket, reachable by its owner only."""

import asyncio
import os
import signal
import socket
import stat
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
import redis.asyncio
from redis.asyncio.retry import Retry
from redis.backoff import NoBackoff

from launcher.child import Child, ChildSpec
from launcher.errors import LauncherError
from launcher.redis_server import (
    LONGEST_SOCKET_PATH,
    OWN_USER,
    Opening,
    data_folder,
    find_redis_server,
    own_password,
    prepare_folders,
    private_url,
    redis_argv,
    redis_url,
    shown_url,
    socket_path,
    wait_for_redis,
    write_users,
)
from launcher.supervisor import Supervisor
from protocol.clock import SystemClock
from protocol.messages import ProcessState


@asynccontextmanager
async def private_redis(
    state: Path, restarted: asyncio.Event | None = None, opening: Opening | None = None
) -> AsyncGenerator[Child]:
    prepare_folders(state)
    if opening is not None:
        write_users(state)
    clock = SystemClock()

    def changed(state: ProcessState) -> None:
        if restarted is not None and state.restarts and state.state == "running":
            restarted.set()

    async with Supervisor(state / "logs", clock, lambda name, line: None, changed) as supervisor:
        argv = redis_argv(find_redis_server(), state, opening)
        child = supervisor.start(ChildSpec("redis", argv, os.environ, state, ends_last=True))
        await wait_for_redis(private_url(state, opened=opening is not None), clock, 10.0)
        yield child


async def command(state: Path, *words: str) -> object:
    async with redis.asyncio.Redis.from_url(redis_url(socket_path(state))) as client:
        return await client.execute_command(*words)


async def test_data_survives_kill_9(tmp_path: Path) -> None:
    restarted = asyncio.Event()
    async with private_redis(tmp_path, restarted) as child:
        await command(tmp_path, "HSET", "waypoints", "dock", "1.5")
        assert child.state.pid is not None
        os.kill(child.state.pid, signal.SIGKILL)
        await asyncio.wait_for(restarted.wait(), 10.0)
        await wait_for_redis(redis_url(socket_path(tmp_path)), SystemClock(), 10.0)
        assert await command(tmp_path, "HGET", "waypoints", "dock") == b"1.5"


async def test_a_cut_off_file_loses_its_last_write_only(tmp_path: Path) -> None:
    async with private_redis(tmp_path):
        await command(tmp_path, "SET", "kept", "1")
        await command(tmp_path, "SET", "cut", "1")
    file = data_folder(tmp_path) / "appendonly.aof"
    os.truncate(file, file.stat().st_size - 5)
    async with private_redis(tmp_path):
        assert await command(tmp_path, "GET", "kept") == b"1"
        assert await command(tmp_path, "GET", "cut") is None


async def test_it_listens_on_no_network_and_only_for_its_owner(tmp_path: Path) -> None:
    async with private_redis(tmp_path):
        assert await command(tmp_path, "CONFIG", "GET", "port") == {b"port": b"0"}
        assert await command(tmp_path, "CONFIG", "GET", "appendfsync") == {b"appendfsync": b"everysec"}
        assert await command(tmp_path, "CONFIG", "GET", "maxmemory") == {b"maxmemory": b"0"}
        assert stat.S_IMODE(socket_path(tmp_path).stat().st_mode) == 0o700
        assert stat.S_IMODE(data_folder(tmp_path).stat().st_mode) == 0o700


async def test_a_long_or_odd_state_path_works(tmp_path: Path) -> None:
    long = tmp_path / ("a folder with spaces, 100 % long " * 3)
    assert len(os.fsencode(long)) > LONGEST_SOCKET_PATH
    assert len(os.fsencode(socket_path(long))) <= LONGEST_SOCKET_PATH
    odd = tmp_path / "50% ?#"
    for state in (long, odd):
        async with private_redis(state):
            assert await command(state, "PING") in (b"PONG", True)
    socket_path(long).parent.rmdir()


async def test_a_socket_folder_that_others_can_enter_is_refused(tmp_path: Path) -> None:
    long = tmp_path / ("x" * LONGEST_SOCKET_PATH)
    folder = socket_path(long).parent
    folder.mkdir(mode=0o700)
    folder.chmod(0o755)
    try:
        with pytest.raises(LauncherError, match="not a private folder"):
            prepare_folders(long)
    finally:
        folder.rmdir()


async def test_a_redis_that_does_not_answer_is_named_without_its_password() -> None:
    with pytest.raises(LauncherError, match=r"Redis at redis://127\.0\.0\.1:1/0 does not answer"):
        await wait_for_redis("redis://user:secret@127.0.0.1:1/0", SystemClock(), 0.1)
    assert shown_url("redis://:p@ss@redis:6379/0") == "redis://redis:6379/0"


async def test_opened_to_robots_it_lets_nobody_in_without_a_password(tmp_path: Path) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    restarted = asyncio.Event()
    async with private_redis(tmp_path, restarted, Opening("127.0.0.1", port)) as child:
        password = own_password(tmp_path)
        for url in (f"redis://127.0.0.1:{port}", redis_url(socket_path(tmp_path))):
            async with redis.asyncio.Redis.from_url(url, retry=Retry(NoBackoff(), 0)) as stranger:
                with pytest.raises(redis.ConnectionError, match=r"(?i)authenticat"):
                    await stranger.get("x")
        async with redis.asyncio.Redis(port=port, username=OWN_USER, password=password) as own:
            assert await own.set("x", "1")
            assert await own.config_get("bind") == {"bind": "127.0.0.1"}
        assert child.state.pid is not None
        os.kill(child.state.pid, signal.SIGKILL)
        await asyncio.wait_for(restarted.wait(), 10.0)
        await wait_for_redis(private_url(tmp_path, opened=True), SystemClock(), 10.0)
        async with redis.asyncio.Redis.from_url(private_url(tmp_path, opened=True)) as own:
            assert await own.get("x") == b"1"
    secrets = (tmp_path / "redis.password", data_folder(tmp_path) / "users.acl")
    assert all(stat.S_IMODE(path.stat().st_mode) == 0o600 for path in secrets)
    assert password not in secrets[1].read_text()
    assert password not in shown_url(private_url(tmp_path, opened=True))
