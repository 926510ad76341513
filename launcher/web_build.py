"""Builds the operator console (web/ -> web/dist) when its sources changed since the last build.

`npm ci` runs again only when the lock file changed, the build only when any source did; both leave a hash beside their
result, so that removing the result makes it anew. Two builds at once wait for each other.
"""

import fcntl
import hashlib
import os
import signal
import subprocess
import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import NoReturn

from launcher.errors import LauncherError
from launcher.node import Node, find_node

NOT_SOURCES = frozenset({"node_modules", "dist", "coverage", "test-results"})
Tell = Callable[[str], None]


def has_web(web: Path) -> bool:
    """Whether there is a console to build."""
    return (web / "package.json").is_file()


def install_packages(web: Path, tell: Tell) -> Node:
    """Makes web/node_modules match the lock file; returns the Node.js that runs its tools. LauncherError if not."""
    with _only_one(web):
        return _install(web, tell)


def build_web(web: Path, tell: Tell) -> bool:
    """Makes web/dist match the sources. False when there is no console to build; LauncherError when the build fails."""
    if not has_web(web):
        tell("no console to build: web/package.json is missing")
        return False
    with _only_one(web):
        digest, stamp = hash_sources(web), web / "dist" / ".sources"
        if _read(stamp) == digest and (web / "dist" / "index.html").is_file():
            return True
        node = _install(web, tell)
        tell(f"building the console (Node.js {node.version})")
        _run_npm(node, web, "building the console", "run", "build")
        if not (web / "dist" / "index.html").is_file():
            raise LauncherError(
                "building the console left no web/dist/index.html; run `npm run build` in web/ to see why"
            )
        stamp.write_text(digest)
    return True


def hash_sources(web: Path) -> str:
    """A hash over the names and contents of everything that the build reads."""
    digest = hashlib.sha256()
    for path in sorted(_sources(web)):
        digest.update(f"{path.relative_to(web)}\0{path.stat().st_size}\0".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _sources(folder: Path) -> Iterator[Path]:
    for path in folder.iterdir():
        if path.name in NOT_SOURCES or path.is_symlink():
            continue
        if path.is_dir():
            yield from _sources(path)
        elif path.is_file():
            yield path


def _install(web: Path, tell: Tell) -> Node:
    node = find_node()
    lock, stamp = web / "package-lock.json", web / "node_modules" / ".lilliput-lock"
    if not lock.is_file():
        raise LauncherError("web/package-lock.json is missing; run `npm install` in web/ and commit it")
    digest = hashlib.sha256(lock.read_bytes() + (web / "package.json").read_bytes()).hexdigest()
    if _read(stamp) != digest:
        tell("installing the console's packages (npm ci)")
        _run_npm(node, web, "installing the console's packages", "ci", "--no-audit", "--no-fund")
        stamp.parent.mkdir(exist_ok=True)
        stamp.write_text(digest)
    return node


def _run_npm(node: Node, web: Path, doing: str, *arguments: str) -> None:
    with _signals_raise():
        status, output = _run(node.npm(*arguments), web, node.environment())
    if status != 0:
        last = "\n".join(output.strip().splitlines()[-15:])
        raise LauncherError(f"{doing} failed (`npm {' '.join(arguments)}` in web/):\n{last}")


def _run(argv: list[str], folder: Path, environment: dict[str, str]) -> tuple[int, str]:
    """Exit status and output. npm starts processes of its own; an interruption ends them all, hence the session."""
    process = subprocess.Popen(
        argv,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    with process:
        try:
            output, _ = process.communicate()
        except BaseException:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            raise
    return process.returncode, output


@contextmanager
def _signals_raise() -> Generator[None]:
    """SIGTERM and SIGHUP end the program by an exception, as SIGINT does, so that what was started is ended too."""
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are the main thread's
        return
    # One that is ignored (nohup) stays ignored.
    deadly = [number for number in (signal.SIGTERM, signal.SIGHUP) if signal.getsignal(number) == signal.SIG_DFL]
    for number in deadly:
        signal.signal(number, _exit)
    try:
        yield
    finally:
        for number in deadly:
            signal.signal(number, signal.SIG_DFL)


def _exit(number: int, _frame: FrameType | None) -> NoReturn:
    raise SystemExit(128 + number)


def _read(path: Path) -> str | None:
    try:
        return path.read_text()
    except OSError:
        return None


@contextmanager
def _only_one(web: Path) -> Generator[None]:
    with (web / "package.json").open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
