"""What allows the robot to move: gate, latch, dead-man's switch, range sensor (spec gpss, "Safety")."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from agents.control import GpssController
from agents.estimation import ExponentialFilter
from agents.motion import STOP, Twist
from agents.pilot import Decision, Pilot
from agents.safety import CommandGate, EmergencyStopLatch, FrontGuard, Situation, Verdict, why_still
from geometry import SE2
from protocol.lab import load_lab
from protocol.messages import Command, EmergencyStop, ReasonCode
from tests.agents.orders import Orders
from tests.agents.plant import Plant, tracked

ROBOT = "wifibot-14"
LAB = load_lab("labs/gulliver.yaml")
VEHICLE = LAB.vehicle(ROBOT)
S = 1_000_000_000
NOW_NS = 1_700_000_000 * S


def ordered(epoch: int, sequence: int, *, robot: str = ROBOT, deadline_ns: int = NOW_NS + S) -> Command:
    command = Orders(robot).waiting(NOW_NS)
    return command.model_copy(update={"epoch": epoch, "sequence": sequence, "deadline_ns": deadline_ns})


def test_commands_are_obeyed_in_order_only() -> None:
    gate = CommandGate(ROBOT)
    offers = [
        (ordered(2, 5), Verdict.OBEYED),
        (ordered(2, 5), Verdict.OLD),
        (ordered(2, 4), Verdict.OLD),
        (ordered(1, 99), Verdict.OLD_EPOCH),
        (ordered(2, 6, robot="wifibot-15"), Verdict.FOREIGN),
        (ordered(2, 6, deadline_ns=NOW_NS - 1), Verdict.EXPIRED),
        (ordered(2, 6), Verdict.OBEYED),
        (ordered(3, 0), Verdict.OBEYED),
        (ordered(2, 7), Verdict.OLD_EPOCH),
    ]
    assert [gate.offer(command, NOW_NS, 0.0) for command, _ in offers] == [verdict for _, verdict in offers]
    assert gate.current == ordered(3, 0)
    assert gate.counts == {"obeyed": 3, "old": 2, "old_epoch": 2, "foreign": 1, "expired": 1}


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 5)), max_size=30))
def test_the_gate_never_goes_back(orders: list[tuple[int, int]]) -> None:
    gate = CommandGate(ROBOT)
    obeyed = [order for order in orders if gate.offer(ordered(*order), NOW_NS, 0.0) is Verdict.OBEYED]
    assert all(a < b for a, b in itertools.pairwise(obeyed))
    assert gate.current is None or gate.current.order == max(orders)


def test_a_command_is_fresh_for_half_a_second_and_never_past_its_deadline() -> None:
    gate = CommandGate(ROBOT)
    gate.offer(ordered(1, 1, deadline_ns=NOW_NS + 10 * S), NOW_NS, 100.0)
    assert gate.fresh(NOW_NS, 100.5) is not None
    assert gate.fresh(NOW_NS, 100.51) is None, "the monotonic clock counts even if the wall clock stands"
    gate.offer(ordered(1, 2, deadline_ns=NOW_NS + S // 10), NOW_NS, 200.0)
    assert gate.fresh(NOW_NS + S // 10, 200.1) is not None
    assert gate.fresh(NOW_NS + S // 10 + 1, 200.1) is None


def test_the_latch_is_released_by_a_newer_release_only() -> None:
    latch = EmergencyStopLatch()
    reason = latch.forbids()
    assert reason is not None and reason.code is ReasonCode.NOT_CONNECTED, "unknown is no permission"
    latch.update(EmergencyStop(engaged=False, epoch=4))
    assert latch.forbids() is None
    latch.update(EmergencyStop(engaged=True, epoch=5, reason="smoke", by="anna"))
    reason = latch.forbids()
    assert reason is not None and (reason.code, reason.text) == (ReasonCode.EMERGENCY_STOP, "smoke by anna")
    assert not latch.update(EmergencyStop(engaged=False, epoch=4))
    assert not latch.update(EmergencyStop(engaged=False, epoch=5))
    assert latch.engaged
    assert latch.update(EmergencyStop(engaged=False, epoch=6))
    assert latch.forbids() is None


def test_an_old_engagement_stops_with_an_epoch_after_the_newest_release() -> None:
    latch = EmergencyStopLatch()
    latch.update(EmergencyStop(engaged=False, epoch=6))
    latch.update(EmergencyStop(engaged=True, epoch=5))
    assert (latch.engaged, latch.epoch) == (True, 7), (
        "greater than the release's: who hears of it knows that it came after"
    )
    latch.update(EmergencyStop(engaged=True, epoch=5))
    assert latch.epoch == 7, "told again"
    for old in (6, 7):
        latch.update(EmergencyStop(engaged=False, epoch=old))
        assert latch.engaged, "a release from before that engagement was heard"
    latch.update(EmergencyStop(engaged=False, epoch=8))
    assert not latch.engaged


def test_the_gravest_reason_comes_first() -> None:
    command = ordered(1, 1)
    latch = EmergencyStopLatch()
    latch.update(EmergencyStop(engaged=True, epoch=1))

    def code(situation: Situation) -> ReasonCode | None:
        reason = why_still(situation)
        return None if reason is None else reason.code

    assert code(Situation(latch.forbids(), "no motor", None, None, None)) is ReasonCode.EMERGENCY_STOP
    assert code(Situation(None, "no motor", None, None, None)) is ReasonCode.DRIVER_FAULT
    assert code(Situation(None, None, None, 0.7, None)) is ReasonCode.COMMAND_STALE
    assert code(Situation(None, None, command, 0.1, None)) is ReasonCode.POSE_STALE
    assert code(Situation(None, None, command, 0.1, 0.51)) is ReasonCode.POSE_STALE
    assert code(Situation(None, None, command, 0.1, 0.5)) is None


def test_the_range_sensor_stops_forward_motion_only() -> None:
    guard, forward = FrontGuard(), Twist(0.3, 0.1)
    assert guard.limit(forward, None) == (forward, None)
    assert guard.limit(forward, 0.21) == (forward, None)
    twist, reason = guard.limit(forward, 0.20)
    assert twist == STOP
    assert reason is not None and reason.code is ReasonCode.OBSTACLE
    assert guard.limit(forward, 0.22)[0] == STOP, "no trembling around the limit"
    assert guard.limit(Twist(0.0, 0.5), 0.1) == (Twist(0.0, 0.5), None)
    assert guard.limit(Twist(-0.2, 0.0), 0.1) == (Twist(-0.2, 0.0), None)
    assert guard.limit(forward, 0.26) == (forward, None)


class PilotStateMachine(RuleBasedStateMachine):
    """Anything may happen in any order; the invariant restates the safety rules without looking at how they are kept."""

    def __init__(self) -> None:
        super().__init__()
        self.pilot = Pilot(LAB, VEHICLE, ExponentialFilter(), GpssController(VEHICLE.limits))
        self.plant = Plant(SE2(1.0, 1.0, 0.0))
        self.now_s = 0.0
        self.session = 0
        self.engaged: bool | None = None
        self.estop_epoch = 0
        self.order = (0, 0)
        self.command: Command | None = None
        self.command_at = -9.0
        self.captured_at = -9.0
        self.aligned = False
        self.base_at = -9.0
        self.fault = True
        self.range_m: float | None = None
        self.decision: Decision | None = None

    @property
    def now_ns(self) -> int:
        return NOW_NS + round(self.now_s * S)

    @rule(ticks=st.integers(1, 8))
    def time_passes(self, ticks: int) -> None:
        for _ in range(ticks):
            self.now_s += 0.1
            self.plant.step(0.1)

    @rule(driver_works=st.booleans(), fault=st.booleans(), near=st.booleans())
    def base_reports(self, driver_works: bool, fault: bool, near: bool) -> None:
        if not driver_works:
            self.pilot.odometry_failed("silent")
            self.fault = True
            return
        self.range_m = 0.1 if near else None
        reading = self.plant.reading(self.now_ns, f"s{self.session}", self.range_m)
        self.pilot.odometry(reading, ("motor hot",) if fault else ())
        self.base_at, self.fault = self.now_s, fault

    @rule()
    def base_restarts(self) -> None:
        self.session += 1
        self.plant.restart_base()
        self.pilot.odometry(self.plant.reading(self.now_ns, f"s{self.session}"), ())
        self.base_at, self.fault, self.range_m, self.aligned = self.now_s, False, None, False

    @rule(age_s=st.sampled_from([0.0, 0.1, 0.4, 0.6]), vehicle=st.sampled_from([ROBOT, "wifibot-15"]))
    def camera_sees(self, age_s: float, vehicle: str) -> None:
        pose = tracked(vehicle, self.plant.pose, self.now_ns - round(age_s * S))
        used = self.pilot.camera_pose(pose, self.now_ns, self.now_s)
        assert not (used and vehicle != ROBOT)
        if used:
            self.captured_at, self.aligned = self.now_s - age_s, True

    @rule(
        order=st.tuples(st.integers(1, 3), st.integers(1, 50)),
        late_s=st.sampled_from([0.0, 0.3, 0.7]),
        kind=st.sampled_from(["move", "rotate", "wait", "drive", "reverse"]),
    )
    def command_arrives(self, order: tuple[int, int], late_s: float, kind: str) -> None:
        orders, sent_ns = Orders(ROBOT), self.now_ns - round(late_s * S)
        command = {
            "move": orders.move_to(sent_ns, 4.0, 2.0),
            "rotate": orders.rotate(sent_ns, 2.0),
            "wait": orders.waiting(sent_ns),
            "drive": orders.drive(sent_ns, 0.5, 0.1),
            "reverse": orders.drive(sent_ns, -0.2, 0.0),
        }[kind].model_copy(update={"epoch": order[0], "sequence": order[1]})
        self.pilot.command(command, self.now_ns, self.now_s)
        if order > self.order and late_s <= 0.5:
            self.order, self.command, self.command_at = order, command, self.now_s

    @rule(engaged=st.booleans(), newer=st.booleans())
    def emergency_stop(self, engaged: bool, newer: bool) -> None:
        self.estop_epoch += newer
        self.pilot.emergency_stop(EmergencyStop(engaged=engaged, epoch=self.estop_epoch))
        if engaged and self.engaged is False and not newer:
            self.estop_epoch += 1  # whatever its sender's clock says, it came after the release
        if engaged or not self.engaged or newer:
            self.engaged = engaged

    @invariant()
    def moves_only_with_authority(self) -> None:
        decision = self.pilot.decide(self.now_ns, self.now_s)
        self.plant.setpoint = decision.twist
        allowed = (
            self.engaged is False
            and not self.fault
            and self.command is not None
            and self.now_s - self.command_at <= 0.5 + 1e-6
            and self.now_ns <= self.command.deadline_ns
            and self.aligned
            and self.now_s - self.captured_at <= 0.5 + 1e-6
        )
        if not allowed:
            assert decision.twist == STOP
            assert decision.stopped_by is not None
        else:
            assert self.command is not None
            # No stop without need either: what is obeyed is the newest command, unless something stands ahead.
            blocked = self.range_m is not None and decision.stopped_by is not None
            assert blocked or decision.stopped_by is None
            status = self.pilot.status(1, self.now_ns, self.now_s, ip="", battery=None, faults=())
            assert status.command_order == self.command.order
        if decision.twist.linear_mps > 0.0:
            assert self.range_m is None
        assert abs(decision.twist.linear_mps) <= VEHICLE.limits.speed_mps
        assert abs(decision.twist.angular_radps) <= VEHICLE.limits.yaw_rate_radps


PilotStateMachine.TestCase.settings = settings(max_examples=100, stateful_step_count=40, deadline=None)
test_nothing_moves_without_authority = pytest.mark.timeout(120)(PilotStateMachine.TestCase)
