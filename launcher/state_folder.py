"""The state folder of a running system: its lock and the key of its datagrams, which only its owner can read."""

import fcntl
import os
import secrets
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from launcher.errors import LauncherError, UsageError

KEY_BYTES = 32


@contextmanager
def locked(state: Path) -> Generator[None]:
    """Makes the folder and holds it for this process; UsageError when another one does. The kernel lets go of the lock
    when the holder dies, however it dies."""
    try:
        state.mkdir(parents=True, exist_ok=True, mode=0o700)
        file = (state / "lock").open("a+")
    except OSError as error:
        raise LauncherError(
            f"cannot write in the state folder {state}: {error.strerror}; choose another with --state"
        ) from error
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            holder = file.read().strip() or "unknown"
            raise UsageError(
                f"a system already runs on {state} (process {holder}): stop it, or give this one another --state"
            ) from None
        file.truncate(0)
        file.write(f"{os.getpid()}\n")
        file.flush()
        yield


def udp_key(state: Path, given: str | None = None) -> str:
    """The datagram key in hexadecimal digits: `given` (LILLIPUT_UDP_KEY) when set, else the folder's own, made at first."""
    if given:
        return _checked_key(given, "LILLIPUT_UDP_KEY")
    path = state / "udp.key"
    if not path.exists():
        create_secret(path, secrets.token_hex(KEY_BYTES))
    return _checked_key(path.read_text().strip(), str(path))


def create_secret(path: Path, content: str) -> None:
    """Makes a file that only its owner can read; when two make it at once the first one's content stays."""
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-")  # mode 0600
    fresh = Path(name)
    try:
        with os.fdopen(descriptor, "w") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        try:
            os.link(fresh, path)
        except FileExistsError:
            return
    finally:
        fresh.unlink(missing_ok=True)


def _checked_key(text: str, source: str) -> str:
    try:
        if len(bytes.fromhex(text)) >= KEY_BYTES // 2:
            return text
    except ValueError:
        pass
    raise UsageError(f"{source} must hold at least {KEY_BYTES} hexadecimal digits")
