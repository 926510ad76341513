"""Where on ROS 2 a base is, and what its scanner sees as ahead."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from agents.drivers.site import DriverSite
from geometry import SE2
from protocol.lab import Limits, Ros2Base, VehicleSpec
from protocol.ros2 import domain_id, namespace_of


@dataclass(frozen=True, slots=True)
class Ros2DriverConfig:
    """`scan` says whether there must be a scanner, `T_robot_scanner` where it sits. What it sees in the lane that the robot
    covers when it drives straight on, `half_width_m` to both sides, is ahead, at the distance from its front, `front_m`."""

    namespace: str
    domain: int
    limits: Limits
    scan: bool
    T_robot_scanner: SE2
    front_m: float
    half_width_m: float

    @classmethod
    def at(cls, site: DriverSite) -> Self:
        """As the lab description has it; the domain may come from ROS_DOMAIN_ID. ValueError when that is none."""
        return cls.of(site.vehicle, site.environment)

    @classmethod
    def of(cls, vehicle: VehicleSpec, environment: Mapping[str, str]) -> Self:
        base = vehicle.ros2 or Ros2Base()
        return cls(
            namespace=namespace_of(vehicle),
            domain=domain_id(base.domain, environment),
            limits=vehicle.limits,
            scan=base.scan,
            T_robot_scanner=SE2(*base.scan_pose),
            front_m=max(x for x, _ in vehicle.footprint),
            half_width_m=max(abs(y) for _, y in vehicle.footprint),
        )
