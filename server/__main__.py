"""`python -m server`: the fleet service, until SIGTERM or Ctrl-C."""

import asyncio
import logging
import os
import sys
from pathlib import Path

from protocol.errors import LabFileError
from protocol.lab import load_lab
from protocol.settings import Settings
from server.app import create_app
from server.configuration import configuration
from server.serving import listening, server

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
    try:
        listener = listening(resolved.host, resolved.http_port)
    except OSError as error:
        raise SystemExit(f"cannot listen on {resolved.host}:{resolved.http_port}: {error.strerror}") from None
    with listener:
        serving = server(create_app(resolved, lab))
        asyncio.run(serving.serve(sockets=[listener]))
    if not serving.started:
        sys.exit(1)


if __name__ == "__main__":
    main()
