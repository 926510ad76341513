"""Drivers: the way from the agent to a robot's base."""

from agents.drivers.driver import (
    Driver,
    DriverError,
    DriverNotConnectedError,
    OdometryReading,
    OdometryStaleError,
    UnknownDriverError,
)
from agents.drivers.registry import DRIVERS, make_driver
from agents.drivers.ros2 import Ros2DriverConfig
from agents.drivers.sim import SimDriver, SimDriverConfig
from agents.drivers.site import DriverSite

__all__ = [
    "DRIVERS",
    "Driver",
    "DriverError",
    "DriverNotConnectedError",
    "DriverSite",
    "OdometryReading",
    "OdometryStaleError",
    "Ros2DriverConfig",
    "SimDriver",
    "SimDriverConfig",
    "UnknownDriverError",
    "make_driver",
]
