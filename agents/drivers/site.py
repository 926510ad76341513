"""What a driver may be made from."""

from dataclasses import dataclass, field

from protocol.clock import Clock
from protocol.lab import Lab, VehicleSpec


@dataclass(frozen=True, slots=True)
class DriverSite:
    """The vehicle, the lab that it is in, the datagrams' key, and the host that the simulated lab runs on."""

    vehicle: VehicleSpec
    lab: Lab
    clock: Clock
    udp_key: bytes | None = field(default=None, repr=False)
    lab_host: str = "127.0.0.1"
