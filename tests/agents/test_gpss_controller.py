"""The report's controller against its table of constants (spec gpss, "The robot's side")."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.control import Goal, GpssController, gpss_law
from agents.motion import STOP, Twist
from geometry import SE2
from tests.agents.plant import LIMITS, Plant

NEAR_FLOOR = st.floats(-20.0, 20.0)
YAW = st.floats(-math.pi, math.pi)


def goal_at(distance_m: float, error_deg: float, *, speed: float = 0.5, final: bool = True) -> Goal:
    """Seen from the origin with yaw 0."""
    error = math.radians(error_deg)
    return Goal(distance_m * math.cos(error), distance_m * math.sin(error), speed, final)


@pytest.mark.parametrize("error_deg", [66.0, -66.0, 120.0, -179.0])
def test_turns_on_the_spot_at_the_greatest_rate_above_65_degrees(error_deg: float) -> None:
    steering = gpss_law(SE2.identity(), goal_at(2.0, error_deg))
    assert steering.twist == Twist(0.0, math.copysign(1.0, error_deg))


@pytest.mark.parametrize("error_deg", [10.0, -30.0, 64.9])
def test_drives_and_turns_with_the_published_gain(error_deg: float) -> None:
    steering = gpss_law(SE2.identity(), goal_at(2.0, error_deg))
    assert steering.twist.linear_mps == 0.5
    assert steering.twist.angular_radps == pytest.approx(0.0095 * error_deg)


def test_rate_has_a_floor() -> None:
    assert gpss_law(SE2.identity(), goal_at(2.0, 0.5)).twist.angular_radps == pytest.approx(0.01)
    assert gpss_law(SE2.identity(), goal_at(2.0, -0.5)).twist.angular_radps == pytest.approx(-0.01)
    assert gpss_law(SE2.identity(), goal_at(2.0, 0.0)).twist.angular_radps == 0.0


def test_speed_is_commanded_times_distance_clipped() -> None:
    assert gpss_law(SE2.identity(), goal_at(0.6, 0.0)).twist.linear_mps == pytest.approx(0.3)
    assert gpss_law(SE2.identity(), goal_at(1.0, 0.0)).twist.linear_mps == pytest.approx(0.5)
    assert gpss_law(SE2.identity(), goal_at(7.0, 0.0)).twist.linear_mps == pytest.approx(0.5)
    assert gpss_law(SE2.identity(), goal_at(0.6, 0.0, final=False)).twist.linear_mps == pytest.approx(0.5)


@pytest.mark.parametrize("error_deg", [20.0, 64.0, 90.0, -170.0])
def test_heading_error_is_locked_near_the_target(error_deg: float) -> None:
    inside = gpss_law(SE2.identity(), goal_at(0.34, error_deg))
    assert inside.twist.angular_radps == 0.0
    assert inside.twist.linear_mps > 0.0
    assert gpss_law(SE2.identity(), goal_at(0.36, error_deg)).twist.angular_radps != 0.0


def test_reached_within_15_centimetres() -> None:
    assert gpss_law(SE2.identity(), goal_at(0.149, 30.0)).reached
    assert not gpss_law(SE2.identity(), goal_at(0.151, 30.0)).reached
    assert gpss_law(SE2.identity(), goal_at(0.1, 0.0, final=False)).twist == STOP


@settings(deadline=None)
@given(NEAR_FLOOR, NEAR_FLOOR, YAW, NEAR_FLOOR, NEAR_FLOOR, st.floats(0.0, 2.0), st.booleans())
def test_never_leaves_its_limits(
    x: float, y: float, yaw: float, goal_x: float, goal_y: float, speed: float, final: bool
) -> None:
    twist = gpss_law(SE2(x, y, yaw), Goal(goal_x, goal_y, speed, final)).twist
    assert 0.0 <= twist.linear_mps <= speed
    assert twist.angular_radps == 0.0 or 0.01 <= abs(twist.angular_radps) <= 1.0
    clipped = GpssController(LIMITS).steer(SE2(x, y, yaw), STOP, Goal(goal_x, goal_y, speed, final), 0.0).twist
    assert abs(clipped.linear_mps) <= LIMITS.speed_mps


@settings(deadline=None)
@given(NEAR_FLOOR, NEAR_FLOOR, YAW, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), YAW)
def test_does_not_depend_on_where_the_map_lies(
    x: float, y: float, yaw: float, ahead: float, left: float, turn: float
) -> None:
    """The law sees the goal from the robot only; the error must be clear of the branch cut and of the steps of the law."""
    distance, error = math.hypot(ahead, left), abs(math.degrees(math.atan2(left, ahead)))
    if min(abs(distance - 0.15), abs(distance - 0.35), abs(error - 65.0)) < 0.001 or not 0.01 < error < 179.0:
        return
    robot = SE2(x, y, yaw)
    goal_pose = robot @ SE2(ahead, left, turn)
    here = gpss_law(robot, Goal(goal_pose.x, goal_pose.y, 0.4, True))
    origin = gpss_law(SE2.identity(), Goal(ahead, left, 0.4, True))
    assert here.twist.linear_mps == pytest.approx(origin.twist.linear_mps, abs=1e-9)
    assert here.twist.angular_radps == pytest.approx(origin.twist.angular_radps, abs=1e-9)


@settings(deadline=None)
@given(st.floats(0.05, 4.0), st.floats(-180.0, 180.0), st.sampled_from([0.1, 0.3, 0.8]))
def test_gets_to_every_target_around_it(distance_m: float, error_deg: float, speed: float) -> None:
    """Also to those beside it that the law alone would circle around for ever."""
    plant, controller = Plant(SE2.identity()), GpssController(LIMITS)
    goal = goal_at(distance_m, error_deg, speed=speed)
    for _ in range(20 * 120):
        steering = controller.steer(plant.pose, plant.twist, goal, 0.0)
        if steering.reached:
            break
        plant.setpoint = steering.twist
        for _ in range(5):
            plant.step(0.01)
    assert math.hypot(goal.x - plant.pose.x, goal.y - plant.pose.y) <= 0.15
