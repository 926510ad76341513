"""`python -m server`: the fleet service, until SIGTERM or Ctrl-C."""

import asyncio
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
from server.serving import datagrams, listening, server

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
        _bound(listening, resolved.host, resolved.http_port, "") as console,
        _bound(datagrams, resolved.host, resolved.udp_port, " (UDP)") as robots,
    ):
        serving = server(create_app(resolved, lab, robots))
        asyncio.run(serving.serve(sockets=[console]))
    if not serving.started:
        sys.exit(1)


def _bound(bind: Callable[[str, int], socket.socket], host: str, port: int, kind: str) -> socket.socket:
    try:
        return bind(host, port)
    except OSError as error:
        raise SystemExit(f"cannot listen on {host}:{port}{kind}: {error.strerror}") from None


if __name__ == "__main__":
    main()
