"""Driver of a base that speaks ROS 2 over DDS; `cyclonedds` is imported only when a vehicle asks for it."""

from typing import TYPE_CHECKING

from agents.drivers.driver import UnknownDriverError
from agents.drivers.ros2.config import Ros2DriverConfig
from agents.drivers.site import DriverSite
from protocol.ros2 import DdsMissingError, require_dds

if TYPE_CHECKING:
    from agents.drivers.ros2.driver import Ros2Driver

__all__ = ["Ros2DriverConfig", "make_ros2_driver"]


def make_ros2_driver(site: DriverSite) -> "Ros2Driver":
    """For the registry. UnknownDriverError where this machine cannot speak ROS 2."""
    try:
        require_dds()
    except DdsMissingError as error:
        raise UnknownDriverError(str(error)) from error
    from agents.drivers.ros2.driver import Ros2Driver

    return Ros2Driver(Ros2DriverConfig.at(site), site.clock)
