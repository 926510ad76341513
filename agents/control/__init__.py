"""Motion control: from a command and a pose to a twist. Pure; metres, radians, seconds, map frame."""

from agents.control.controller import Goal, PathController, Steering
from agents.control.execution import Execution, Executor, task_of
from agents.control.frenet import FrenetConfig, FrenetController
from agents.control.go_to_goal import GoToGoalConfig, GoToGoalController
from agents.control.gpss import GpssConfig, GpssConstants, GpssController, gpss_law
from agents.control.registry import CONTROLLERS, DEFAULT_CONTROLLER, controller_name
from agents.control.settings import frenet_config, go_to_goal_config, gpss_config, turning_constants
from agents.control.shaping import Ramp, TwistShaper
from agents.control.smooth_path import SmoothPath
from agents.control.turning import Turn, TurningConstants, turn_to

__all__ = [
    "CONTROLLERS",
    "DEFAULT_CONTROLLER",
    "Execution",
    "Executor",
    "FrenetConfig",
    "FrenetController",
    "GoToGoalConfig",
    "GoToGoalController",
    "Goal",
    "GpssConfig",
    "GpssConstants",
    "GpssController",
    "PathController",
    "Ramp",
    "SmoothPath",
    "Steering",
    "Turn",
    "TurningConstants",
    "TwistShaper",
    "controller_name",
    "frenet_config",
    "go_to_goal_config",
    "gpss_config",
    "gpss_law",
    "task_of",
    "turn_to",
    "turning_constants",
]
