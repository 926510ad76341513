"""A base that speaks ROS 2 over DDS, with its own types, on the loopback."""

import asyncio
from typing import Any

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from agents.motion import STOP, Twist
from geometry import SE2
from protocol.clock import SystemClock
from tests.agents.plant import LIMITS, Plant
from tests.ros2_types import RELIABLE, SENSOR, Odom, Scan, Velocity, odom, scan

PERIOD_S = 0.02
WATCHDOG_S = 0.3


class RosBase:
    """Obeys NS/cmd_vel, publishes NS/odom and NS/scan, all `rt/...`; nothing is near unless `ranges` says so."""

    def __init__(self, namespace: str, domain: int) -> None:
        self.plant = Plant(SE2(1.0, 2.0, 0.5), LIMITS.model_copy(update={"acceleration_mps2": 2.0}))
        self.ranges = [float("inf")] * 360
        self.scans = True
        self.clock_offset_ns = 0
        self.scans_late_ns = 0
        self._namespace, self._domain = namespace, domain
        self._clock = SystemClock()
        self._heard_s = 0.0
        self._task: asyncio.Task[None] | None = None
        self._start_dds()

    def _start_dds(self) -> None:
        participant = DomainParticipant(self._domain)
        names: list[tuple[str, Any]] = [("cmd_vel", Velocity), ("odom", Odom), ("scan", Scan)]
        topics = {name: Topic(participant, f"rt/{self._namespace}/{name}", kind) for name, kind in names}
        self._commands: DataReader[Velocity] = DataReader(participant, topics["cmd_vel"], qos=RELIABLE)
        self._odometry: DataWriter[Odom] = DataWriter(participant, topics["odom"], qos=RELIABLE)
        self._scan: DataWriter[Scan] = DataWriter(participant, topics["scan"], qos=SENSOR)

    async def start(self) -> None:
        self._task = asyncio.create_task(self._run())

    async def stop(self) -> None:
        if self._task is not None:
            self._task.cancel()
            await asyncio.wait({self._task})
            self._task = None

    def restart(self) -> None:
        """The base's computer starts again: other writers, odometry from zero."""
        self.plant.restart_base()
        self._start_dds()

    def say_odometry(self, x: float | None = None) -> None:
        plant, stamp_ns = self.plant, self._clock.now_ns() + self.clock_offset_ns
        place = plant.odometry
        self._odometry.write(
            odom(
                stamp_ns,
                place.x if x is None else x,
                place.y,
                place.yaw,
                plant.twist.linear_mps,
                plant.twist.angular_radps,
            )
        )

    async def _run(self) -> None:
        last_s = self._clock.monotonic_s()
        while True:
            await asyncio.sleep(PERIOD_S)
            now_s = self._clock.monotonic_s()
            taken: list[Any] = self._commands.take(N=10)
            for command in taken:
                if isinstance(command, Velocity):  # else a writer has gone
                    self.plant.setpoint = Twist(command.linear.x, command.angular.z)
                    self._heard_s = now_s
            if now_s - self._heard_s > WATCHDOG_S:
                self.plant.setpoint = STOP
            self.plant.step(now_s - last_s)
            last_s = now_s
            self.say_odometry()
            if self.scans:
                self._scan.write(scan(self._clock.now_ns() - self.scans_late_ns, self.ranges))
