"""What every controller keeps, and what the path-following one does better: it stays on the line and stands on the spot."""

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.control import (
    CONTROLLERS,
    Executor,
    FrenetController,
    Goal,
    GoToGoalController,
    controller_name,
    frenet_config,
    turning_constants,
)
from agents.motion import STOP, Twist
from geometry import SE2, angle_difference
from protocol.lab import ControlSpec, FrenetControl, Limits, load_lab
from protocol.messages import Command
from tests.agents.orders import Orders
from tests.agents.plant import Plant, distance

LAB = load_lab("labs/kinds.yaml")
VEHICLE = LAB.vehicle("wifibot")
ORDERS = Orders(VEHICLE.id)
ORIGIN = SE2.identity()
Points = tuple[tuple[float, float], ...]


class Ride:
    """A controller in the executor on a small vehicle; keeps what was told and where the vehicle was, twenty times a second."""

    def __init__(self, name: str, start: SE2 = ORIGIN) -> None:
        self.plant = Plant(start, VEHICLE.limits)
        self.executor = Executor(CONTROLLERS[name](VEHICLE), VEHICLE.limits, turning_constants(VEHICLE))
        self.told: list[Twist] = [STOP]
        self.places: list[SE2] = []
        self.reached_s: float | None = None
        self._tick = 0

    def run(self, command: Command, seconds: float) -> None:
        for _ in range(round(seconds * 20)):
            now_s = self._tick / 20
            self._tick += 1
            execution = self.executor.execute(command, self.plant.pose, self.plant.twist, now_s)
            if execution.reached and self.reached_s is None:
                self.reached_s = now_s
            self.told.append(execution.twist)
            self.plant.setpoint = execution.twist
            for _ in range(5):
                self.plant.step(0.01)
            self.places.append(self.plant.pose)


def to(x: float, y: float, *, path: Points = (), speed: float = 0.4, yaw: float | None = None) -> Command:
    return ORDERS.move_to(0, x, y, speed=speed, yaw=yaw).model_copy(update={"path": path})


@pytest.mark.parametrize("name", CONTROLLERS)
@settings(deadline=None, max_examples=15)
@given(x=st.floats(-2.0, 2.0), y=st.floats(-2.0, 2.0), yaw=st.floats(-3.1, 3.1), speed=st.floats(0.05, 1.5))
def test_movements_keep_the_limits_of_speed_acceleration_and_jerk(
    name: str, x: float, y: float, yaw: float, speed: float
) -> None:
    ride, limits = Ride(name, SE2(0.0, 0.0, yaw)), VEHICLE.limits
    ride.run(to(x, y, speed=speed), 12.0)
    moving = ride.told if ride.reached_s is None else ride.told[: round(ride.reached_s * 20) + 1]
    before_linear = before_angular = 0.0
    for a, b in itertools.pairwise(moving):
        linear, angular = (b.linear_mps - a.linear_mps) * 20, (b.angular_radps - a.angular_radps) * 20
        assert abs(b.linear_mps) <= min(speed, limits.speed_mps) + 0.05
        assert abs(b.angular_radps) <= limits.yaw_rate_radps
        assert -limits.braking_mps2 - 1e-6 <= linear <= limits.braking_mps2 + 1e-6
        assert abs(angular) <= limits.yaw_acceleration_radps2 + 1e-6
        if b != STOP:
            assert abs(linear - before_linear) <= limits.jerk_mps3 / 20 * 1.13
            assert abs(angular - before_angular) <= limits.yaw_jerk_radps3 / 20 * 1.13
        before_linear, before_angular = linear, angular


@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize(("x", "y", "yaw"), [(3.0, 0.0, 0.0), (2.0, 1.0, 3.0), (-1.0, 0.5, 0.3)])
def test_gets_to_its_target_and_stays(name: str, x: float, y: float, yaw: float) -> None:
    ride = Ride(name, SE2(0.0, 0.0, yaw))
    ride.run(to(x, y), 30.0)
    assert ride.reached_s is not None
    assert ride.plant.twist == STOP
    assert distance(ride.plant.pose, x, y) <= {"gpss": 0.15, "go_to_goal": 0.2, "frenet": 0.01}[name]
    stands = ride.plant.pose
    ride.run(to(x, y), 3.0)
    assert ride.plant.pose == stands


@settings(deadline=None, max_examples=20)
@given(st.floats(0.02, 3.0), st.floats(-math.pi, math.pi), st.sampled_from([0.1, 0.3, 0.8]))
def test_stands_within_a_centimetre_of_any_place_around_it(distance_m: float, bearing: float, speed: float) -> None:
    x, y = distance_m * math.cos(bearing), distance_m * math.sin(bearing)
    ride = Ride("frenet")
    ride.run(to(x, y, speed=speed), 12.0 + distance_m / speed)
    assert ride.reached_s is not None
    assert distance(ride.plant.pose, x, y) <= 0.0105


@pytest.mark.parametrize("speed", [0.2, 0.5, 0.8])
def test_does_not_hunt_at_the_end(speed: float) -> None:
    ride = Ride("frenet")
    ride.run(to(2.5, 0.0, path=((0.0, 0.0), (2.5, 0.0)), speed=speed), 20.0)
    assert distance(ride.plant.pose, 2.5, 0.0) <= 0.006
    told = [twist.linear_mps for twist in ride.told]
    top = told.index(max(told))
    assert min(told) >= 0.0, "never backwards"
    assert all(later <= now + 1e-9 for now, later in itertools.pairwise(told[top:])), "brakes once"


CORNERS: Points = ((0.0, 0.0), (1.5, 0.0), (1.5, 1.5), (3.0, 1.5))
ZIGZAG: Points = ((0.0, 0.0), (2.0, 0.0), (1.0, 0.8), (3.0, 0.8))


@pytest.mark.parametrize(("path", "most_m"), [(CORNERS, 0.03), (ZIGZAG, 0.03)])
def test_keeps_to_the_line(path: Points, most_m: float) -> None:
    ride = Ride("frenet")
    ride.run(to(*path[-1], path=path), 40.0)
    assert distance(ride.plant.pose, *path[-1]) <= 0.01
    assert max(_off(path, place) for place in ride.places) <= most_m
    for corner in path:
        assert min(distance(place, *corner) for place in ride.places) <= most_m, "no corner is left out"


def test_a_line_that_comes_anew_with_each_command_is_the_same_line() -> None:
    """Guidance tells it from a little behind the robot to some metres ahead; the target runs ahead until the end is near."""
    ride = Ride("frenet")
    leg = 0
    for _ in range(300):
        here = ride.plant.pose
        if leg + 2 < len(CORNERS) and distance(here, *CORNERS[leg + 1]) < 0.12:
            leg += 1
        path = _told(leg, here)
        final = leg + 2 == len(CORNERS) and distance(here, *CORNERS[-1]) < 0.8
        target = CORNERS[-1] if final else path[-1]
        ride.run(to(*target, path=path).model_copy(update={"final": final}), 0.1)
    assert distance(ride.plant.pose, *CORNERS[-1]) <= 0.01
    assert max(_off(CORNERS, place) for place in ride.places) <= 0.03


def test_from_beside_the_line_it_comes_back_without_swinging() -> None:
    ride = Ride("frenet", SE2(0.0, 0.25, 0.0))
    ride.run(to(4.0, 0.0, path=((-0.3, 0.0), (4.0, 0.0))), 20.0)
    assert min(place.y for place in ride.places) > -0.015
    assert max(abs(place.y) for place in ride.places if place.x > 1.8) < 0.01


def test_a_final_heading_is_taken_where_it_stands() -> None:
    ride = Ride("frenet")
    ride.run(to(1.5, 0.0, yaw=-2.0), 20.0)
    assert ride.reached_s is not None
    assert abs(angle_difference(ride.plant.pose.yaw, -2.0)) < math.radians(2.0)
    assert distance(ride.plant.pose, 1.5, 0.0) <= 0.01


def test_a_place_where_it_stands_already_is_reached() -> None:
    ride = Ride("frenet")
    ride.run(to(0.0, 0.0, path=((0.0, 0.0),)), 2.0)
    assert ride.reached_s is not None
    assert ride.plant.pose == SE2.identity()


def test_go_to_goal_takes_the_points_one_after_the_other_at_the_set_speed() -> None:
    controller = GoToGoalController(Limits())
    path = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))
    far = controller.steer(SE2(0.5, 0.0, 0.0), STOP, Goal(1.0, 1.0, 0.3, True, path), 0.0)
    assert far.twist == Twist(0.3, 0.0)
    at_corner = controller.steer(SE2(0.85, 0.0, 0.0), STOP, Goal(1.0, 1.0, 0.3, True, path), 0.1)
    assert at_corner.twist.angular_radps > 0.5
    moved_on = controller.steer(SE2(0.9, 0.3, 1.5), STOP, Goal(1.0, 1.0, 0.3, True, path), 0.2)
    assert moved_on.twist.linear_mps == 0.3
    near = controller.steer(SE2(1.0, 0.81, 1.5), STOP, Goal(1.0, 1.0, 0.3, True, path), 0.3)
    assert near.reached and near.twist == STOP


def test_the_lab_file_chooses_the_controller_and_its_settings() -> None:
    assert controller_name(VEHICLE, "gpss") == "gpss"
    control = ControlSpec(controller="go_to_goal", frenet=FrenetControl(corner_cut_m=0.3, swivel_s=2.0))
    given = VEHICLE.model_copy(update={"control": control})
    assert controller_name(given) == "go_to_goal"
    assert controller_name(given, "gpss") == "gpss"
    assert frenet_config(given).corner_cut_m == 0.3
    assert frenet_config(given).settle_m == frenet_config(VEHICLE).settle_m
    assert turning_constants(given).swivel_s == 2.0


def test_a_steered_wheel_is_given_time_to_turn_across() -> None:
    agv = LAB.vehicle("agv")
    swivel_s = turning_constants(agv).swivel_s
    assert swivel_s > 0.5
    executor = Executor(FrenetController(agv.limits, frenet_config(agv)), agv.limits, turning_constants(agv))
    command = ORDERS.rotate(0, 1.5)
    rates = [executor.execute(command, SE2.identity(), STOP, tick / 20).twist.angular_radps for tick in range(60)]
    assert max(rates[: round(swivel_s * 20)]) <= 0.05 + 1e-9
    assert rates[-1] > 0.3


def _off(path: Points, place: SE2) -> float:
    found = math.inf
    for (ax, ay), (bx, by) in itertools.pairwise(path):
        dx, dy = bx - ax, by - ay
        share = min(1.0, max(0.0, ((place.x - ax) * dx + (place.y - ay) * dy) / (dx * dx + dy * dy)))
        found = min(found, math.hypot(place.x - ax - share * dx, place.y - ay - share * dy))
    return found


def _told(leg: int, here: SE2) -> Points:
    """The line from 0.3 m behind the robot on."""
    (ax, ay), (bx, by) = CORNERS[leg], CORNERS[leg + 1]
    length = math.hypot(bx - ax, by - ay)
    along = min(length, max(0.0, ((here.x - ax) * (bx - ax) + (here.y - ay) * (by - ay)) / length))
    if along > 0.3:
        share = (along - 0.3) / length
        return ((ax + share * (bx - ax), ay + share * (by - ay)), *CORNERS[leg + 1 :])
    if leg == 0:
        return CORNERS
    (px, py), before = CORNERS[leg - 1], math.dist(CORNERS[leg - 1], CORNERS[leg])
    share = 1.0 - 0.3 / before
    return ((px + share * (ax - px), py + share * (ay - py)), *CORNERS[leg:])
