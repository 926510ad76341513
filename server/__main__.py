"""`python -m server`: the fleet service, until SIGTERM or Ctrl-C."""

import logging
import os
import sys
from pathlib import Path

from protocol.errors import LabFileError
from protocol.lab import load_lab
from protocol.settings import Settings
from server.app import create_app
from server.binding import bound
from server.configuration import configuration
from server.serving import listening, run, server

_CONSOLE = Path(__file__).parents[1] / "web" / "dist"


def main() -> None:
    """Exit status 1 with a sentence when the port is in use or the lab file cannot be read."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")
    settings = Settings.from_environment()
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from None
    resolved = configuration(settings, lab, os.environ, _CONSOLE)
    logging.getLogger("server").info("%s", resolved)
    with bound(listening, resolved.host, resolved.http_port, "", "LILLIPUT_HTTP_PORT") as console:
        serving = server(create_app(resolved, lab))
        run(serving, console)
    if not serving.started:
        sys.exit(1)


if __name__ == "__main__":
    main()
