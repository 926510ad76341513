"""Driver of the simulated base (docs/architecture.md, "The simulated base"): DRIVE, ODOMETRY and SCAN datagrams with the lab."""

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from agents.drivers.driver import DriverNotConnectedError, OdometryReading, OdometryStaleError
from agents.drivers.site import DriverSite
from agents.motion import STOP, Twist
from agents.protection import RangeScan
from geometry import SE2
from protocol.clock import Clock
from protocol.datagram import Datagram, ReplayGuard, Sequencer, Verdict, pack, unpack
from protocol.errors import DecodeError
from protocol.lab import Limits, ScannerSpec
from protocol.messages import DriveSetpoint, Odometry, Scan

SCAN_LIMIT_S = 0.3
_logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SimDriverConfig:
    """Where the lab listens, the vehicle to be there, what it can do, the datagrams' key, and the vehicle's scanner."""

    host: str
    port: int
    vehicle: str
    limits: Limits
    key: bytes | None = field(default=None, repr=False)
    scanner: ScannerSpec | None = None

    @classmethod
    def at(cls, site: DriverSite) -> Self:
        """As the lab description has it."""
        vehicle = site.vehicle
        return cls(
            site.lab_host, site.lab.ports.lab_udp, vehicle.id, vehicle.limits, site.udp_key, scanner=vehicle.scanner
        )


class SimDriver(asyncio.DatagramProtocol):
    """Talks to the simulated base. The lab answers to the address that the last DRIVE came from, so a set-point goes out
    on `connect`, and the agent's steady ones find a lab again that was restarted."""

    def __init__(self, config: SimDriverConfig, clock: Clock) -> None:
        self.rejected = 0
        self._config = config
        self._clock = clock
        self._guard = ReplayGuard()
        self._sequencer = Sequencer(clock.now_ns())
        self._transport: asyncio.DatagramTransport | None = None
        self._newest: tuple[Odometry, float] | None = None
        self._heard: Callable[[RangeScan], None] | None = None
        self._scanned_s = clock.monotonic_s()

    @property
    def connected(self) -> bool:
        return self._transport is not None and not self._transport.is_closing()

    async def connect(self) -> None:
        if self.connected:
            return
        loop = asyncio.get_running_loop()
        try:
            self._transport, _ = await loop.create_datagram_endpoint(
                lambda: self, remote_addr=(self._config.host, self._config.port)
            )
        except OSError as error:
            raise DriverNotConnectedError(
                f"no way to the simulated lab at {self._config.host}:{self._config.port}: {error}"
            ) from error
        self._newest = None
        self._scanned_s = self._clock.monotonic_s()
        self.send_twist(STOP)

    async def close(self) -> None:
        if self.connected:
            self.send_twist(STOP)
        if self._transport is not None:
            self._transport.close()
            self._transport = None
            await self._clock.sleep(0)  # one round of the loop, in which the socket is really closed

    def send_twist(self, twist: Twist) -> Twist:
        if self._transport is None or not self.connected:
            raise DriverNotConnectedError("the simulated base is not connected")
        applied = twist.clipped(self._config.limits)
        sequence = self._sequencer.next()
        setpoint = DriveSetpoint(self._config.vehicle, sequence, applied.linear_mps, applied.angular_radps)
        datagram = Datagram(self._config.vehicle, sequence, self._clock.now_ns(), setpoint)
        self._transport.sendto(pack(datagram, self._config.key))
        return applied

    def read_odometry(self, max_age_s: float) -> OdometryReading:
        if not self.connected:
            raise DriverNotConnectedError("the simulated base is not connected")
        if self._newest is None:
            raise OdometryStaleError(
                f"no odometry yet from the simulated lab at {self._config.host}:{self._config.port}; is it running?"
            )
        odometry, received_s = self._newest
        age_s = self._clock.monotonic_s() - received_s
        if age_s > max_age_s:
            raise OdometryStaleError(f"no odometry from the simulated base for {age_s:.2f} s")
        return OdometryReading(
            odometry.stamp_ns,
            odometry.session,
            SE2(odometry.x, odometry.y, odometry.yaw),
            Twist(odometry.linear_mps, odometry.angular_radps),
            odometry.range_front_m,
        )

    def watch_scans(self, heard: Callable[[RangeScan], None]) -> None:
        self._heard = heard

    def battery(self) -> float | None:
        return None if self._newest is None else min(1.0, max(0.0, self._newest[0].battery))

    def faults(self) -> tuple[str, ...]:
        silent_s = self._clock.monotonic_s() - self._scanned_s
        if self._config.scanner is None or silent_s <= max(SCAN_LIMIT_S, 3.0 / self._config.scanner.rate_hz):
            return ()
        return (f"the safety scanner says nothing for {silent_s:.1f} s",)

    def datagram_received(self, data: bytes, addr: tuple[str | int, int]) -> None:
        """Keeps the newest odometry, passes scans on; what is forged, old, repeated or another vehicle's is counted and
        dropped."""
        try:
            datagram = unpack(data, self._config.key)
        except DecodeError as error:
            self._reject(addr, str(error))
            return
        message = datagram.message
        if not isinstance(message, Odometry | Scan) or message.vehicle != self._config.vehicle:
            self._reject(addr, f"not of the base of {self._config.vehicle}")
            return
        verdict = self._guard.check(datagram, self._clock.now_ns())
        if verdict is not Verdict.FRESH:
            self._reject(addr, f"the datagram is {verdict}")
            return
        if isinstance(message, Odometry):
            self._newest = message, self._clock.monotonic_s()
        elif self._config.scanner is not None:
            self._take_scan(message, self._config.scanner)

    def _take_scan(self, scan: Scan, scanner: ScannerSpec) -> None:
        self._scanned_s = self._clock.monotonic_s()
        if self._heard is not None:
            self._heard(range_scan(scan, scanner))

    def error_received(self, exc: Exception) -> None:
        """The lab does not listen at the moment; the odometry's age says the rest."""
        _logger.debug("the simulated lab is out of reach: %s", exc)

    def _reject(self, addr: tuple[str | int, int], why: str) -> None:
        self.rejected += 1
        _logger.debug("dropped a datagram from the simulated lab at %s: %s", addr, why)


def range_scan(scan: Scan, scanner: ScannerSpec) -> RangeScan:
    """What a simulated scanner's turn says, in the robot's frame."""
    whole = len(scan.ranges_mm) // 2 * 2
    return RangeScan.polar(
        scan.stamp_ns,
        np.frombuffer(scan.ranges_mm[:whole], ">u2") / 1e3,
        angle_min=scan.angle_min,
        angle_increment=scan.angle_increment,
        range_min_m=max(scanner.range_min_m, 1e-3),  # 0 stands for no echo
        range_max_m=scanner.range_m,
        T_robot_scanner=SE2(*scanner.pose),
    )


def make_sim_driver(site: DriverSite) -> SimDriver:
    """For the registry."""
    return SimDriver(SimDriverConfig.at(site), site.clock)
