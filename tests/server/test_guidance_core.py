"""What guidance commands for which reason: the precedence of reasons, and what must hold whatever happens."""

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from msgspec import structs

from protocol.lab import VehicleSpec
from protocol.messages import (
    Assignment,
    AssignmentState,
    Command,
    EmergencyStop,
    EventLevel,
    ManualDrive,
    Movement,
    ReasonCode,
    Route,
)
from server.guidance.fleet import Guidance
from server.guidance.parameters import GuidanceParameters
from server.guidance.snapshot import Outcome, Snapshot
from tests.server.guidance_scenario import (
    LAB,
    OTHER,
    ROBOT,
    START_NS,
    Course,
    assignment,
    raster,
    square,
    status,
    tracked,
)

SECOND = 1_000_000_000
COURSE = Course([(4.0, 1.0), (4.0, 3.0)])
ENGAGED = EmergencyStop(engaged=True, epoch=3, by="anna", reason="smoke")


def driving(**changes: Any) -> Snapshot:
    """A robot on its route with nothing in its way, but for the changes."""
    everything = Snapshot(
        now_ns=START_NS,
        now_s=0.0,
        poses={ROBOT: tracked(ROBOT, 1.0, 1.0)},
        statuses={ROBOT: status(ROBOT)},
        obstacles=raster(),
        waypoints=COURSE.waypoints(),
        routes=COURSE.routes(),
        assignments={ROBOT: assignment()},
    )
    return replace(everything, **changes)


def hand(linear: float = 0.3, angular: float = 0.0, lease_s: float = 0.5) -> dict[str, ManualDrive]:
    expires = START_NS + round(lease_s * SECOND)
    return {
        ROBOT: ManualDrive(
            robot=ROBOT, linear_mps=linear, angular_radps=angular, holder="anna", by="anna", expires_ns=expires
        )
    }


def later(snapshot: Snapshot, seconds: float) -> Snapshot:
    """The same, seen and heard anew so much later."""
    now_ns = snapshot.now_ns + round(seconds * SECOND)
    return replace(
        snapshot,
        now_ns=now_ns,
        now_s=snapshot.now_s + seconds,
        poses={name: structs.replace(pose, stamp_ns=now_ns) for name, pose in snapshot.poses.items()},
        statuses={name: status(name, now_ns) for name in snapshot.statuses},
        obstacles=raster(stamp_ns=now_ns),
    )


def command(snapshot: Snapshot) -> Command:
    return Guidance(LAB).cycle(snapshot, epoch=7).commands[ROBOT]


def verdict(snapshot: Snapshot) -> tuple[Movement, ReasonCode]:
    said = command(snapshot)
    return said.movement, said.reason.code


def test_every_vehicle_gets_a_command_every_cycle_with_its_address_and_deadline() -> None:
    guidance = Guidance(LAB)
    first, second = guidance.cycle(driving(), 7), guidance.cycle(driving(), 7)
    assert set(first.commands) == {vehicle.id for vehicle in LAB.vehicles} == set(first.states)
    for robot, said in first.commands.items():
        assert (said.robot, said.epoch, said.stamp_ns) == (robot, 7, START_NS)
        assert said.deadline_ns == START_NS + SECOND // 2
        assert second.commands[robot].order > said.order


def test_a_clear_way_means_move_to() -> None:
    said = command(driving())
    assert said.movement is Movement.MOVE_TO
    assert said.target is not None
    assert (said.target.x, said.target.y) == pytest.approx((1.8, 1.0))
    assert said.speed_mps == pytest.approx(0.3)
    state = Guidance(LAB).cycle(driving(), 7).states[ROBOT]
    assert state.carrot == pytest.approx((1.8, 1.0))
    assert state.path[-1] == (4.0, 3.0)
    assert state.leg == 0
    assert not state.blocked
    assert len(state.box) >= 4


def test_the_speed_is_the_legs_scaled_within_the_vehicles_limit() -> None:
    fast = assignment().model_copy(update={"speed_scale": 2.0})
    assert command(driving(assignments={ROBOT: fast})).speed_mps == pytest.approx(0.6)
    legs = tuple(leg.model_copy(update={"speed_mps": 5.0}) for leg in COURSE.routes()["r"].legs)
    limit = LAB.vehicle(ROBOT).limits.speed_mps
    assert command(driving(routes={"r": Route(id="r", legs=legs)})).speed_mps == pytest.approx(limit)


@pytest.mark.parametrize(
    ("changes", "movement", "code"),
    [
        pytest.param({"assignments": {}}, Movement.NO_ACTION, ReasonCode.IDLE, id="nothing to do"),
        pytest.param(
            {"assignments": {}, "statuses": {}}, Movement.NO_ACTION, ReasonCode.NOT_CONNECTED, id="nobody there"
        ),
        pytest.param({"emergency_stop": ENGAGED}, Movement.WAITING, ReasonCode.EMERGENCY_STOP, id="emergency stop"),
        pytest.param(
            {"emergency_stop": ENGAGED, "manual": hand()},
            Movement.WAITING,
            ReasonCode.EMERGENCY_STOP,
            id="emergency stop over hand",
        ),
        pytest.param({"poses": {}}, Movement.WAITING, ReasonCode.POSE_STALE, id="never seen"),
        pytest.param(
            {"poses": {ROBOT: tracked(ROBOT, 1.0, 1.0, stamp_ns=START_NS - 6 * SECOND // 10)}},
            Movement.WAITING,
            ReasonCode.POSE_STALE,
            id="old pose",
        ),
        pytest.param(
            {"poses": {ROBOT: tracked(ROBOT, 1.0, 1.0, stamp_ns=START_NS + SECOND)}},
            Movement.WAITING,
            ReasonCode.POSE_STALE,
            id="pose from the future",
        ),
        pytest.param({"statuses": {}}, Movement.WAITING, ReasonCode.NOT_CONNECTED, id="silent robot"),
        pytest.param(
            {"poses": {ROBOT: tracked(ROBOT, -1.0, 1.0)}}, Movement.WAITING, ReasonCode.OUTSIDE_AREA, id="outside"
        ),
        pytest.param({"obstacles": None}, Movement.WAITING, ReasonCode.OBSTACLES_UNKNOWN, id="no raster"),
        pytest.param(
            {"obstacles": raster(stamp_ns=START_NS - 2 * SECOND)},
            Movement.WAITING,
            ReasonCode.OBSTACLES_UNKNOWN,
            id="old raster",
        ),
        pytest.param({"obstacles": raster([square(1.6, 1.0)])}, Movement.WAITING, ReasonCode.OBSTACLE, id="pallet"),
        pytest.param(
            {"poses": {ROBOT: tracked(ROBOT, 1.0, 1.0), OTHER: tracked(OTHER, 1.6, 1.0)}},
            Movement.WAITING,
            ReasonCode.ROBOT_AHEAD,
            id="robot",
        ),
        pytest.param(
            {"assignments": {ROBOT: assignment(state=AssignmentState.PAUSED)}},
            Movement.WAITING,
            ReasonCode.PAUSED,
            id="paused",
        ),
        pytest.param(
            {"assignments": {ROBOT: assignment(state=AssignmentState.DONE)}},
            Movement.NO_ACTION,
            ReasonCode.ROUTE_DONE,
            id="done",
        ),
        pytest.param(
            {"assignments": {ROBOT: assignment(state=AssignmentState.STOPPED)}},
            Movement.NO_ACTION,
            ReasonCode.IDLE,
            id="stopped",
        ),
        pytest.param({"manual": hand()}, Movement.DRIVE, ReasonCode.MANUAL, id="hand over route"),
        pytest.param({"manual": hand(lease_s=-0.1)}, Movement.WAITING, ReasonCode.MANUAL, id="hand just lost"),
        pytest.param({"manual": hand(lease_s=-3.1)}, Movement.MOVE_TO, ReasonCode.ROUTE, id="lease over"),
        pytest.param({"manual": hand(0.0, lease_s=-0.1)}, Movement.MOVE_TO, ReasonCode.ROUTE, id="let go"),
        pytest.param({"manual": hand(lease_s=3600.0)}, Movement.MOVE_TO, ReasonCode.ROUTE, id="lease that cannot be"),
    ],
)
def test_reasons_in_the_order_of_their_weight(changes: dict[str, Any], movement: Movement, code: ReasonCode) -> None:
    assert verdict(driving(**changes)) == (movement, code)


def test_a_raster_that_contradicts_itself_is_none() -> None:
    broken = structs.replace(raster(), occupied=b"short")
    assert verdict(driving(obstacles=broken))[1] is ReasonCode.OBSTACLES_UNKNOWN


def test_a_way_that_no_camera_sees_is_waited_for() -> None:
    unseen = structs.replace(raster(), observed=bytes(len(raster().observed)))
    assert verdict(driving(obstacles=unseen))[1] is ReasonCode.OBSTACLES_UNKNOWN
    trusting = Guidance(LAB, GuidanceParameters(unseen_share=1.0))
    outcome = trusting.cycle(driving(obstacles=unseen), 1)
    assert outcome.commands[ROBOT].movement is Movement.MOVE_TO


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"routes": {}}, "route r does not exist"),
        ({"waypoints": {}}, "waypoint w0 of route r does not exist"),
        ({"assignments": {ROBOT: assignment(leg=9)}}, "has 2 legs"),
    ],
)
def test_a_route_that_cannot_be_driven_fails_and_says_why(changes: dict[str, Any], words: str) -> None:
    guidance = Guidance(LAB)
    guidance.cycle(driving(), 1)
    outcome = guidance.cycle(driving(**changes), 1)
    assert outcome.commands[ROBOT].movement is Movement.NO_ACTION
    (change,) = outcome.changes
    assert change.after.state is AssignmentState.FAILED
    assert words in change.after.reason
    assert change.after.changed_ns > change.before.changed_ns
    assert [event.kind for event in outcome.events] == ["route_failed"]
    assert words in outcome.events[0].text


def test_a_change_of_reason_is_told_once() -> None:
    guidance = Guidance(LAB)

    def kinds(snapshot: Snapshot) -> list[str]:
        return [event.kind for event in guidance.cycle(snapshot, 1).events]

    assert kinds(driving()) == []
    blocked = driving(obstacles=raster([square(1.6, 1.0)]))
    assert kinds(blocked) == ["robot_waiting"]
    assert kinds(blocked) == []
    assert kinds(replace(driving(), now_s=1.0)) == ["robot_driving"]


def test_a_box_counts_as_clear_only_after_a_while() -> None:
    guidance = Guidance(LAB)

    def moves(now_s: float, *pallets: list[tuple[float, float]]) -> bool:
        snapshot = driving(now_s=now_s, obstacles=raster(pallets))
        return guidance.cycle(snapshot, 1).commands[ROBOT].movement is Movement.MOVE_TO

    assert moves(0.0)
    assert not moves(0.1, square(1.6, 1.0))
    assert not moves(0.2)
    assert not moves(0.35)
    assert moves(0.45)


class TestHand:
    def drive(self, linear: float, x: float, y: float = 1.0, yaw: float = 0.0, angular: float = 0.0) -> Command:
        return command(driving(manual=hand(linear, angular), poses={ROBOT: tracked(ROBOT, x, y, yaw)}))

    def test_its_twist_is_clipped_to_the_vehicle(self) -> None:
        said = self.drive(9.0, 4.0, angular=-9.0)
        limits = LAB.vehicle(ROBOT).limits
        assert (said.linear_mps, said.angular_radps) == (limits.speed_mps, -limits.yaw_rate_radps)

    def test_it_stops_at_the_border_and_comes_back(self) -> None:
        assert self.drive(0.5, 8.2).linear_mps == 0.0
        assert "border" in self.drive(0.5, 8.2).reason.text
        assert self.drive(-0.5, 8.2).linear_mps == -0.5
        assert self.drive(0.5, 9.0).linear_mps == 0.0
        assert self.drive(-0.5, 9.0).linear_mps == -0.5
        assert self.drive(0.5, 8.2, angular=0.4).angular_radps == 0.4

    @pytest.mark.parametrize("assignments", [{}, {ROBOT: assignment()}])
    def test_a_robot_that_nobody_sees_is_not_driven_and_says_why(self, assignments: dict[str, Assignment]) -> None:
        said = command(driving(manual=hand(0.8), poses={}, assignments=assignments))
        assert (said.movement, said.reason.code) == (Movement.WAITING, ReasonCode.POSE_STALE)
        assert said.reason.text == "anna cannot drive it by hand: no camera sees it"

    @pytest.mark.parametrize("linear", [0.3, 0.0])
    def test_a_hand_that_is_lost_keeps_the_route_from_going_on_at_once(self, linear: float) -> None:
        guidance = Guidance(LAB)

        def after(seconds: float) -> Outcome:
            return guidance.cycle(later(driving(manual=hand(linear)), seconds), 1)

        assert after(0.0).commands[ROBOT].movement is Movement.DRIVE
        assert after(0.4).commands[ROBOT].movement is Movement.DRIVE
        lost = after(0.6)
        assert lost.commands[ROBOT].movement is Movement.WAITING
        assert lost.commands[ROBOT].reason.code is ReasonCode.MANUAL
        assert [(event.kind, event.level) for event in lost.events] == [("robot_waiting", EventLevel.WARNING)]
        assert "the hand of anna was lost" in lost.events[0].text
        assert after(3.4).commands[ROBOT].movement is Movement.WAITING
        again = after(3.6)
        assert again.commands[ROBOT].movement is Movement.MOVE_TO
        assert [event.kind for event in again.events] == ["robot_driving"]

    @pytest.mark.parametrize("linear", [0.3, 0.0])
    def test_a_hand_that_lets_go_hands_back_at_once(self, linear: float) -> None:
        guidance = Guidance(LAB)
        held = driving(manual=hand(linear))
        assert guidance.cycle(held, 1).commands[ROBOT].movement is Movement.DRIVE
        released = later(driving(manual=hand(0.0, lease_s=0.2)), 0.2)
        assert guidance.cycle(released, 1).commands[ROBOT].movement is Movement.MOVE_TO

    def test_obstacles_are_its_own_business(self) -> None:
        assert verdict(driving(manual=hand(), obstacles=raster([square(1.6, 1.0)])))[0] is Movement.DRIVE

    def test_letting_go_hands_back(self) -> None:
        guidance = Guidance(LAB)
        assert guidance.cycle(driving(manual=hand()), 1).commands[ROBOT].movement is Movement.DRIVE
        assert guidance.cycle(driving(), 1).commands[ROBOT].movement is Movement.MOVE_TO
        assert verdict(driving(manual=hand(lease_s=-1), assignments={})) == (Movement.NO_ACTION, ReasonCode.IDLE)


def test_a_waypoint_passed_by_hand_is_not_reached() -> None:
    guidance = Guidance(LAB)
    guidance.cycle(driving(), 1)
    before = driving(manual=hand(), poses={ROBOT: tracked(ROBOT, 3.5, 1.0)})
    guidance.cycle(before, 1)
    guidance.cycle(replace(before, poses={ROBOT: tracked(ROBOT, 4.5, 1.0)}), 1)
    outcome = guidance.cycle(replace(before, manual={}, poses={ROBOT: tracked(ROBOT, 4.6, 1.0)}), 1)
    assert outcome.changes == ()


def test_a_loop_over_a_single_waypoint_ends_there() -> None:
    course = Course([(1.0, 1.0)], loop=True)
    outcome = Guidance(LAB).cycle(driving(routes=course.routes(), waypoints=course.waypoints()), 1)
    assert outcome.changes[0].after.state is AssignmentState.DONE


def test_a_robot_that_does_not_get_on_is_named_once() -> None:
    guidance = Guidance(LAB)
    kinds = [event.kind for s in range(60) for event in guidance.cycle(driving(now_s=float(s)), 1).events]
    assert kinds == ["no_progress"]


def test_a_look_ahead_that_cannot_steer_is_refused() -> None:
    with pytest.raises(ValueError, match="does not steer"):
        GuidanceParameters(look_ahead_m=0.3)


ages = st.sampled_from([0.0, 0.1, 0.4, 0.6, 5.0])
place = st.tuples(st.floats(-1.0, 9.0), st.floats(-1.0, 5.0), st.floats(-3.1, 3.1))
PALLET = square(4.0, 2.2, side=2.0)


class Fleet(RuleBasedStateMachine):
    """Everything that guidance reads changes at random; what must never happen is looked for after every cycle."""

    def __init__(self) -> None:
        super().__init__()
        self.guidance = Guidance(LAB)
        self.vehicles: list[VehicleSpec] = list(LAB.vehicles)
        self.before = self.snapshot = driving(assignments={v.id: assignment(v.id) for v in LAB.vehicles})
        self.outcome: Outcome | None = None
        self.highest: dict[str, int] = {}
        self.epoch = 1

    @rule(robot=st.sampled_from([v.id for v in LAB.vehicles]), at=place, age=ages, speed=st.floats(0.0, 0.8))
    def seen(self, robot: str, at: tuple[float, float, float], age: float, speed: float) -> None:
        pose = tracked(robot, *at, stamp_ns=self.snapshot.now_ns - round(age * SECOND), speed=speed)
        self.snapshot = replace(self.snapshot, poses={**self.snapshot.poses, robot: pose})

    @rule(robot=st.sampled_from([v.id for v in LAB.vehicles]), age=ages)
    def heard(self, robot: str, age: float) -> None:
        said = status(robot, self.snapshot.now_ns - round(age * SECOND))
        self.snapshot = replace(self.snapshot, statuses={**self.snapshot.statuses, robot: said})

    @rule(
        robot=st.sampled_from([v.id for v in LAB.vehicles]),
        state=st.sampled_from(AssignmentState),
        leg=st.integers(0, 2),
    )
    def assigned(self, robot: str, state: AssignmentState, leg: int) -> None:
        new = assignment(robot, state, leg=leg)
        self.snapshot = replace(self.snapshot, assignments={**self.snapshot.assignments, robot: new})

    @rule(engaged=st.booleans())
    def latch(self, engaged: bool) -> None:
        self.snapshot = replace(self.snapshot, emergency_stop=EmergencyStop(engaged=engaged))

    @rule(blocked=st.booleans(), age=ages)
    def obstacles(self, blocked: bool, age: float) -> None:
        new = raster([PALLET] if blocked else [], self.snapshot.now_ns - round(age * SECOND))
        self.snapshot = replace(self.snapshot, obstacles=new)

    @rule(robot=st.sampled_from([v.id for v in LAB.vehicles]), linear=st.floats(-2, 2), lease=st.floats(-1.0, 3.0))
    def stick(self, robot: str, linear: float, lease: float) -> None:
        expires = self.snapshot.now_ns + round(lease * SECOND)
        drive = ManualDrive(
            robot=robot, linear_mps=linear, angular_radps=0.0, holder="anna", by="anna", expires_ns=expires
        )
        self.snapshot = replace(self.snapshot, manual={**self.snapshot.manual, robot: drive})

    @rule(there=st.booleans())
    def route(self, there: bool) -> None:
        self.snapshot = replace(self.snapshot, waypoints=COURSE.waypoints() if there else {})

    @rule(seconds=st.sampled_from([0.1, 0.3, 1.0]))
    def cycle(self, seconds: float) -> None:
        now_ns, now_s = self.snapshot.now_ns + round(seconds * SECOND), self.snapshot.now_s + seconds
        self.snapshot = replace(self.snapshot, now_ns=now_ns, now_s=now_s)
        self.outcome = self.guidance.cycle(self.snapshot, self.epoch)
        assignments = {**self.snapshot.assignments}
        for change in self.outcome.changes:
            assert assignments[change.before.robot] == change.before
            assignments[change.before.robot] = change.after
        self.before, self.snapshot = self.snapshot, replace(self.snapshot, assignments=assignments)
        for robot, said in self.outcome.commands.items():
            assert said.sequence > self.highest.get(robot, -1)
            self.highest[robot] = said.sequence

    @invariant()
    def safe(self) -> None:
        if self.outcome is None:
            return
        was = self.before
        assert set(self.outcome.commands) == {v.id for v in self.vehicles}
        for vehicle in self.vehicles:
            said, state = self.outcome.commands[vehicle.id], self.outcome.states[vehicle.id]
            assert said.reason == state.reason
            stopped = was.emergency_stop is not None and was.emergency_stop.engaged
            assert not stopped or said.movement is Movement.WAITING
            assert abs(said.linear_mps) <= vehicle.limits.speed_mps
            assert said.speed_mps <= vehicle.limits.speed_mps
            if said.movement in (Movement.MOVE_TO, Movement.ROTATE):
                self.may_drive(was, vehicle, said)
            if said.movement is Movement.DRIVE:
                assert was.manual[vehicle.id].expires_ns > was.now_ns

    def may_drive(self, was: Snapshot, vehicle: VehicleSpec, said: Command) -> None:
        pose = was.poses[vehicle.id]
        assert was.age_s(pose.stamp_ns) <= 0.5
        assert LAB.area_at(pose.x, pose.y) is not None
        assert was.age_s(was.statuses[vehicle.id].stamp_ns) <= 1.0
        assert was.assignments[vehicle.id].state is AssignmentState.RUNNING
        assert was.obstacles is not None
        if said.movement is Movement.MOVE_TO:
            assert was.age_s(was.obstacles.stamp_ns) <= 1.0
            assert self.outcome is not None
            assert not self.outcome.states[vehicle.id].blocked
            assert self.outcome.states[vehicle.id].blockage is None


Fleet.TestCase.settings = settings(max_examples=60, stateful_step_count=30, deadline=None)
TestFleet = Fleet.TestCase
