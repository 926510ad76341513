"""The ROS 2 driver where it is not like every other: sessions, scans, clocks, and what strangers send."""

import math
import random
from collections.abc import AsyncIterator
from dataclasses import replace
from typing import Any

import pytest
from cyclonedds._clayer import ddspy_write  # the bytes themselves, which the public interface does not let one choose
from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic

from agents.drivers import DriverError, DriverNotConnectedError, OdometryReading, Ros2DriverConfig
from agents.drivers.ros2.driver import Ros2Driver
from agents.drivers.ros2.scan import front_range_m, range_scan
from agents.motion import Twist
from agents.protection import RangeScan
from geometry import SE2
from protocol.clock import SystemClock
from protocol.lab import load_lab
from protocol.ros2.interfaces import LaserScan
from tests.agents.ros_base import RosBase
from tests.agents.waiting import until
from tests.loopback_dds import domain_of_this_run, stay_on_loopback
from tests.ros2_types import RELIABLE, Odom, odom, scan

VEHICLE = load_lab("labs/gulliver.yaml").vehicle("wifibot-14")
INF = math.inf


def config(**changes: Any) -> Ros2DriverConfig:
    found = Ros2DriverConfig.of(VEHICLE, {"ROS_DOMAIN_ID": str(domain_of_this_run())})
    return replace(found, namespace="robot_15", **changes)


class Pair:
    """A driver and its base."""

    def __init__(self, **changes: Any) -> None:
        stay_on_loopback()
        self.base = RosBase("robot_15", domain_of_this_run())
        self.driver = Ros2Driver(config(**changes), SystemClock())

    async def open(self) -> None:
        await self.base.start()
        await self.driver.connect()
        await until(lambda: self.reading() is not None, "odometry")

    def reading(self) -> OdometryReading | None:
        try:
            return self.driver.read_odometry(0.2)
        except DriverError:
            return None

    def read(self) -> OdometryReading:
        return self.driver.read_odometry(1.0)


@pytest.fixture
async def pair() -> AsyncIterator[Pair]:
    made = Pair()
    await made.open()
    yield made
    await made.driver.close()
    await made.base.stop()


def faults(pair: Pair) -> tuple[str, ...]:
    """After everything that came in."""
    pair.reading()
    return pair.driver.faults()


def test_the_config_is_the_lab_file_s() -> None:
    found = Ros2DriverConfig.of(VEHICLE, {})
    assert (found.namespace, found.domain, found.scan) == ("wifibot_14", 0, True)
    assert (found.front_m, found.half_width_m) == (0.15, 0.16)
    assert found.limits == VEHICLE.limits


async def test_a_base_that_restarts_begins_another_session(pair: Pair) -> None:
    first = pair.read()
    pair.base.restart()
    await until(lambda: pair.read().session != first.session, "another session")


async def test_odometry_that_is_set_anew_begins_another_session(pair: Pair) -> None:
    def moved() -> bool:
        pair.driver.send_twist(Twist(0.3, 0.0))
        return pair.read().pose.x > 0.05

    first = pair.read()
    await until(moved, "motion")
    assert pair.read().session == first.session, "driving is no jump"
    pair.base.plant.odometry = SE2(-3.0, 0.0, 0.0)
    await until(lambda: pair.read().pose.x < -2.0, "the jump")
    assert pair.read().session != first.session


async def test_what_the_scanner_sees_ahead_is_told(pair: Pair) -> None:
    assert pair.read().front_range_m is None
    pair.base.ranges[180] = 0.50  # straight ahead: the turn begins at -pi
    await until(lambda: pair.read().front_range_m is not None, "something ahead")
    assert pair.read().front_range_m == pytest.approx(0.35, abs=0.01)


async def test_a_scanner_that_falls_silent_is_a_fault(pair: Pair) -> None:
    await until(lambda: pair.reading() is not None and pair.driver.faults() == (), "scans")
    pair.base.scans = False

    def told() -> bool:
        pair.reading()
        return any("the scanner on /robot_15/scan says nothing for" in fault for fault in pair.driver.faults())

    await until(told, "a fault")


@pytest.mark.parametrize(
    ("late_ns", "says"),
    [(2_000_000_000, "scan says what was 2.0 s behind"), (-2_000_000_000, "scan says what was 2.0 s ahead")],
)
async def test_scans_of_another_time_are_a_fault_and_clear_nothing(pair: Pair, late_ns: int, says: str) -> None:
    pair.base.ranges[180] = 0.50
    await until(lambda: pair.read().front_range_m is not None, "something ahead")
    pair.base.scans_late_ns = late_ns
    pair.base.ranges[180] = INF
    await until(lambda: any(says in fault for fault in faults(pair)), "a fault")
    heard: list[RangeScan] = []
    pair.driver.watch_scans(heard.append)
    before = pair.driver.rejected
    await until(lambda: bool(faults(pair)) and pair.driver.rejected > before + 2, "more of them")
    assert heard == []
    pair.base.scans_late_ns = 0
    await until(lambda: not faults(pair) and bool(heard), "scans of now")


@pytest.mark.parametrize("range_m", [0.0, math.nan])
async def test_a_scanner_that_sees_nothing_at_all_is_a_fault(pair: Pair, range_m: float) -> None:
    await until(lambda: not faults(pair), "scans")
    pair.base.ranges = [range_m] * 360
    await until(lambda: any("scan is blind" in fault for fault in faults(pair)), "a fault")
    pair.base.ranges = [INF] + [range_m] * 359
    await until(lambda: not faults(pair), "one beam that says that nothing is there")


async def test_a_vehicle_without_a_scanner_needs_none() -> None:
    pair = Pair(scan=False)
    pair.base.scans = False
    await pair.open()
    assert pair.driver.faults() == ()
    assert pair.read().front_range_m is None
    await pair.driver.close()
    await pair.base.stop()


async def test_a_base_whose_clock_is_wrong_is_a_fault(pair: Pair) -> None:
    pair.base.clock_offset_ns = 5_000_000_000

    def told() -> bool:
        pair.reading()
        return any("clock is 5.0 s ahead" in fault for fault in pair.driver.faults())

    await until(told, "a fault")


async def test_numbers_that_are_none_are_dropped_and_counted(pair: Pair) -> None:
    await pair.base.stop()
    pair.read()
    before = pair.driver.rejected
    pair.base.say_odometry(x=math.nan)
    pair.base.say_odometry(x=INF)

    def dropped() -> bool:
        pair.read()
        return pair.driver.rejected == before + 2

    await until(dropped, "two rejected samples")
    assert math.isfinite(pair.read().pose.x)


async def test_broken_bytes_of_a_stranger_change_nothing(pair: Pair) -> None:
    """A thousand mutated samples: each is odometry, or counted and dropped; none is an exception, none is not finite."""
    await pair.base.stop()
    participant = DomainParticipant(domain_of_this_run())
    stranger: DataWriter[Odom] = DataWriter(participant, Topic(participant, "rt/robot_15/odom", Odom), qos=RELIABLE)
    good = odom(SystemClock().now_ns(), 0.1, 0.2, 0.3, 0.0, 0.0).serialize(use_version_2=False)
    stranger.write(odom(SystemClock().now_ns(), 7.0, 0.0, 0.0, 0.0, 0.0))
    await until(lambda: pair.read().pose.x == 7.0, "the stranger is heard")
    rng = random.Random(5)
    for _ in range(1000):
        data = bytearray(good)
        if rng.random() < 0.3:
            del data[rng.randrange(4, len(data)) :]
        for _ in range(rng.randrange(1, 6)):
            data[rng.randrange(4, len(data)) if len(data) > 4 else 3] = rng.randrange(256)
        data += bytes(-len(data) % 4)
        ddspy_write(stranger._ref, bytes(data))  # pyright: ignore[reportPrivateUsage]
        reading = pair.driver.read_odometry(60.0)
        assert all(math.isfinite(n) for n in (reading.pose.x, reading.pose.y, reading.twist.linear_mps))
    assert pair.driver.rejected > 0


class Failing:
    """A reader whose every `take` raises."""

    def __init__(self, error: Exception) -> None:
        self.error, self.takes = error, 0

    def take(self, N: int) -> list[Any]:
        self.takes += 1
        if self.takes > 10_000:
            pytest.fail("for ever")
        raise self.error


async def test_a_reader_that_dds_takes_away_loses_the_base_and_finds_it_again(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = Failing(DDSException(DDSException.DDS_RETCODE_BAD_PARAMETER))
    monkeypatch.setattr(pair.driver, "_odometry", broken)
    with pytest.raises(DriverNotConnectedError, match="DDS hands out nothing of /robot_15"):
        pair.read()
    assert not pair.driver.connected
    await pair.driver.connect()
    await until(lambda: pair.reading() is not None, "odometry again")


async def test_samples_that_never_end_do_not_hold_up_the_control_loop(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = Failing(ValueError("bytes of a stranger"))
    monkeypatch.setattr(pair.driver, "_odometry", broken)
    before = pair.driver.rejected
    pair.read()
    assert 0 < pair.driver.rejected - before == broken.takes < 1000


AHEAD = {"T_robot_scanner": SE2.identity(), "front_m": 0.2, "half_width_m": 0.15}


def seen(ranges: list[float], **changes: Any) -> float | None:
    """As from the bytes of others."""
    message = LaserScan.deserialize(scan(0, ranges).serialize(use_version_2=False))
    where = config(**(AHEAD | changes))
    return front_range_m(range_scan(message, where), where)


def only(index: int, distance_m: float) -> list[float]:
    return [distance_m if i == index else INF for i in range(360)]


def test_front_range_is_measured_from_the_robot_s_front_in_its_lane() -> None:
    assert seen(only(180, 1.0)) == pytest.approx(0.8, abs=1e-3)
    assert seen(only(180 + 10, 1.0)) is None, "17 cm beside the middle: it passes"
    assert seen(only(180 + 10, 0.8)) == pytest.approx(0.8 * math.cos(math.radians(10)) - 0.2, abs=0.01)
    assert seen(only(0, 0.3)) is None, "behind"
    assert seen(only(180, 0.1)) is None, "the robot itself"
    assert seen(only(180, 0.19)) == 0.0, "touches"
    assert seen(only(180, 20.0)) is None, "beyond what it can measure"
    assert seen([math.nan] * 360) is None
    assert seen([-1.0] * 360) is None
    assert seen(only(180, -INF), front_m=0.1) == pytest.approx(0.0, abs=1e-6), "nearer than it can measure"


def test_the_scanner_s_own_place_and_direction_count() -> None:
    turned = SE2(0.1, 0.0, math.pi / 2)  # its 0 points to the robot's left
    assert seen(only(90, 1.0), T_robot_scanner=turned) == pytest.approx(0.9, abs=0.01)
    assert seen(only(180, 1.0), T_robot_scanner=turned) is None
