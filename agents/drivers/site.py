"""What a driver may be made from."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from protocol.clock import Clock
from protocol.lab import Lab, VehicleSpec


@dataclass(frozen=True, slots=True)
class DriverSite:
    """The vehicle, the lab that it is in, the datagrams' key, the host that the simulated lab runs on, and the process's
    environment, for what others' software is told by it (ROS_DOMAIN_ID)."""

    vehicle: VehicleSpec
    lab: Lab
    clock: Clock
    udp_key: bytes | None = field(default=None, repr=False)
    lab_host: str = "127.0.0.1"
    environment: Mapping[str, str] = field(default_factory=dict[str, str], repr=False)
