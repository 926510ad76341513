"""`python -m server.intake`: takes robots' statuses, until SIGTERM or Ctrl-C."""

import logging
import socket

from protocol import lifetime
from protocol.bus import Bus
from protocol.clock import SystemClock
from protocol.errors import LabFileError
from protocol.lab import Lab, load_lab
from protocol.settings import Settings
from server.binding import bound, datagrams
from server.going_on import for_ever
from server.intake.service import IntakeService

_logger = logging.getLogger("server.intake")


def main() -> None:
    """Exit status 1 with a sentence when the port is in use, or the environment or the lab file is no good."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    settings = Settings.from_environment()
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from None
    _logger.info("%s", settings)
    setting = f"ports.robots_udp in {settings.lab}"
    with bound(datagrams, settings.host, lab.ports.robots_udp, " (UDP)", setting) as robots:
        lifetime.run(_run(settings, lab, robots))


async def _run(settings: Settings, lab: Lab, robots: socket.socket) -> None:
    clock = SystemClock()
    bus = Bus.connect(settings.redis_url, clock)
    service = IntakeService(lab, bus, clock, settings.udp_key)
    try:
        async with service.listening(robots):
            await lifetime.run_until_signal(*(for_ever(part, clock) for part in service.parts()))
    finally:
        _logger.info("%s", service.describe())
        await bus.close()


if __name__ == "__main__":
    main()
