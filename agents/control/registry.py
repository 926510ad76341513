"""The path controllers by name."""

from collections.abc import Callable

from agents.control.controller import PathController
from agents.control.gpss import GpssController
from protocol.lab import Limits

CONTROLLERS: dict[str, Callable[[Limits], PathController]] = {
    "gpss": GpssController,
}
DEFAULT_CONTROLLER = "gpss"
