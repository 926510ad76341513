"""A real Redis server per test: the wheel's binary on a Unix socket, append-only, to be killed and started again at will.

Loaded as a pytest plugin by tests/conftest.py. Also gives hypothesis a profile without deadlines: on a busy machine they fail
tests that are right.
"""

import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import redis
from hypothesis import settings

from launcher.redis_server import find_redis_server

settings.register_profile("lilliput", deadline=None)
settings.load_profile("lilliput")

_START_WITHIN_S = 10.0


class RedisServer:
    """A private redis-server; `url` stays the same over kills and restarts, and so does the data."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._socket = folder / "redis.sock"
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def url(self) -> str:
        return f"unix://{self._socket}"

    def start(self) -> None:
        """Returns when the server answers."""
        assert self._process is None, "already running"
        options = {
            "port": "0",
            "unixsocket": str(self._socket),
            "dir": str(self._folder),
            "appendonly": "yes",
            "appendfsync": "always",
            "save": "",
            "logfile": str(self._folder / "redis.log"),
        }
        arguments = [part for name, value in options.items() for part in (f"--{name}", value)]
        self._process = subprocess.Popen([str(find_redis_server()), *arguments])
        deadline = time.monotonic() + _START_WITHIN_S
        with redis.Redis.from_url(self.url) as client:
            while True:
                try:
                    client.ping()
                    return
                except redis.ConnectionError:
                    assert self._process.poll() is None, (self._folder / "redis.log").read_text()
                    assert time.monotonic() < deadline, "redis-server does not answer"
                    time.sleep(0.005)

    def kill(self) -> None:
        """kill -9, as a crash."""
        self._end(signal.SIGKILL)

    def stop(self) -> None:
        """An orderly end; nothing happens when it does not run."""
        self._end(signal.SIGTERM)

    def pause(self) -> None:
        """Freezes the server: it still holds its connections and answers nothing."""
        assert self._process is not None
        self._process.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        assert self._process is not None
        self._process.send_signal(signal.SIGCONT)

    def _end(self, with_signal: signal.Signals) -> None:
        if self._process is None:
            return
        self._process.send_signal(signal.SIGCONT)
        self._process.send_signal(with_signal)
        self._process.wait(10)
        self._process = None


@pytest.fixture
def redis_server() -> Iterator[RedisServer]:
    """A running, empty Redis of the test's own."""
    # Not tmp_path: its names grow past what a socket's path may have.
    folder = Path(tempfile.mkdtemp(prefix="lilliput-redis-"))
    server = RedisServer(folder)
    try:
        server.start()
        yield server
    finally:
        server.kill()
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def redis_url(redis_server: RedisServer) -> str:
    """The URL of a running, empty Redis of the test's own."""
    return redis_server.url
