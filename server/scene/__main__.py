"""`python -m server.scene`: the process of the 3D scene."""

import asyncio
import logging

from protocol.bus import Bus
from protocol.clock import SystemClock
from protocol.errors import LabFileError
from protocol.lab import Lab, load_lab
from protocol.settings import Settings
from server.scene.service import HOST, PortTakenError, open_server, serve

_logger = logging.getLogger("server.scene")


def main() -> None:
    """Runs until SIGTERM or SIGINT; ends with a sentence when the environment, the lab file or the port is no good."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    # viser's WebSocket server tells of every browser that leaves.
    logging.getLogger("websockets").setLevel(logging.WARNING)
    settings = Settings.from_environment()
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from error
    asyncio.run(_run(settings, lab))


async def _run(settings: Settings, lab: Lab) -> None:
    try:
        server = open_server(lab.ports.scene)
    except PortTakenError as error:
        raise SystemExit(str(error)) from error
    clock = SystemClock()
    bus = Bus.connect(settings.redis_url, clock)
    _logger.info("the scene of %s is on http://%s:%d", lab.name, HOST, lab.ports.scene)
    try:
        await serve(lab, server, bus, clock)
    finally:
        server.stop()
        await bus.close()


if __name__ == "__main__":
    main()
