"""The drivers by the name that a vehicle's `driver` has in the lab description."""

from collections.abc import Callable

from agents.drivers.driver import Driver, UnknownDriverError
from agents.drivers.ros2 import make_ros2_driver
from agents.drivers.sim import make_sim_driver
from agents.drivers.site import DriverSite

DRIVERS: dict[str, Callable[[DriverSite], Driver]] = {
    "ros2": make_ros2_driver,
    "sim": make_sim_driver,
}


def make_driver(site: DriverSite) -> Driver:
    """The vehicle's driver, not connected yet. UnknownDriverError when there is none of that name."""
    make = DRIVERS.get(site.vehicle.driver)
    if make is None:
        raise UnknownDriverError(
            f"vehicle {site.vehicle.id!r} asks for driver {site.vehicle.driver!r}; there is {', '.join(sorted(DRIVERS))}"
        )
    return make(site)
