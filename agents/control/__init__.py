"""Motion control: from a command and a pose to a twist. Pure; metres, radians, seconds, map frame."""

from agents.control.controller import Goal, PathController, Steering
from agents.control.execution import Execution, Executor, task_of
from agents.control.gpss import GpssConfig, GpssConstants, GpssController, gpss_law
from agents.control.registry import CONTROLLERS, DEFAULT_CONTROLLER
from agents.control.turning import TurningConstants, turn_to

__all__ = [
    "CONTROLLERS",
    "DEFAULT_CONTROLLER",
    "Execution",
    "Executor",
    "Goal",
    "GpssConfig",
    "GpssConstants",
    "GpssController",
    "PathController",
    "Steering",
    "TurningConstants",
    "gpss_law",
    "task_of",
    "turn_to",
]
