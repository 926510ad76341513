"""The system under load: Redis, server, intake and guidance as `./lilliput up` starts them, each a process of its own, and what
they use of the machine."""

import asyncio
import os
import secrets
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import redis

from launcher.child import GUARD
from launcher.environment import SystemSettings, child_environment, python_argv, server_url
from launcher.errors import LauncherError
from launcher.processes import INTAKE, REDIS, SERVER, expand
from launcher.redis_server import find_redis_server, prepare_folders, private_url, redis_argv, wait_for_redis
from protocol import keys
from protocol.clock import SystemClock
from protocol.codec import encode
from protocol.lab import Lab
from server.repositories.tokens import TokenRecord, digest
from server.roles import Role

MEASURED = (REDIS, SERVER, INTAKE, "guidance")
_START_S = 120.0
_END_S = 10.0
_LINES = 12
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True, slots=True)
class System:
    """Where it is reached, the key of its datagrams, a token by robot and one of an operator, and the processes' ids by name."""

    url: str
    redis_url: str
    udp_key: bytes
    tokens: Mapping[str, str]
    operator: str
    pids: Mapping[str, int]

    def cpu_s(self) -> dict[str, float]:
        """Processor time used so far by each process, in seconds."""
        return {name: cpu_s(pid) for name, pid in self.pids.items()}

    def rss_mb(self) -> dict[str, float]:
        """Resident memory of each process now."""
        return {name: _rss_mb(pid) for name, pid in self.pids.items()}


@contextmanager
def running(lab: Lab, lab_file: Path, folder: Path) -> Generator[System]:
    """All four, answering; ended afterwards. LauncherError when one does not start."""
    state, url = folder / "state", server_url("127.0.0.1", lab.ports.http)
    redis_url, key = private_url(state, opened=False), secrets.token_bytes(32)
    settings = SystemSettings(lab_file, state, redis_url, "127.0.0.1", lab.ports.http, url, key.hex())
    prepare_folders(state)
    with ExitStack() as stack:
        begun = {
            REDIS: stack.enter_context(_process(redis_argv(find_redis_server(), state), os.environ, folder, REDIS))
        }
        asyncio.run(wait_for_redis(redis_url, SystemClock(), _START_S))
        tokens, operator = _issue_tokens(redis_url, [vehicle.id for vehicle in lab.vehicles])
        for process in expand(lab):
            if process.name in MEASURED and process.name != REDIS:
                argv, environment = python_argv(process), child_environment(settings, "")
                begun[process.name] = stack.enter_context(_process(argv, environment, folder, process.name))
        try:
            _wait_for(lambda: _answers(url), begun)
            yield System(url, redis_url, key, tokens, operator, {name: child.pid for name, child in begun.items()})
        except LauncherError as error:
            said = [f"{name}: {_last_said(folder / f'{name}.log')}" for name in begun if name != REDIS]
            raise LauncherError("\n".join([str(error), *said])) from error


def cpu_s(pid: int) -> float:
    """Processor time of a process, of all its threads (s)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S


def _rss_mb(pid: int) -> float:
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    raise LauncherError(f"/proc/{pid}/status has no VmRSS: memory can be measured on Linux alone")


@contextmanager
def _process(
    argv: tuple[str, ...], environment: Mapping[str, str], folder: Path, name: str
) -> Generator[subprocess.Popen[bytes]]:
    """Dies with this process, whatever happens to it; its output is in the folder."""
    guarded = (sys.executable, "-I", "-S", str(GUARD), str(os.getpid()), "0", *argv)
    with (folder / f"{name}.log").open("wb") as log:
        child = subprocess.Popen(guarded, env=dict(environment), stdin=subprocess.DEVNULL, stdout=log, stderr=log)
    try:
        yield child
    finally:
        child.terminate()
        try:
            child.wait(_END_S)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()


def _issue_tokens(url: str, robots: list[str]) -> tuple[dict[str, str], str]:
    """A token for each robot, and one of an operator; written at once, as the server's own way looks at all of them for each."""
    texts = {robot: secrets.token_urlsafe(32) for robot in robots}
    operator = secrets.token_urlsafe(32)
    records = [(text, Role.ROBOT, robot) for robot, text in texts.items()] + [(operator, Role.OPERATOR, None)]
    with redis.Redis.from_url(url) as client:
        client.hset(
            keys.TOKENS,
            mapping={
                digest(text): encode(
                    TokenRecord(
                        id=secrets.token_hex(6),
                        name=f"bench {robot or 'observer'}",
                        role=role,
                        robot=robot,
                        created_ns=time.time_ns(),
                        created_by="bench",
                    )
                )
                for text, role, robot in records
            },
        )
    return texts, operator


def _answers(url: str) -> bool:
    try:
        return httpx.get(f"{url}/api/health", timeout=2.0, trust_env=False).status_code == 200
    except httpx.TransportError:
        return False


def _last_said(log: Path) -> str:
    lines = log.read_text(errors="replace").strip().splitlines()
    return "\n  ".join(lines[-_LINES:]) if lines else "said nothing"


def _wait_for(ready: Callable[[], bool], begun: Mapping[str, subprocess.Popen[bytes]]) -> None:
    deadline = time.monotonic() + _START_S
    while not ready():
        for name, child in begun.items():
            if child.poll() is not None:
                raise LauncherError(f"{name} ended with status {child.returncode}")
        if time.monotonic() > deadline:
            raise LauncherError(f"the server does not answer within {_START_S:g} s")
        time.sleep(0.05)
