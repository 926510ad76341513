"""The driver itself: reads NS/odom and NS/scan, writes NS/cmd_vel, nothing else. Nodes of any ROS 2 distribution whose DDS speaks
the standard wire protocol hear and are heard; Zenoh is another protocol.

The base must stop by itself when cmd_vel falls silent, and its clock must agree with ours: odometry is put beside cameras' poses
by its time stamps.
"""

import asyncio
import logging
import math
from collections.abc import Callable
from typing import Any, TypeVar

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from agents.drivers.driver import DriverNotConnectedError, OdometryReading, OdometryStaleError
from agents.drivers.ros2.config import Ros2DriverConfig
from agents.drivers.ros2.scan import front_range_m, is_blind, is_sound, range_scan
from agents.motion import STOP, Twist
from agents.protection import RangeScan
from geometry import SE2
from protocol.clock import Clock
from protocol.ros2 import interfaces as ros
from protocol.ros2 import topic
from protocol.ros2.quality import DEFAULT, SENSOR_DATA

S = TypeVar("S", bound=IdlStruct)

SCAN_LIMIT_S = 0.5
"""Since the newest scan, and between a scan's stamp and now."""
CLOCK_LIMIT_S = 0.5
_GOODBYE = duration(milliseconds=200)
_JUMP_M, _JUMP_RAD = 0.3, 0.8
"""Beyond what the vehicle can do in the time between: then its odometry was set anew."""
_MOST_AT_ONCE = 50
"""Samples of a topic in one round: ten times what a reader keeps. Nobody who floods it may hold up the control loop."""
_LARGEST = 1e6
"""m, m/s and rad/s beyond which a number is nonsense."""
_UNIT_WITHIN = 0.1
_logger = logging.getLogger(__name__)


class Ros2Driver:
    """`rejected` counts samples that cannot be used: broken, or not of finite numbers."""

    def __init__(self, config: Ros2DriverConfig, clock: Clock) -> None:
        self.rejected = 0
        self._config, self._clock = config, clock
        self._participant: DomainParticipant | None = None
        self._commands: DataWriter[ros.Twist] | None = None
        self._odometry: DataReader[ros.Odometry] | None = None
        self._scans: DataReader[ros.LaserScan] | None = None
        self._newest: tuple[OdometryReading, float] | None = None
        self._scanned: tuple[float | None, float] | None = None
        self._scan_trouble = ""
        self._heard: Callable[[RangeScan], None] | None = None
        self._resets = 0
        self._writer_handle = 0
        self._connected_s = 0.0

    @property
    def connected(self) -> bool:
        return self._participant is not None

    async def connect(self) -> None:
        if self.connected:
            return
        space = self._config.namespace
        try:
            participant = DomainParticipant(self._config.domain)
            self._commands = DataWriter(
                participant, Topic(participant, topic(space, "cmd_vel"), ros.Twist), qos=DEFAULT
            )
            # Best effort: hears bases that publish odometry as sensor data as well as reliable ones.
            self._odometry = DataReader(
                participant, Topic(participant, topic(space, "odom"), ros.Odometry), qos=SENSOR_DATA
            )
            if self._config.scan:
                self._scans = DataReader(
                    participant, Topic(participant, topic(space, "scan"), ros.LaserScan), qos=SENSOR_DATA
                )
        except DDSException as error:
            self._forget()
            raise DriverNotConnectedError(f"no way to ROS 2 in DDS domain {self._config.domain}: {error}") from error
        self._participant = participant
        self._newest, self._scanned, self._scan_trouble = None, None, ""
        self._connected_s = self._clock.monotonic_s()

    async def close(self) -> None:
        if self._commands is None:
            return
        self.send_twist(STOP)
        await asyncio.to_thread(self._commands.wait_for_acks, _GOODBYE)
        self._forget()

    def send_twist(self, twist: Twist) -> Twist:
        if self._commands is None:
            raise DriverNotConnectedError("the ROS 2 base is not connected")
        applied = twist.clipped(self._config.limits)
        try:
            self._commands.write(ros.Twist(ros.Vector3(x=applied.linear_mps), ros.Vector3(z=applied.angular_radps)))
        except DDSException as error:
            raise DriverNotConnectedError(f"/{self._config.namespace}/cmd_vel takes nothing: {error}") from error
        return applied

    def read_odometry(self, max_age_s: float) -> OdometryReading:
        if not self.connected:
            raise DriverNotConnectedError("the ROS 2 base is not connected")
        self._take_all()
        if self._newest is None:
            raise OdometryStaleError(
                f"no odometry yet on /{self._config.namespace}/odom in DDS domain {self._config.domain}; is the base up?"
            )
        reading, received_s = self._newest
        age_s = self._clock.monotonic_s() - received_s
        if age_s > max_age_s:
            raise OdometryStaleError(f"no odometry on /{self._config.namespace}/odom for {age_s:.2f} s")
        ahead_m = None if self._scanned is None else self._scanned[0]
        return OdometryReading(reading.stamp_ns, reading.session, reading.pose, reading.twist, ahead_m)

    def watch_scans(self, heard: Callable[[RangeScan], None]) -> None:
        self._heard = heard

    def battery(self) -> float | None:
        """None: neither odometry nor scans tell it."""
        return None

    def faults(self) -> tuple[str, ...]:
        found: list[str] = []
        if self._config.scan and self.connected:
            heard_s = self._connected_s if self._scanned is None else self._scanned[1]
            silent_s = self._clock.monotonic_s() - heard_s
            if self._scan_trouble:
                found.append(f"the scanner on /{self._config.namespace}/scan {self._scan_trouble}")
            elif self._scanned is None or silent_s > SCAN_LIMIT_S:
                found.append(f"the scanner on /{self._config.namespace}/scan says nothing for {silent_s:.1f} s")
        if self._newest is not None:
            off_s = (self._newest[0].stamp_ns - self._clock.now_ns()) / 1e9 + (
                self._clock.monotonic_s() - self._newest[1]
            )
            if abs(off_s) > CLOCK_LIMIT_S:
                found.append(
                    f"the base's clock is {abs(off_s):.1f} s {'ahead' if off_s > 0 else 'behind'}; keep it by NTP"
                )
        return tuple(found)

    def _take_all(self) -> None:
        now_s = self._clock.monotonic_s()
        for sample in self._taken(self._odometry):
            reading = self._reading(sample)
            if reading is not None:
                self._newest = reading, now_s
        for scan in self._taken(self._scans):
            if not is_sound(scan):
                self._reject("a scan whose numbers are none")
                continue
            self._scan_trouble = self._trouble_with(scan)
            if self._scan_trouble:  # it must not clear the protective field of what an earlier one has seen
                self._reject(f"a scan of a scanner that {self._scan_trouble}")
                continue
            seen = range_scan(scan, self._config)
            self._scanned = front_range_m(seen, self._config), now_s
            if self._heard is not None:
                self._heard(seen)

    def _trouble_with(self, scan: ros.LaserScan) -> str:
        """Why the robot must not drive by this scan; empty when it may."""
        age_s = (self._clock.now_ns() - scan.header.stamp.stamp_ns) / 1e9
        if abs(age_s) > SCAN_LIMIT_S:
            way = "behind" if age_s > 0 else "ahead"
            return f"says what was {abs(age_s):.1f} s {way}: it is late, or its clock is off (keep it by NTP)"
        return "is blind: no beam says anything, as when it is covered" if is_blind(scan) else ""

    def _taken(self, reader: DataReader[S] | None) -> list[S]:
        """What came in since the last time, one by one: a broken sample must not take others along."""
        taken: list[S] = []
        if reader is None:
            return taken
        for _ in range(_MOST_AT_ONCE):
            try:
                samples = reader.take(N=1)
            except DDSException as error:  # the reader's, which takes nothing out and comes back at every further try
                self._forget()
                raise DriverNotConnectedError(f"DDS hands out nothing of /{self._config.namespace}: {error}") from error
            except Exception as error:  # whatever deserializing bytes of a stranger may raise
                self._reject(str(error))
                continue
            if not samples:
                break
            taken += [sample for sample in samples if isinstance(sample, reader.topic.data_type)]
        return taken

    def _reading(self, sample: ros.Odometry) -> OdometryReading | None:
        position, q = sample.pose.pose.position, sample.pose.pose.orientation
        twist = sample.twist.twist
        numbers = (position.x, position.y, q.x, q.y, q.z, q.w, twist.linear.x, twist.angular.z)
        # Written so that a number that is none fails too.
        sound = all(abs(number) < _LARGEST for number in numbers)
        if not sound or abs(math.hypot(q.x, q.y, q.z, q.w) - 1.0) > _UNIT_WITHIN:
            self._reject("odometry whose numbers are none")
            return None
        yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y**2 + q.z**2))
        pose = SE2(position.x, position.y, yaw)
        stamp_ns = sample.header.stamp.stamp_ns
        info: Any = getattr(sample, "sample_info", None)
        handle = 0 if info is None else int(info.publication_handle)
        if self._starts_anew(pose, stamp_ns, handle):
            self._resets += 1
        self._writer_handle = handle
        session = f"{handle:x}-{self._resets}"
        return OdometryReading(stamp_ns, session, pose, Twist(twist.linear.x, twist.angular.z))

    def _starts_anew(self, pose: SE2, stamp_ns: int, handle: int) -> bool:
        """Whether this odometry is not the last one's continuation: another writer, or a jump that no driving explains."""
        if self._newest is None or handle != self._writer_handle:
            return False  # another writer is told apart by its handle
        before = self._newest[0]
        moved = before.pose.inverse() @ pose
        seconds = max(0.0, (stamp_ns - before.stamp_ns) / 1e9)
        limits = self._config.limits
        return (
            math.hypot(moved.x, moved.y) > _JUMP_M + 2.0 * limits.speed_mps * seconds
            or abs(moved.yaw) > _JUMP_RAD + 2.0 * limits.yaw_rate_radps * seconds
        )

    def _reject(self, why: str) -> None:
        self.rejected += 1
        _logger.debug("dropped a sample of /%s: %s", self._config.namespace, why)

    def _forget(self) -> None:
        """DDS deletes what nobody refers to any more, the participant last."""
        self._commands = self._odometry = self._scans = None
        self._participant = None
