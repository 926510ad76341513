"""`python -m server`: the fleet service, until SIGTERM or Ctrl-C."""

import errno
import logging
import os
import socket
import sys
from collections.abc import Callable
from pathlib import Path

from protocol.errors import LabFileError
from protocol.lab import load_lab
from protocol.settings import Settings
from server.app import create_app
from server.configuration import configuration
from server.serving import datagrams, listening, run, server

_CONSOLE = Path(__file__).parents[1] / "web" / "dist"


def main() -> None:
    """Exit status 1 with a sentence when a port is in use or the lab file cannot be read."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")
    settings = Settings.from_environment()
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from None
    resolved = configuration(settings, lab, os.environ, _CONSOLE)
    logging.getLogger("server").info("%s", resolved)
    with (
        _bound(listening, resolved.host, resolved.http_port, "", "LILLIPUT_HTTP_PORT") as console,
        _bound(datagrams, resolved.host, resolved.udp_port, " (UDP)", f"ports.robots_udp in {settings.lab}") as robots,
    ):
        serving = server(create_app(resolved, lab, robots))
        run(serving, console)
    if not serving.started:
        sys.exit(1)


def _bound(bind: Callable[[str, int], socket.socket], host: str, port: int, kind: str, setting: str) -> socket.socket:
    try:
        return bind(host, port)
    except OSError as error:
        raise SystemExit(f"cannot listen on {host}:{port}{kind}: {error.strerror}. {_advice(error, setting)}") from None


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


if __name__ == "__main__":
    main()
