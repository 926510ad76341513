"""The conformance suite: every driver keeps the promises of agents.drivers.driver. A new driver adds a bench below."""

import asyncio
import math
from collections.abc import AsyncIterator
from typing import Protocol

import pytest

from agents.drivers import (
    DRIVERS,
    Driver,
    DriverError,
    DriverNotConnectedError,
    DriverSite,
    OdometryStaleError,
    Ros2DriverConfig,
    SimDriver,
    SimDriverConfig,
    UnknownDriverError,
    make_driver,
)
from agents.drivers.ros2.driver import Ros2Driver
from agents.motion import STOP, Twist
from agents.protection import RangeScan
from geometry import SE2
from protocol.clock import SystemClock
from protocol.lab import ScannerSpec, load_lab
from tests.agents.fake_base import FakeBase
from tests.agents.memory_driver import MemoryDriver
from tests.agents.plant import LIMITS, Plant
from tests.agents.ros_base import RosBase
from tests.agents.waiting import until
from tests.loopback_dds import domain_of_this_run, stay_on_loopback

ROBOT = "wifibot-14"
LAB = load_lab("labs/gulliver.yaml")
KEY = b"k" * 32
SCANNER = ScannerSpec(pose=(0.05, 0.0, math.pi / 2), range_m=4.0)
"""Looks to the left, as the ROS 2 base's does."""


class Bench(Protocol):
    """A driver with its base, which the suite looks at and silences."""

    driver: Driver
    plant: Plant

    async def silence(self) -> None: ...
    async def close(self) -> None: ...


class SimBench:
    def __init__(self) -> None:
        self.base = FakeBase(ROBOT, SE2(1.0, 2.0, 0.5), KEY)
        self.plant = self.base.plant

    async def open(self) -> None:
        await self.base.start()
        config = SimDriverConfig("127.0.0.1", self.base.port, ROBOT, LIMITS, KEY, SCANNER)
        self.driver: Driver = SimDriver(config, SystemClock())

    def show(self, range_m: float) -> None:
        self.base.ranges_mm = [round(range_m * 1e3)] * 5

    def stop_scanning(self) -> None:
        self.base.scans = False

    async def silence(self) -> None:
        await self.base.stop()

    async def close(self) -> None:
        await self.driver.close()
        await self.base.stop()


ROS_BASE = Ros2DriverConfig(
    namespace="robot_14",
    domain=domain_of_this_run(),
    limits=LIMITS,
    scan=True,
    T_robot_scanner=SE2(0.05, 0.0, math.pi / 2),
    front_m=0.15,
    half_width_m=0.16,
)


class RosBench:
    def __init__(self) -> None:
        stay_on_loopback()
        self.base = RosBase("robot_14", domain_of_this_run())
        self.plant = self.base.plant

    async def open(self) -> None:
        await self.base.start()
        self.ros = Ros2Driver(ROS_BASE, SystemClock())
        self.driver: Driver = self.ros

    def show(self, range_m: float) -> None:
        """In the middle of the turn, which goes once around."""
        self.base.ranges[178:183] = [range_m] * 5

    def stop_scanning(self) -> None:
        self.base.scans = False

    async def silence(self) -> None:
        await self.base.stop()

    async def close(self) -> None:
        await self.driver.close()
        await self.base.stop()


class MemoryBench:
    def __init__(self) -> None:
        self.plant = Plant(SE2(1.0, 2.0, 0.5))
        self.memory = MemoryDriver(SystemClock(), self.plant, LIMITS)
        self.driver: Driver = self.memory
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> None:
        self._task = asyncio.create_task(self._speak())

    async def _speak(self) -> None:
        while True:
            await asyncio.sleep(0.02)
            self.plant.step(0.02)
            self.memory.base_speaks()

    async def silence(self) -> None:
        self.memory.silent = True

    async def close(self) -> None:
        assert self._task is not None
        self._task.cancel()
        await self.driver.close()


@pytest.fixture(params=[SimBench, RosBench, MemoryBench], ids=["sim", "ros2", "memory"])
async def bench(request: pytest.FixtureRequest) -> AsyncIterator[Bench]:
    bench = request.param()
    await bench.open()
    yield bench
    await bench.close()


def has_odometry(driver: Driver) -> bool:
    try:
        driver.read_odometry(0.2)
    except DriverError:
        return False
    return True


async def test_does_nothing_before_it_is_connected(bench: Bench) -> None:
    assert not bench.driver.connected
    with pytest.raises(DriverNotConnectedError):
        bench.driver.send_twist(STOP)
    with pytest.raises(DriverNotConnectedError):
        bench.driver.read_odometry(1.0)
    await bench.driver.close()


async def test_connecting_twice_is_connecting_once(bench: Bench) -> None:
    await bench.driver.connect()
    await bench.driver.connect()
    assert bench.driver.connected
    await until(lambda: has_odometry(bench.driver), "odometry")


async def test_the_base_holds_the_twist_and_odometry_shows_it(bench: Bench) -> None:
    await bench.driver.connect()
    await until(lambda: has_odometry(bench.driver), "odometry")
    first = bench.driver.read_odometry(0.2)

    def driven() -> bool:
        assert bench.driver.send_twist(Twist(0.2, 0.3)) == Twist(0.2, 0.3)
        newest = bench.driver.read_odometry(0.5)
        return newest.twist.linear_mps > 0.15 and newest.pose.x > first.pose.x + 0.01 and newest.pose.yaw > 0.01

    await until(driven, "motion forward and to the left")
    newest = bench.driver.read_odometry(0.5)
    assert newest.stamp_ns > first.stamp_ns
    assert newest.session == first.session
    battery = bench.driver.battery()
    assert battery is None or 0.0 <= battery <= 1.0
    assert bench.driver.faults() == ()


async def test_returns_what_was_applied_after_clipping(bench: Bench) -> None:
    await bench.driver.connect()
    assert bench.driver.send_twist(Twist(9.0, -9.0)) == Twist(LIMITS.speed_mps, -LIMITS.yaw_rate_radps)
    await until(
        lambda: bench.plant.setpoint == Twist(LIMITS.speed_mps, -LIMITS.yaw_rate_radps), "the clipped set-point"
    )


async def test_stale_odometry_is_no_odometry(bench: Bench) -> None:
    await bench.driver.connect()
    await until(lambda: has_odometry(bench.driver), "odometry")
    await bench.silence()
    await until(lambda: not has_odometry(bench.driver), "staleness")
    with pytest.raises(OdometryStaleError):
        bench.driver.read_odometry(0.1)
    assert bench.driver.read_odometry(60.0).stamp_ns > 0, "a patient caller still gets it"


async def test_closing_stops_the_base(bench: Bench) -> None:
    await bench.driver.connect()

    def moving() -> bool:
        bench.driver.send_twist(Twist(0.3, 0.0))
        return bench.plant.setpoint.linear_mps > 0.0

    await until(moving, "a set-point that moves")
    await bench.driver.close()
    assert not bench.driver.connected
    await until(lambda: bench.plant.setpoint == STOP, "zero")
    await bench.driver.close()
    with pytest.raises(DriverNotConnectedError):
        bench.driver.send_twist(Twist(0.3, 0.0))


async def test_can_be_opened_again(bench: Bench) -> None:
    await bench.driver.connect()
    await bench.driver.close()
    await bench.driver.connect()
    await until(lambda: has_odometry(bench.driver), "odometry")


@pytest.mark.parametrize("make", [SimBench, RosBench], ids=["sim", "ros2"])
async def test_scans_reach_whoever_watches_and_a_silent_scanner_is_a_fault(make: type[SimBench | RosBench]) -> None:
    bench = make()
    await bench.open()
    scans: list[RangeScan] = []
    bench.driver.watch_scans(scans.append)
    bench.show(1.5)
    await bench.driver.connect()

    def scanned() -> bool:
        return has_odometry(bench.driver) and any(len(scan.points) == 5 for scan in scans)

    await until(scanned, "a scan of five echoes")
    scan = next(scan for scan in scans if len(scan.points) == 5)
    assert scan.points[2] == pytest.approx([0.05, 1.5], abs=0.02), "in the robot's frame"
    assert (scan.beams[1:] - scan.beams[:-1]).tolist() == [1, 1, 1, 1]
    await until(lambda: has_odometry(bench.driver) and bench.driver.faults() == (), "no fault")
    bench.stop_scanning()
    await until(lambda: has_odometry(bench.driver) and bench.driver.faults() != (), "a fault")
    assert "scanner" in bench.driver.faults()[0] and "says nothing for 0." in bench.driver.faults()[0]
    await bench.close()


async def test_sim_drops_what_is_forged_old_repeated_or_not_its_own() -> None:
    bench = SimBench()
    await bench.open()
    driver = bench.driver
    assert isinstance(driver, SimDriver)
    await driver.connect()
    await until(lambda: has_odometry(driver), "odometry")
    for number, send in enumerate(
        (
            lambda: bench.base.say(x=99.0, key=b"another key"),
            lambda: bench.base.say(x=99.0, vehicle="wifibot-15"),
            lambda: bench.base.say(x=99.0, sequence=5),
        ),
        start=1,
    ):
        send()
        await until(lambda n=number: driver.rejected == n, "a rejected datagram")
        assert driver.read_odometry(0.5).pose.x < 1.0
    await bench.close()


async def test_sim_finds_a_lab_that_was_restarted() -> None:
    bench = SimBench()
    await bench.open()
    await bench.driver.connect()
    await until(lambda: has_odometry(bench.driver), "odometry")
    first = bench.driver.read_odometry(0.5).session
    port = bench.base.port
    await bench.base.stop()
    await until(lambda: not has_odometry(bench.driver), "silence")
    bench.driver.send_twist(STOP)
    bench.base = FakeBase(ROBOT, SE2.identity(), KEY)
    await bench.base.start(port)

    def speaks_again() -> bool:
        bench.driver.send_twist(STOP)
        return has_odometry(bench.driver)

    await until(speaks_again, "odometry of the new lab")
    assert bench.driver.read_odometry(0.5).session != first
    await bench.close()


def test_the_registry_knows_the_drivers() -> None:
    clock = SystemClock()
    vehicle = LAB.vehicle(ROBOT)
    assert isinstance(make_driver(DriverSite(vehicle, LAB, clock)), SimDriver)
    unknown = vehicle.model_copy(update={"driver": "tractor"})
    with pytest.raises(UnknownDriverError, match=r"'tractor'; there is .*sim"):
        make_driver(DriverSite(unknown, LAB, clock))
    assert {"sim", "ros2"} <= DRIVERS.keys()
    ros = vehicle.model_copy(update={"driver": "ros2"})
    assert isinstance(make_driver(DriverSite(ros, LAB, clock)), Ros2Driver)
    with pytest.raises(ValueError, match="ROS_DOMAIN_ID must be a number from 0 to 232, not 'x'"):
        make_driver(DriverSite(ros, LAB, clock, environment={"ROS_DOMAIN_ID": "x"}))
