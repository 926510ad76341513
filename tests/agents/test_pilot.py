"""The pilot in a closed loop: a small vehicle, a delayed noisy camera, a guidance; responses and status."""

import math
import random
from collections.abc import Callable, Iterable

import pytest

from agents.control import GpssController
from agents.estimation import ExponentialFilter
from agents.motion import STOP
from agents.pilot import Pilot
from geometry import SE2
from protocol.codec import encode
from protocol.datagram import MAX_PAYLOAD
from protocol.lab import load_lab
from protocol.messages import (
    Command,
    EmergencyStop,
    Mode,
    Movement,
    Outcome,
    Reason,
    ReasonCode,
    Response,
    Status,
    TrackedPose,
)
from tests.agents.orders import Orders
from tests.agents.plant import Plant, distance, tracked

ROBOT = "wifibot-14"
LAB = load_lab("labs/gulliver.yaml")
VEHICLE = LAB.vehicle(ROBOT)
START_NS = 1_700_000_000_000_000_000


class Drive:
    """20 Hz control, 10 Hz commands, 15 Hz camera 80 ms late with 5 mm noise, wheels 1 % wrong."""

    def __init__(self) -> None:
        self.pilot = Pilot(LAB, VEHICLE, ExponentialFilter(), GpssController(VEHICLE.limits))
        self.plant = Plant(SE2(1.0, 1.0, 0.0), VEHICLE.limits, distance_scale=1.01, turn_scale=0.99)
        self.orders = Orders(ROBOT)
        self.responses: list[Response] = []
        self.stopped_by: Reason | None = None
        self.camera_works = True
        self.front_range_m: float | None = None
        self.step = 0
        self._rng = random.Random(3)
        self._seen: list[tuple[int, SE2]] = []
        self.pilot.emergency_stop(EmergencyStop(engaged=False))

    @property
    def now_ns(self) -> int:
        return START_NS + self.step * 5_000_000

    @property
    def now_s(self) -> float:
        return self.step * 0.005

    def run(self, seconds: float, order: Callable[[int], Command] | None) -> None:
        """5 ms steps; `order` makes the command of each moment."""
        for _ in range(round(seconds * 200)):
            self.step += 1
            self.plant.step(0.005)
            if self.step % 13 == 0:
                noise = self._rng.gauss
                pose = self.plant.pose
                self._seen.append((self.now_ns, SE2(pose.x + noise(0, 0.005), pose.y + noise(0, 0.005), pose.yaw)))
            while self._seen and self.now_ns - self._seen[0][0] >= 80_000_000:
                stamp_ns, seen = self._seen.pop(0)
                if self.camera_works:
                    self.pilot.camera_pose(tracked(ROBOT, seen, stamp_ns), self.now_ns, self.now_s)
            if order is not None and self.step % 20 == 0:
                self.pilot.command(order(self.now_ns), self.now_ns, self.now_s)
            if self.step % 10 == 0:
                self.pilot.odometry(self.plant.reading(self.now_ns, front_range_m=self.front_range_m))
                decision = self.pilot.decide(self.now_ns, self.now_s)
                self.plant.setpoint = decision.twist
                self.stopped_by = decision.stopped_by
                self.responses += decision.responses

    def status(self) -> Status:
        return self.pilot.status(1, self.now_ns, self.now_s, ip="127.0.0.1", battery=0.9, faults=())

    def outcomes(self) -> list[Outcome]:
        return [response.outcome for response in self.responses]


def to(drive: Drive, x: float, y: float, *, speed: float = 0.3, yaw: float | None = None) -> Callable[[int], Command]:
    return lambda now_ns: drive.orders.move_to(now_ns, x, y, speed=speed, yaw=yaw)


@pytest.mark.parametrize("target", [(3.0, 1.0), (1.0, 3.0), (0.5, 0.5), (6.0, 3.5), (1.3, 1.1)])
def test_drives_to_a_target_within_15_centimetres_of_the_truth(target: tuple[float, float]) -> None:
    drive = Drive()
    drive.run(40.0, to(drive, *target, speed=0.4))
    assert drive.plant.twist == STOP
    assert distance(drive.plant.pose, *target) <= 0.15
    assert drive.outcomes()[-2:] == [Outcome.ACCEPTED, Outcome.REACHED]


def test_a_final_heading_is_reached_too() -> None:
    drive = Drive()
    drive.run(30.0, to(drive, 2.5, 1.0, yaw=2.0))
    assert abs(drive.plant.pose.yaw - 2.0) < math.radians(2.5)
    assert drive.responses[-1].outcome is Outcome.REACHED


def test_one_response_per_thing_obeyed_with_the_time_of_reaching() -> None:
    drive = Drive()
    drive.run(1.0, drive.orders.waiting)
    drive.run(15.0, to(drive, 2.0, 1.0, speed=5.0))
    drive.run(1.0, drive.orders.waiting)
    answers = [(r.movement, r.outcome, r.applied_speed_mps) for r in drive.responses if r.outcome != Outcome.REFUSED]
    assert answers == [
        (Movement.WAITING, Outcome.ACCEPTED, 0.0),
        (Movement.MOVE_TO, Outcome.ACCEPTED, 0.8),
        (Movement.MOVE_TO, Outcome.REACHED, 0.8),
        (Movement.WAITING, Outcome.ACCEPTED, 0.0),
    ]
    reached = [r.reached_ns for r in drive.responses]
    assert [stamp is not None for stamp in reached].count(True) == 1


def test_a_carrot_that_moves_makes_one_response() -> None:
    drive = Drive()
    drive.run(6.0, lambda now_ns: drive.orders.move_to(now_ns, drive.plant.pose.x + 0.8, 1.0, speed=0.3, final=False))
    assert drive.outcomes().count(Outcome.ACCEPTED) == 1
    assert drive.plant.twist.linear_mps == pytest.approx(0.3)
    assert abs(drive.plant.pose.y - 1.0) < 0.05


def test_stops_half_a_second_after_the_last_command() -> None:
    drive = Drive()
    drive.run(4.0, to(drive, 6.0, 1.0, speed=0.5))
    silent_from_s = drive.now_s
    assert drive.plant.twist.linear_mps > 0.4
    drive.run(0.4, None)
    assert drive.plant.setpoint != STOP
    drive.run(0.2, None)
    assert drive.plant.setpoint == STOP
    assert drive.stopped_by is not None and drive.stopped_by.code is ReasonCode.COMMAND_STALE
    drive.run(0.3, None)
    assert drive.plant.twist == STOP
    assert drive.now_s - silent_from_s < 1.0
    drive.run(2.0, to(drive, 6.0, 1.0, speed=0.5))
    assert drive.plant.twist.linear_mps > 0.4, "goes on when commands come again"


def test_stops_half_a_second_after_the_last_pose_was_captured() -> None:
    drive = Drive()
    drive.run(4.0, to(drive, 6.0, 1.0, speed=0.5))
    drive.camera_works = False
    drive.run(0.55, to(drive, 6.0, 1.0, speed=0.5))
    assert drive.plant.setpoint == STOP
    assert drive.stopped_by is not None and drive.stopped_by.code is ReasonCode.POSE_STALE
    status = drive.status()
    assert status.stopped_by == drive.stopped_by
    assert status.pose_age_s is not None and status.pose_age_s > 0.5
    assert drive.responses[-1].outcome is Outcome.REFUSED
    assert drive.responses[-1].reason.startswith("pose_stale")
    drive.camera_works = True
    drive.run(2.0, to(drive, 6.0, 1.0, speed=0.5))
    assert drive.plant.twist.linear_mps > 0.4


def test_hand_driving_needs_a_pose_as_well() -> None:
    drive = Drive()
    drive.run(1.0, lambda now_ns: drive.orders.drive(now_ns, 0.3, 0.2))
    assert drive.plant.twist.linear_mps == pytest.approx(0.3)
    assert drive.status().mode is Mode.MANUAL
    drive.camera_works = False
    drive.run(1.0, lambda now_ns: drive.orders.drive(now_ns, 0.3, 0.2))
    assert drive.plant.twist == STOP


def test_an_emergency_stop_outlasts_silence_and_commands() -> None:
    drive = Drive()
    order = to(drive, 6.0, 1.0, speed=0.5)
    drive.run(3.0, order)
    assert drive.pilot.emergency_stop(EmergencyStop(engaged=True, epoch=1, reason="test"))
    drive.run(0.5, order)
    assert drive.plant.twist == STOP
    drive.run(2.0, None)
    drive.run(2.0, order)
    assert drive.plant.twist == STOP
    assert drive.responses[-1].reason.startswith("emergency_stop")
    drive.pilot.emergency_stop(EmergencyStop(engaged=False, epoch=2))
    drive.run(2.0, order)
    assert drive.plant.twist.linear_mps > 0.4


def test_an_obstacle_at_the_nose_stops_until_it_is_gone() -> None:
    drive = Drive()
    order = to(drive, 6.0, 1.0, speed=0.3)
    drive.run(3.0, order)
    drive.front_range_m = 0.15
    drive.run(1.0, order)
    assert drive.plant.twist == STOP
    assert drive.stopped_by is not None and drive.stopped_by.code is ReasonCode.OBSTACLE
    drive.front_range_m = None
    drive.run(2.0, order)
    assert drive.plant.twist.linear_mps > 0.2


def test_an_older_guidance_is_refused_once() -> None:
    drive = Drive()
    old, drive.orders = drive.orders, Orders(ROBOT, epoch=2)
    drive.run(1.0, drive.orders.waiting)
    for _ in range(10):
        drive.run(0.1, drive.orders.waiting)
        drive.pilot.command(old.move_to(drive.now_ns, 5.0, 1.0), drive.now_ns, drive.now_s)
    drive.run(0.2, drive.orders.waiting)
    refused = [r for r in drive.responses if r.outcome is Outcome.REFUSED]
    assert [(r.command_order[0], r.reason) for r in refused] == [(1, "a newer guidance is in charge")]
    assert drive.plant.twist == STOP


def test_the_status_tells_the_newest_command_accepted_though_it_is_not_obeyed() -> None:
    drive = Drive()
    drive.orders = Orders(ROBOT, epoch=217_000_000)
    drive.run(0.5, drive.orders.waiting)
    drive.pilot.emergency_stop(EmergencyStop(engaged=True, epoch=1))
    drive.run(0.5, None)
    lost = Orders(ROBOT, epoch=1)
    drive.run(1.0, lost.waiting)
    status = drive.status()
    assert status.stopped_by is not None
    assert status.command_order is not None and status.command_order[0] == 217_000_000


def test_a_release_that_is_ignored_is_told_once(caplog: pytest.LogCaptureFixture) -> None:
    drive = Drive()
    for epoch, engaged in ((5, True), (5, False), (3, False), (3, False)):
        drive.pilot.emergency_stop(EmergencyStop(engaged=engaged, epoch=epoch))
    assert drive.pilot.latch.engaged
    warnings = [record.getMessage() for record in caplog.records]
    assert len(warnings) == 2
    assert "its epoch 3 is not greater than the engagement's, 5" in warnings[1]
    drive.pilot.emergency_stop(EmergencyStop(engaged=False, epoch=6))
    drive.pilot.emergency_stop(EmergencyStop(engaged=False, epoch=6))
    assert not drive.pilot.latch.engaged
    assert len(caplog.records) == 2


def test_late_commands_are_refused_once_in_a_row() -> None:
    drive = Drive()
    drive.run(2.0, lambda now_ns: drive.orders.move_to(now_ns - 800_000_000, 5.0, 1.0))
    assert drive.outcomes() == [Outcome.REFUSED]
    assert "0.30 s after its deadline" in drive.responses[0].reason
    assert drive.plant.pose == SE2(1.0, 1.0, 0.0)


def test_status_before_and_after_localization() -> None:
    drive = Drive()
    drive.camera_works = False
    drive.run(0.5, drive.orders.waiting)
    status = drive.status()
    assert (status.x, status.y, status.yaw, status.area, status.pose_age_s) == (None, None, None, None, None)
    assert status.stopped_by is not None and status.stopped_by.text == "not localized"
    drive.camera_works = True
    drive.run(0.5, drive.orders.waiting)
    status = drive.status()
    assert status.x == pytest.approx(1.0, abs=0.02)
    assert (status.area, status.stopped_by, status.battery) == ("camp", None, 0.9)
    assert status.command_order is not None and status.command_order[0] == 1


def test_a_base_fault_stops_and_is_told() -> None:
    drive = Drive()
    drive.run(2.0, to(drive, 6.0, 1.0))
    drive.pilot.odometry(drive.plant.reading(drive.now_ns), ("left motor hot",))
    decision = drive.pilot.decide(drive.now_ns, drive.now_s)
    assert decision.twist == STOP
    since_ns = drive.now_ns
    assert decision.stopped_by == Reason(code=ReasonCode.DRIVER_FAULT, text="left motor hot", since_ns=since_ns)


@pytest.mark.parametrize(
    "wrong",
    [
        tracked(ROBOT, SE2(1e6, 0.0, 0.0), START_NS + 990_000_000),
        tracked("wifibot-15", SE2(2.0, 2.0, 0.0), START_NS + 990_000_000),
        tracked(ROBOT, SE2(2.0, 2.0, 0.0), START_NS + 60_000_000_000),
    ],
    ids=["absurd", "another vehicle's", "from the future"],
)
def test_poses_that_cannot_be_right_change_nothing(wrong: TrackedPose) -> None:
    drive = Drive()
    drive.run(1.0, drive.orders.waiting)
    before = drive.status()
    assert not drive.pilot.camera_pose(wrong, drive.now_ns, drive.now_s)
    after = drive.status()
    assert (after.x, after.y, after.yaw, after.pose_age_s) == (before.x, before.y, before.yaw, before.pose_age_s)


def test_a_pose_from_the_future_does_not_stay_fresh_though_the_base_lives_there_too() -> None:
    drive = Drive()
    drive.camera_works = False
    ahead_ns = drive.now_ns + 30_000_000_000
    drive.pilot.odometry(drive.plant.reading(ahead_ns))
    assert not drive.pilot.camera_pose(tracked(ROBOT, drive.plant.pose, ahead_ns), drive.now_ns, drive.now_s)
    assert drive.status().pose_age_s is None


def test_a_pose_goes_stale_though_the_wall_clock_stands() -> None:
    drive = Drive()
    drive.run(1.0, drive.orders.waiting)
    status = drive.pilot.status(1, drive.now_ns, drive.now_s + 0.6, ip="", battery=None, faults=())
    assert status.pose_age_s is not None and status.pose_age_s > 0.5


def test_a_base_that_talks_nonsense_is_at_fault() -> None:
    drive = Drive()
    drive.run(1.0, drive.orders.waiting)
    drive.pilot.command(drive.orders.move_to(drive.now_ns, 5.0, 1.0), drive.now_ns, drive.now_s)
    drive.plant.odometry = SE2(1e308, 0.0, 0.0)
    drive.pilot.odometry(drive.plant.reading(drive.now_ns))
    decision = drive.pilot.decide(drive.now_ns, drive.now_s)
    assert decision.twist == STOP
    assert decision.stopped_by is not None and decision.stopped_by.code is ReasonCode.DRIVER_FAULT


def test_a_status_fits_its_datagram_whatever_the_texts() -> None:
    drive = Drive()
    drive.pilot.emergency_stop(EmergencyStop(engaged=True, epoch=1, reason="x" * 5000, by="y" * 5000))
    drive.run(0.2, drive.orders.waiting)
    faults: Iterable[str] = ["z" * 5000] * 20
    status = drive.pilot.status(1, drive.now_ns, drive.now_s, ip="127.0.0.1", battery=0.5, faults=tuple(faults))
    assert len(encode(status)) <= MAX_PAYLOAD


def test_an_empty_battery_ends_routes_but_a_hand_may_still_drive() -> None:
    drive = Drive()
    drive.run(2.0, to(drive, 6.0, 1.0))
    assert drive.plant.twist.linear_mps > 0.2
    drive.pilot.battery(VEHICLE.battery.empty)
    drive.run(1.0, to(drive, 6.0, 1.0))
    assert drive.plant.twist == STOP
    assert drive.stopped_by is not None and drive.stopped_by.code is ReasonCode.BATTERY_EMPTY
    assert "5%" in drive.stopped_by.text
    drive.run(1.0, lambda now_ns: drive.orders.drive(now_ns, 0.2))
    assert drive.plant.twist.linear_mps > 0.1
    drive.pilot.battery(VEHICLE.battery.empty + 0.01)
    drive.run(1.0, to(drive, 6.0, 1.0))
    assert drive.plant.twist == STOP, "a share that trembles is no charge"
    drive.pilot.battery(0.9)
    drive.run(1.0, to(drive, 6.0, 1.0))
    assert drive.plant.twist.linear_mps > 0.2


def test_a_stop_keeps_the_time_at_which_it_began_whatever_its_text_says() -> None:
    drive = Drive()
    drive.run(2.0, to(drive, 6.0, 1.0))
    assert drive.status().stopped_by is None
    drive.run(1.0, None)
    first = drive.status().stopped_by
    drive.run(1.0, None)
    later = drive.status().stopped_by
    assert first is not None and later is not None and first.since_ns is not None
    assert (first.code, first.since_ns) == (later.code, later.since_ns)
    assert first.text != later.text
    assert 0.5 <= (drive.now_ns - first.since_ns) / 1e9 <= 1.6
    drive.run(0.5, to(drive, 6.0, 1.0))
    assert drive.status().stopped_by is None
    drive.run(1.0, None)
    again = drive.status().stopped_by
    assert again is not None and again.since_ns is not None and again.since_ns > first.since_ns


def test_a_command_that_leads_out_of_the_areas_ends_at_their_border() -> None:
    drive = Drive()
    drive.run(12.0, to(drive, 1.0, -3.0, speed=0.5))
    assert drive.plant.twist.linear_mps == 0.0
    assert -0.50 < drive.plant.pose.y < -0.2
    assert drive.stopped_by is not None and drive.stopped_by.code is ReasonCode.OUTSIDE_AREA


def test_the_status_says_how_many_commands_are_lost() -> None:
    drive = Drive()
    drive.run(3.0, to(drive, 6.0, 1.0))
    assert drive.status().command_loss == 0.0
    for _ in range(15):
        drive.orders.waiting(drive.now_ns)  # made and never sent
        drive.run(0.2, None)
        command = drive.orders.move_to(drive.now_ns, 6.0, 1.0)
        drive.pilot.command(command, drive.now_ns, drive.now_s)
    lost = drive.status().command_loss
    assert lost is not None and 0.2 < lost < 0.6
