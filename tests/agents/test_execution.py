"""Commands carried out in a closed loop with a small vehicle: arrival, headings, standing still."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.control import Executor, GpssController, turn_to
from agents.motion import STOP, Twist
from geometry import SE2, angle_difference
from protocol.messages import Command
from tests.agents.orders import Orders
from tests.agents.plant import LIMITS, Plant, distance

ORDERS = Orders("wifibot-14")


def run(plant: Plant, executor: Executor, command: Command, seconds: float, start_s: float = 0.0) -> float | None:
    """The time at which the command was reached; drives on until `seconds`."""
    reached_s = None
    for tick in range(round(seconds * 20)):
        now_s = start_s + tick / 20
        execution = executor.execute(command, plant.pose, plant.twist, now_s)
        if execution.reached and reached_s is None:
            reached_s = now_s
        plant.setpoint = execution.twist
        for _ in range(5):
            plant.step(0.01)
    return reached_s


@pytest.fixture
def executor() -> Executor:
    return Executor(GpssController(LIMITS), LIMITS)


def test_stands_well_inside_the_tolerance_and_stays(executor: Executor) -> None:
    plant = Plant(SE2.identity())
    command = ORDERS.move_to(0, 2.0, 1.0)
    assert run(plant, executor, command, 40.0) is not None
    assert plant.twist == STOP
    assert distance(plant.pose, 2.0, 1.0) <= 0.12
    stands_at = plant.pose
    run(plant, executor, command, 5.0, 40.0)
    assert plant.pose == stands_at


@pytest.mark.parametrize(
    ("distances_m", "reached"),
    [
        ([0.16, 0.14, 0.12], False),
        ([0.16, 0.14, 0.12, 0.099], True),
        ([0.16, 0.14, 0.12, 0.125], False),
        ([0.16, 0.14, 0.12, 0.131], True),
        ([0.16, 0.14] + [0.12] * 38, False),
        ([0.16, 0.14] + [0.12] * 41, True),
    ],
    ids=["still nearing", "near enough", "noise", "moving away", "slow", "stuck"],
)
def test_reached_is_said_when_it_gets_no_nearer(executor: Executor, distances_m: list[float], reached: bool) -> None:
    command = ORDERS.move_to(0, 1.0, 0.0)
    said = [
        executor.execute(command, SE2(1.0 - distance_m, 0.0, 0.0), STOP, tick / 20)
        for tick, distance_m in enumerate(distances_m)
    ]
    assert said[-1].reached is reached
    assert not any(execution.reached for execution in said[:-1])
    assert (said[-1].twist == STOP) is reached


def test_a_final_heading_is_taken_after_arrival(executor: Executor) -> None:
    plant = Plant(SE2.identity())
    assert run(plant, executor, ORDERS.move_to(0, 1.5, 0.0, yaw=-2.0), 40.0) is not None
    assert abs(angle_difference(plant.pose.yaw, -2.0)) < math.radians(2.0)
    assert distance(plant.pose, 1.5, 0.0) <= 0.15


def test_a_carrot_is_never_reached(executor: Executor) -> None:
    plant = Plant(SE2.identity())
    assert run(plant, executor, ORDERS.move_to(0, 1.0, 0.0, yaw=1.0, final=False), 20.0) is None
    assert plant.twist == STOP
    assert abs(plant.pose.yaw) < 0.05, "a carrot's yaw is no heading to end with"


def test_a_moving_carrot_is_followed_at_the_commanded_speed(executor: Executor) -> None:
    plant = Plant(SE2.identity())
    for tenth in range(100):
        run(plant, executor, ORDERS.move_to(0, plant.pose.x + 0.6, 0.0, final=False), 0.1, tenth / 10)
    assert plant.twist.linear_mps == pytest.approx(0.3)
    assert abs(plant.pose.y) < 0.02


def test_pushed_away_it_comes_back(executor: Executor) -> None:
    plant = Plant(SE2.identity())
    command = ORDERS.move_to(0, 1.0, 0.0)
    assert run(plant, executor, command, 20.0) is not None
    plant.pose = SE2(1.0, 0.6, 0.0)
    assert run(plant, executor, command, 30.0, 20.0) is not None
    assert distance(plant.pose, 1.0, 0.0) <= 0.15


@settings(max_examples=50, deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_rotate_turns_the_shorter_way_on_the_spot(start: float, end: float) -> None:
    plant, executor = Plant(SE2(1.0, 2.0, start)), Executor(GpssController(LIMITS), LIMITS)
    way = angle_difference(end, start)
    reached_s = run(plant, executor, ORDERS.rotate(0, end), 10.0)
    assert reached_s is not None
    assert reached_s < 2.0 + 1.5 * abs(way)
    assert abs(angle_difference(plant.pose.yaw, end)) <= math.radians(1.6)
    assert distance(plant.pose, 1.0, 2.0) < 1e-9
    assert plant.twist == STOP


@settings(deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_turning_goes_towards_the_heading(yaw: float, target: float) -> None:
    twist, reached = turn_to(yaw, target, LIMITS)
    assert twist.linear_mps == 0.0
    assert reached == (twist == STOP)
    if not reached:
        assert twist.angular_radps * angle_difference(target, yaw) > 0.0
        assert 0.05 <= abs(twist.angular_radps) <= LIMITS.yaw_rate_radps


def test_drive_holds_the_twist_within_the_limits(executor: Executor) -> None:
    pose = SE2.identity()
    assert executor.execute(ORDERS.drive(0, -0.2, 0.4), pose, STOP, 0.0).twist == Twist(-0.2, 0.4)
    assert executor.execute(ORDERS.drive(0, 5.0, -9.0), pose, STOP, 0.0).twist == Twist(0.8, -1.0)


def test_waiting_holds_zero(executor: Executor) -> None:
    assert executor.execute(ORDERS.waiting(0), SE2.identity(), Twist(0.5, 0.0), 0.0).twist == STOP


def test_a_twist_is_a_number() -> None:
    with pytest.raises(ValueError, match="finite"):
        Twist(math.nan, 0.0)
