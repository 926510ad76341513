"""`python -m agents VEHICLE`: the agent of one robot.

It needs the lab file, the server's address, the robot's token and, where datagrams are signed, the key; no Redis. So it runs
on the robot as well as beside the server. The clocks of both machines must agree to within 0.2 s (NTP): commands carry a
deadline and poses their capture time.
"""

import argparse
import asyncio
import logging
import os
import signal
from collections.abc import Mapping, Sequence

from agents.agent import Agent, AgentConfig
from agents.control import CONTROLLERS, controller_name
from agents.drivers import DriverSite, UnknownDriverError, make_driver
from agents.estimation import DEFAULT_ESTIMATOR, ESTIMATORS
from agents.link import server_host
from protocol.clock import SystemClock
from protocol.errors import LabFileError
from protocol.lab import Lab, VehicleSpec, load_lab
from protocol.lifetime import run
from protocol.settings import Settings

_logger = logging.getLogger("agents")


def main(arguments: Sequence[str] | None = None, environment: Mapping[str, str] = os.environ) -> None:
    """SystemExit with a sentence when something is wrong with the settings."""
    options = _parser().parse_args(arguments)
    given = {"LILLIPUT_LAB": options.lab, "LILLIPUT_SERVER": options.server, "LILLIPUT_TOKEN": options.token}
    settings = Settings.from_environment(
        {**environment, **{name: value for name, value in given.items() if value is not None}}, needs_redis=False
    )
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    logging.getLogger("httpx").setLevel(logging.WARNING)
    clock = SystemClock()
    try:
        lab = load_lab(settings.lab)
        vehicle = _vehicle(lab, options.vehicle)
        server_host(settings.server_url)
        lab_host = environment.get("LILLIPUT_LAB_HOST", "127.0.0.1")
        site = DriverSite(vehicle, lab, clock, settings.udp_key, lab_host, environment)
        driver = make_driver(site)
    except (LabFileError, UnknownDriverError, ValueError) as error:
        raise SystemExit(str(error)) from error
    if not settings.token:
        _logger.warning("no token: set LILLIPUT_TOKEN (./lilliput token makes one); the server will refuse this robot")
    config = AgentConfig(
        lab, vehicle, settings.server_url, settings.token, settings.udp_key, options.controller, options.estimator
    )
    driven_by = controller_name(vehicle, config.controller)
    _logger.info("%s, controller %s, estimator %s", settings, driven_by, config.estimator)
    run(_run(Agent(config, driver, clock)))


def _vehicle(lab: Lab, name: str) -> VehicleSpec:
    """ValueError that lists the vehicles when there is none of that name."""
    try:
        return lab.vehicle(name)
    except KeyError:
        known = ", ".join(vehicle.id for vehicle in lab.vehicles) or "none"
        raise ValueError(f"no vehicle {name!r} in lab {lab.name!r}; its vehicles: {known}") from None


async def _run(agent: Agent) -> None:
    """Until SIGINT or SIGTERM; then the robot is stopped and everything closed."""
    running = asyncio.ensure_future(agent.run())
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, running.cancel)
    try:
        await running
    except asyncio.CancelledError:
        _logger.info("stopped")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m agents", description="The agent of one robot.")
    parser.add_argument("vehicle", help="the vehicle's id in the lab file")
    parser.add_argument("--lab", help="lab file (LILLIPUT_LAB)")
    parser.add_argument("--server", help="the server's address (LILLIPUT_SERVER), e.g. http://10.0.0.5:8000")
    parser.add_argument("--token", help="the robot's token (better: LILLIPUT_TOKEN, which other users cannot read)")
    parser.add_argument("--controller", choices=sorted(CONTROLLERS), help="(default: the lab file's)")
    parser.add_argument("--estimator", choices=sorted(ESTIMATORS), default=DEFAULT_ESTIMATOR)
    return parser


if __name__ == "__main__":
    main()
