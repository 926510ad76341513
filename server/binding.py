"""Binds the ports on which robots and people reach the system, or says in a sentence why not and what to do about it."""

import errno
import socket
from collections.abc import Callable


def bound(bind: Callable[[str, int], socket.socket], host: str, port: int, kind: str, setting: str) -> socket.socket:
    """What `bind` makes of the address. SystemExit naming the port, its `kind` (" (UDP)" or nothing) and the `setting` that
    chooses another one."""
    try:
        return bind(host, port)
    except OSError as error:
        raise SystemExit(f"cannot listen on {host}:{port}{kind}: {error.strerror}. {_advice(error, setting)}") from None


def datagrams(host: str, port: int) -> socket.socket:
    """A bound UDP socket; port 0 takes a free one. OSError when the port is in use."""
    made = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)
    try:
        made.bind((host, port))
        made.setblocking(False)
    except OSError:
        made.close()
        raise
    return made


def _advice(error: OSError, setting: str) -> str:
    """What to do about it."""
    match error.errno:
        case errno.EADDRINUSE:
            return (
                "Another program has it, perhaps a Lilliput that still runs: end that one (Ctrl-C where it was started), "
                f"or set {setting} to a free port."
            )
        case errno.EACCES:
            return f"Ports below 1024 are for the administrator; set {setting} to one of 1024 or above."
        case _:
            return "Set LILLIPUT_HOST to an address of this machine, such as 127.0.0.1, or 0.0.0.0 for all of them."
