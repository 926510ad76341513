"""How robots and cameras look: the word for what a robot does, the reason, ages; the floor that a camera sees."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import SE3, CameraModel
from protocol.lab.address import without_password
from protocol.messages import (
    Assignment,
    AssignmentState,
    EmergencyStop,
    GuidanceState,
    ManualDrive,
    Movement,
    Reason,
    ReasonCode,
    RobotSettings,
)
from server.views.field_of_view import floor_outline, undistorted
from server.views.robots import Connection, FleetState, RobotState, RobotView, robot_view
from tests.server.samples import START_NS, command, pose, status
from tests.server.service import ROBOT, gulliver

VEHICLE = gulliver().vehicle(ROBOT)
NOW_NS = START_NS + 100_000_000


def assignment(state: AssignmentState) -> Assignment:
    return Assignment(id="1", robot=ROBOT, route="r", state=state, started_ns=1, changed_ns=1, reason="paused by eva")


def fleet(**changes: Any) -> FleetState:
    """A robot that drives along its route, with what is given changed."""
    state = FleetState(
        poses={ROBOT: pose(ROBOT, START_NS)},
        statuses={ROBOT: status(ROBOT, START_NS)},
        commands={ROBOT: command(ROBOT, START_NS)},
        assignments={ROBOT: assignment(AssignmentState.RUNNING)},
    )
    for name, value in changes.items():
        setattr(state, name, value)
    return state


def look(now_ns: int = NOW_NS, **changes: Any) -> RobotView:
    return robot_view(VEHICLE, fleet(**changes), now_ns)


def said(view: RobotView) -> tuple[RobotState, ReasonCode | None]:
    return view.state, view.reason.code if view.reason else None


def test_a_robot_on_its_way() -> None:
    view = look()
    assert said(view) == (RobotState.DRIVING, None)
    assert view.connection is Connection.ONLINE
    assert view.pose is not None
    assert (view.pose.age_s, view.pose.fresh) == (0.1, True)
    assert view.pose.position_std_m == pytest.approx(0.002)
    assert view.command is not None
    assert view.command.target is not None


STOPPED = EmergencyStop(engaged=True, reason="fire")
HAND = ManualDrive(robot=ROBOT, linear_mps=0, angular_radps=0, holder="h", by="h", expires_ns=NOW_NS + 1)
WAITING = {ROBOT: command(ROBOT, START_NS, movement=Movement.WAITING)}
IDLE = {ROBOT: command(ROBOT, START_NS, movement=Movement.NO_ACTION)}
PAUSED = {ROBOT: assignment(AssignmentState.PAUSED)}
FAULTY = {ROBOT: status(ROBOT, START_NS, faults=("motor",))}
HELD = {ROBOT: status(ROBOT, START_NS, stopped_by=Reason(code=ReasonCode.COMMAND_STALE, text="0.7 s"))}


@pytest.mark.parametrize(
    ("changes", "state", "code"),
    [
        ({"statuses": {}}, RobotState.OFFLINE, ReasonCode.NOT_CONNECTED),
        ({"emergency_stop": STOPPED}, RobotState.EMERGENCY_STOP, ReasonCode.EMERGENCY_STOP),
        ({"emergency_stop": STOPPED, "statuses": {}}, RobotState.OFFLINE, ReasonCode.NOT_CONNECTED),
        ({"statuses": FAULTY}, RobotState.FAULT, ReasonCode.DRIVER_FAULT),
        ({"manual": {ROBOT: HAND}}, RobotState.MANUAL, ReasonCode.MANUAL),
        ({"poses": {}}, RobotState.LOST, ReasonCode.POSE_STALE),
        ({"commands": WAITING}, RobotState.WAITING, ReasonCode.OBSTACLE),
        ({"commands": IDLE, "assignments": {}}, RobotState.IDLE, ReasonCode.OBSTACLE),
        ({"commands": {}}, RobotState.WAITING, ReasonCode.COMMAND_STALE),
        ({"commands": {}, "assignments": {}}, RobotState.IDLE, None),
        ({"assignments": PAUSED, "commands": WAITING}, RobotState.PAUSED, ReasonCode.PAUSED),
        ({"statuses": HELD}, RobotState.WAITING, ReasonCode.COMMAND_STALE),
    ],
)
def test_the_word_and_the_reason(changes: dict[str, Any], state: RobotState, code: ReasonCode | None) -> None:
    assert said(look(**changes)) == (state, code)


def test_what_grows_old_no_longer_counts() -> None:
    late = look(START_NS + 600_000_000)
    assert late.pose is not None
    assert not late.pose.fresh
    assert late.command is None
    assert said(late) == (RobotState.LOST, ReasonCode.POSE_STALE)
    later = look(START_NS + 1_500_000_000)
    assert later.connection is Connection.CONNECTION_BROKEN
    assert later.last_heard_ns == START_NS
    assert later.status is not None


def test_a_clock_that_is_a_little_ahead_makes_no_negative_age() -> None:
    view = look(START_NS - 50_000_000)
    assert view.pose is not None
    assert view.pose.age_s == 0.0


def test_leases_and_guidance_are_shown_while_fresh() -> None:
    state = GuidanceState(
        robot=ROBOT,
        stamp_ns=START_NS,
        reason=Reason(code=ReasonCode.OBSTACLE),
        blocked=True,
        box=((0, 0), (1, 0), (1, 1)),
        carrot=(0.5, 0.5),
    )
    changes: dict[str, Any] = {"guidance": {ROBOT: state}, "manual": {ROBOT: HAND}}
    fresh = look(NOW_NS, **changes)
    assert fresh.guidance is not None
    assert fresh.guidance.blocked
    assert fresh.manual is not None
    old = look(START_NS + 10**9, **changes)
    assert (old.guidance, old.manual) == (None, None)


def test_settings_lie_over_the_labs_box() -> None:
    view = look(settings={ROBOT: RobotSettings(box_start_m=0.0, stop_at_waypoint=True)})
    assert (view.obstacle_box.start_m, view.obstacle_box.stop_at_waypoint) == (0.0, True)
    assert view.obstacle_box.length_m == VEHICLE.obstacle_box.length_m


def test_ages_alone_change_nothing() -> None:
    first, second = look(NOW_NS), look(NOW_NS + 50_000_000)
    assert first != second
    assert first.without_ages() == second.without_ages()


@pytest.mark.parametrize(
    ("source", "shown"),
    [
        ("sim", "sim"),
        (0, "0"),
        ("/data/film.mp4", "/data/film.mp4"),
        ("rtsp://eva:secret@10.0.0.7:554/s?x=1", "rtsp://10.0.0.7:554/s?x=1"),
        ("http://user@camera/", "http://camera/"),
    ],
)
def test_sources_lose_their_passwords(source: str | int, shown: str) -> None:
    assert without_password(source) == shown


FULL_HD = CameraModel(1920, 1080, 1145.0, 1145.0, 960.0, 540.0)
DOWN = (math.pi, 0.0, 0.0)


def test_a_camera_that_looks_straight_down_sees_a_rectangle() -> None:
    outline = np.array(floor_outline(FULL_HD, DOWN, (2.0, 2.0, 3.0)))
    half = 3.0 / 1145.0 * np.array([960.0, 540.0])
    assert outline.min(axis=0) == pytest.approx(np.array([2.0, 2.0]) - half, abs=3e-3)
    assert outline.max(axis=0) == pytest.approx(np.array([2.0, 2.0]) + half, abs=3e-3)


def test_a_camera_that_sees_the_horizon_has_an_end() -> None:
    outline = np.array(floor_outline(FULL_HD, (math.pi / 2 + 0.2, 0.0, 0.0), (0.0, 0.0, 3.0)))
    assert len(outline) > 0
    assert np.hypot(*outline.T).max() <= 100.001


@pytest.mark.parametrize("rotvec", [(0.0, 0.0, 0.0)])
def test_a_camera_that_looks_up_sees_no_floor(rotvec: tuple[float, float, float]) -> None:
    assert floor_outline(FULL_HD, rotvec, (0.0, 0.0, 3.0)) == ()
    assert floor_outline(FULL_HD, DOWN, (0.0, 0.0, -1.0)) == ()


@given(
    x=st.floats(-0.8, 0.8),
    y=st.floats(-0.45, 0.45),
    k1=st.floats(-0.1, 0.1),
    k2=st.floats(-0.02, 0.02),
    p=st.floats(-0.002, 0.002),
)
def test_undistortion_inverts_the_model(x: float, y: float, k1: float, k2: float, p: float) -> None:
    """Brown-Conrady forwards, then back."""
    camera = CameraModel(1920, 1080, 1145.0, 1145.0, 960.0, 540.0, (k1, k2, p, -p, 0.0))
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2 * r2
    u = x * radial + 2 * p * x * y - p * (r2 + 2 * x * x)
    v = y * radial + p * (r2 + 2 * y * y) - 2 * p * x * y
    pixel = np.array([[960.0 + 1145.0 * u, 540.0 + 1145.0 * v]])
    assert undistorted(camera, pixel)[0] == pytest.approx([x, y], abs=1e-3)


def test_the_outline_turns_with_the_camera() -> None:
    turned = SE3.from_rotvec((0.0, 0.0, math.pi / 2), (0.0, 0.0, 0.0)) @ SE3.from_rotvec(DOWN, (0.0, 0.0, 3.0))
    rotvec = tuple(float(value) for value in turned.rotvec())
    outline = np.array(floor_outline(FULL_HD, rotvec, (0.0, 0.0, 3.0)))  # type: ignore[arg-type]
    span = outline.max(axis=0) - outline.min(axis=0)
    assert span[1] > span[0]


@pytest.mark.parametrize(
    ("changes", "since_ns"),
    [
        ({"emergency_stop": EmergencyStop(engaged=True, stamp_ns=5)}, 5),
        ({"assignments": PAUSED}, 1),
        ({"poses": {ROBOT: pose(ROBOT, START_NS - 10**9)}}, START_NS - 10**9),
        ({"commands": {ROBOT: command(ROBOT, START_NS - 10**9)}}, START_NS - 10**9),
        ({"statuses": {ROBOT: status(ROBOT, START_NS - 5 * 10**9)}}, START_NS - 5 * 10**9),
        (
            {
                "statuses": {
                    ROBOT: status(
                        ROBOT, START_NS, stopped_by=Reason(code=ReasonCode.PROTECTIVE_FIELD, text="near", since_ns=7)
                    )
                }
            },
            7,
        ),
    ],
)
def test_every_stop_has_its_time(changes: dict[str, Any], since_ns: int) -> None:
    reason = look(**changes).reason
    assert reason is not None and reason.since_ns == since_ns


def test_the_quality_of_the_link_is_shown() -> None:
    heard = status(ROBOT, START_NS, command_loss=0.123)
    view = look(statuses={ROBOT: heard}, losses={ROBOT: 0.25})
    assert view.status is not None
    assert (view.status.command_loss, view.status.loss) == (0.12, 0.25)


def test_a_stop_by_broadcast_that_the_server_has_not_heard_of_is_one() -> None:
    stop = Reason(code=ReasonCode.EMERGENCY_STOP, text="by anna", since_ns=3)
    assert look(statuses={ROBOT: status(ROBOT, START_NS, stopped_by=stop)}).state is RobotState.EMERGENCY_STOP
