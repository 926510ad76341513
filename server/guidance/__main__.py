"""`python -m server.guidance`: the process that tells every robot ten times a second what to do."""

import argparse
import logging

from protocol import lifetime
from protocol.bus import Bus
from protocol.clock import SystemClock
from protocol.errors import LabFileError
from protocol.lab import Lab, load_lab
from protocol.settings import Settings
from server.guidance.parameters import GuidanceParameters
from server.guidance.service import GuidanceService

_logger = logging.getLogger("server.guidance")


def main() -> None:
    """Runs until SIGTERM or SIGINT; ends with a sentence when the environment or the lab file is no good."""
    defaults = GuidanceParameters()
    parser = argparse.ArgumentParser(prog="python -m server.guidance", description=__doc__)
    parser.add_argument(
        "--look-ahead", type=float, default=defaults.look_ahead_m, metavar="M", help="metres (default %(default)s)"
    )
    parser.add_argument(
        "--unseen-share",
        type=float,
        default=defaults.unseen_share,
        metavar="SHARE",
        help="wait when more of the obstacle box than this is seen by no camera, 0 to 1 (default %(default)s)",
    )
    given = parser.parse_args()
    try:
        parameters = GuidanceParameters(look_ahead_m=given.look_ahead, unseen_share=given.unseen_share)
    except ValueError as error:
        parser.error(str(error))
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    settings = Settings.from_environment()
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from None
    _logger.info("guiding %s with %s", ", ".join(v.id for v in lab.vehicles) or "no vehicle", parameters)
    lifetime.run(_run(settings, lab, parameters))


async def _run(settings: Settings, lab: Lab, parameters: GuidanceParameters) -> None:
    clock = SystemClock()
    bus = Bus.connect(settings.redis_url, clock)
    try:
        await lifetime.run_until_signal(GuidanceService(lab, bus.redis, clock, parameters).run())
    finally:
        await bus.close()


if __name__ == "__main__":
    main()
