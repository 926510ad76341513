"""The robot's side against the simulated lab: its wheels lie, its motors are late, and its datagrams are the real ones."""

import asyncio
import random

import pytest

from agents.control import GpssController
from agents.drivers import DriverError, OdometryReading, SimDriver, SimDriverConfig
from agents.estimation import ExponentialFilter
from agents.motion import STOP, Twist
from agents.pilot import Pilot
from geometry import SE2
from lab.base_link import BaseLink
from lab.world import World
from protocol.clock import SystemClock
from protocol.lab import load_lab
from protocol.messages import Command, EmergencyStop, Outcome, Response, SimulatedObject
from tests.agents.orders import Orders
from tests.agents.plant import distance, tracked
from tests.agents.waiting import until

LAB = load_lab("labs/gulliver.yaml")
KEY = b"key"
CAMERA_DELAY_NS = 90_000_000


class LabDrive:
    """The pilot of one vehicle in the simulated world: 20 Hz control, 10 Hz commands, 15 Hz camera 90 ms late."""

    def __init__(self, robot: str) -> None:
        vehicle = LAB.vehicle(robot)
        self.robot = robot
        self.world = World(LAB)
        self.pilot = Pilot(LAB, vehicle, ExponentialFilter(), GpssController(vehicle.limits))
        self.orders = Orders(robot)
        self.responses: list[Response] = []
        self.errors_m: list[float] = []
        self._rng = random.Random(5)
        self._seen: list[tuple[int, SE2]] = []
        self._step = 0
        self.pilot.emergency_stop(EmergencyStop(engaged=False))

    @property
    def pose(self) -> SE2:
        truth = self.world.truth().vehicles[self.robot]
        return SE2(truth.x, truth.y, truth.yaw)

    def run(self, seconds: float, x: float, y: float, speed: float) -> bool:
        """Until the target is reached; False when it is not in time."""
        for _ in range(round(seconds / self.world.step_s)):
            self._step += 1
            self.world.step()
            now_ns = self.world.stamp_ns
            now_s = self._step * self.world.step_s
            if self._step % 7 == 0:
                pose = self.pose
                noise = self._rng.gauss
                self._seen.append((now_ns, SE2(pose.x + noise(0, 0.004), pose.y + noise(0, 0.004), pose.yaw)))
            if self._seen and now_ns - self._seen[0][0] >= CAMERA_DELAY_NS:
                stamp_ns, seen = self._seen.pop(0)
                self.pilot.camera_pose(tracked(self.robot, seen, stamp_ns), now_ns, now_s)
            if self._step % 10 == 0:
                command: Command = self.orders.move_to(now_ns, x, y, speed=speed)
                self.pilot.command(command, now_ns, now_s)
            if self._step % 5 == 0 and self._control(now_ns, now_s):
                return True
        return False

    def _control(self, now_ns: int, now_s: float) -> bool:
        said = self.world.odometry(self.robot)
        twist = Twist(said.linear_mps, said.angular_radps)
        pose = SE2(said.x, said.y, said.yaw)
        self.pilot.odometry(OdometryReading(said.stamp_ns, said.session, pose, twist, said.range_front_m))
        decision = self.pilot.decide(now_ns, now_s)
        self.world.set_drive(self.robot, decision.twist.linear_mps, decision.twist.angular_radps)
        self.responses += decision.responses
        status = self.pilot.status(1, now_ns, now_s, ip="", battery=None, faults=())
        if status.x is not None and status.y is not None:
            self.errors_m.append(distance(self.pose, status.x, status.y))
        return any(response.outcome is Outcome.REACHED for response in decision.responses)


@pytest.mark.parametrize(("robot", "speed"), [("wifibot-14", 0.3), ("wifibot-14", 0.8), ("turtlebot-16", 0.4)])
def test_a_tour_of_targets_ends_within_15_centimetres_of_each(robot: str, speed: float) -> None:
    drive = LabDrive(robot)
    for x, y in ((3.0, 1.0), (6.0, 2.5), (5.0, 3.0), (5.3, 1.5), (2.0, 2.0)):
        assert drive.run(60.0, x, y, speed), f"({x}, {y}) not reached"
        assert distance(drive.pose, x, y) <= 0.15
    assert drive.world.truth().contacts == 0
    errors = sorted(drive.errors_m)
    assert errors[len(errors) // 2] < 0.006
    assert errors[round(len(errors) * 0.99)] < 0.020


def test_the_range_sensor_keeps_it_off_a_pallet_that_nobody_else_saw() -> None:
    drive = LabDrive("wifibot-14")
    drive.world.put(SimulatedObject(id="p", kind="pallet", x=3.0, y=1.0))
    assert not drive.run(15.0, 5.0, 1.0, 0.4)
    assert drive.world.truth().contacts == 0
    assert drive.responses[-1].reason.startswith("obstacle")
    drive.world.remove("p")
    assert drive.run(30.0, 5.0, 1.0, 0.4)


async def test_the_driver_and_the_lab_understand_each_other() -> None:
    clock, vehicle = SystemClock(), LAB.vehicle("turtlebot-16")
    world = World(LAB, start_ns=clock.now_ns())
    link = BaseLink(world, clock, KEY)
    transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(lambda: link, local_addr=("127.0.0.1", 0))
    port: int = transport.get_extra_info("sockname")[1]
    driver = SimDriver(SimDriverConfig("127.0.0.1", port, vehicle.id, vehicle.limits, KEY), clock)
    await driver.connect()

    def drives() -> bool:
        assert driver.send_twist(Twist(0.2, -0.5)) == Twist(0.2, -0.5)
        while world.stamp_ns < clock.now_ns():
            world.step()
            link.tick()
        try:
            reading = driver.read_odometry(0.2)
        except DriverError:
            return False
        return reading.pose.x > 0.03 and reading.pose.yaw < -0.05 and reading.session == world.session

    await until(drives, "odometry of a robot that drives")
    assert driver.battery() == pytest.approx(1.0, abs=0.01)
    assert driver.send_twist(STOP) == STOP
    await driver.close()
    transport.close()
    await asyncio.sleep(0)
    assert link.rejected.total() == 0
