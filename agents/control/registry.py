"""The path controllers by name."""

from collections.abc import Callable

from agents.control.controller import PathController
from agents.control.frenet import FrenetController
from agents.control.go_to_goal import GoToGoalController
from agents.control.gpss import GpssController
from agents.control.settings import frenet_config, go_to_goal_config, gpss_config
from protocol.lab import VehicleSpec

CONTROLLERS: dict[str, Callable[[VehicleSpec], PathController]] = {
    "gpss": lambda vehicle: GpssController(vehicle.limits, gpss_config(vehicle)),
    "go_to_goal": lambda vehicle: GoToGoalController(vehicle.limits, go_to_goal_config(vehicle)),
    "frenet": lambda vehicle: FrenetController(vehicle.limits, frenet_config(vehicle)),
}
DEFAULT_CONTROLLER = "frenet"


def controller_name(vehicle: VehicleSpec, chosen: str | None = None) -> str:
    """The one that was chosen, or else the lab file's, or else the default."""
    return chosen or vehicle.control.controller or DEFAULT_CONTROLLER
