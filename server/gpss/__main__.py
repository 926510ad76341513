"""`python -m server.gpss`: the adapter for robots that speak GPSS over Redis by themselves."""

import asyncio
import logging

from protocol.bus import Bus
from protocol.clock import SystemClock
from protocol.errors import LabFileError
from protocol.lab import load_lab
from protocol.lifetime import run_until_signal
from protocol.settings import Settings
from server.gpss.service import GpssService

_logger = logging.getLogger("server.gpss")


def main() -> None:
    """Runs until SIGTERM or SIGINT; ends with a sentence when the environment or the lab file is no good."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    asyncio.run(_run(Settings.from_environment()))


async def _run(settings: Settings) -> None:
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from error
    _logger.info("%s", settings)
    clock = SystemClock()
    bus = Bus.connect(settings.redis_url, clock)
    service = GpssService(lab, bus, clock)
    try:
        await run_until_signal(*service.parts())
    finally:
        _logger.info("%s", service.describe())
        await bus.close()


if __name__ == "__main__":
    main()
