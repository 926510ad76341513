"""A robot that knows only ROS 2's topics, in a process of its own: NS/cmd_vel moves it, NS/odom and NS/scan say how it is. Its
types are its own (tests/ros2_types.py); its wheels are those of a base of the simulated lab.

    python -m tests.e2e.dds_robot VEHICLE NAMESPACE DOMAIN
"""

import math
import sys
import time
from typing import Any

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from tests.e2e.simulated_base import SimulatedBase
from tests.ros2_types import RELIABLE, SENSOR, Odom, Scan, Velocity, odom, scan

PERIOD_S = 0.02
WATCHDOG_S = 0.3


def main() -> None:
    vehicle, namespace, domain = sys.argv[1], sys.argv[2], int(sys.argv[3])
    base, participant = SimulatedBase(vehicle), DomainParticipant(domain)

    def topic(name: str, kind: Any) -> Any:
        return Topic(participant, f"rt/{namespace}/{name}", kind)

    commands: DataReader[Velocity] = DataReader(participant, topic("cmd_vel", Velocity), qos=RELIABLE)
    odometry: DataWriter[Odom] = DataWriter(participant, topic("odom", Odom), qos=SENSOR)
    scans: DataWriter[Scan] = DataWriter(participant, topic("scan", Scan), qos=SENSOR)
    wanted, heard_s = (0.0, 0.0), 0.0
    while True:
        taken: list[Any] = commands.take(N=10)
        for command in taken:
            if isinstance(command, Velocity):  # else a writer has gone
                wanted, heard_s = (command.linear.x, command.angular.z), time.monotonic()
        base.drive(*(wanted if time.monotonic() - heard_s < WATCHDOG_S else (0.0, 0.0)))
        now = base.odometry
        if now is not None:
            odometry.write(odom(now.stamp_ns, now.x, now.y, now.yaw, now.linear_mps, now.angular_radps))
            ahead = math.inf if now.range_front_m is None else now.range_front_m
            scans.write(scan(now.stamp_ns, [ahead if abs(i - 36) < 2 else math.inf for i in range(72)]))
        time.sleep(PERIOD_S)


if __name__ == "__main__":
    main()
