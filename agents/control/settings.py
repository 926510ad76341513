"""The settings of every controller by the vehicle's kind, and what a lab file changes of them (key `control` of a vehicle).

The kinds' own are for the vehicles of the reports; how they were found is in docs/experiments.md, "Route".
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

from agents.control.frenet import FrenetConfig
from agents.control.go_to_goal import GoToGoalConfig
from agents.control.gpss import GpssConfig
from agents.control.turning import TurningConstants
from protocol.lab import VehicleSpec
from protocol.lab.base import LabModel

FRENET: Mapping[str, FrenetConfig] = {
    "wifibot": FrenetConfig(),
    "turtlebot": FrenetConfig(),
    "agv": FrenetConfig(pivot_above_rad=0.7, lead_s=0.2, swivel_s=1.1),
    "freke": FrenetConfig(),
}
GO_TO_GOAL: Mapping[str, GoToGoalConfig] = dict.fromkeys(FRENET, GoToGoalConfig())
GPSS: Mapping[str, GpssConfig] = dict.fromkeys(FRENET, GpssConfig())

_Config = TypeVar("_Config", FrenetConfig, GoToGoalConfig, GpssConfig)


def frenet_config(vehicle: VehicleSpec) -> FrenetConfig:
    return _changed(FRENET[vehicle.kind], vehicle.control.frenet)


def go_to_goal_config(vehicle: VehicleSpec) -> GoToGoalConfig:
    return _changed(GO_TO_GOAL[vehicle.kind], vehicle.control.go_to_goal)


def gpss_config(vehicle: VehicleSpec) -> GpssConfig:
    return _changed(GPSS[vehicle.kind], vehicle.control.gpss)


def turning_constants(vehicle: VehicleSpec) -> TurningConstants:
    """For `Rotate` and final headings, whatever the controller: of the base, not of the way it follows lines."""
    return TurningConstants(swivel_s=frenet_config(vehicle).swivel_s)


def _changed(config: _Config, given: LabModel) -> _Config:
    """The settings that the lab file gives; its names are the config's."""
    return replace(config, **given.model_dump(exclude_none=True))
