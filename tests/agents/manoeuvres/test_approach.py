"""Speeds before an area and behind another vehicle: never faster than what can be stopped, and no slower than need be."""

import hypothesis.strategies as st
import pytest
from hypothesis import given

from agents.manoeuvres.approach import Mobility, speed_to_be_there, speed_to_stop, stopping_m
from agents.manoeuvres.following import cruise_limit, speed_behind
from agents.manoeuvres.precedence import by_arrival, by_delay
from agents.manoeuvres.timing import travel_s
from protocol.messages.zones import AreaUse

ROBOT = Mobility(0.5, 0.5, 2.0, 0.1)
STEP_S = 0.05


@given(distance_m=st.floats(0.0, 5.0))
def test_the_speed_to_stop_stops_within_the_distance(distance_m: float) -> None:
    assert stopping_m(speed_to_stop(distance_m, ROBOT), ROBOT) <= distance_m + 1e-9


@given(distance_m=st.floats(0.2, 4.0), after_s=st.floats(0.0, 20.0), speed_mps=st.floats(0.0, 0.5))
def test_the_approach_is_never_past_the_line_before_the_area_is_free(
    distance_m: float, after_s: float, speed_mps: float
) -> None:
    """The same law every cycle, a vehicle with the limits it knows."""
    speed_mps = min(speed_mps, speed_to_stop(distance_m, ROBOT))
    left_s = after_s
    while left_s > 0:
        wanted = speed_to_be_there(distance_m, left_s, speed_mps, ROBOT)
        speed_mps += min(0.5 * STEP_S, max(-2.0 * STEP_S, wanted - speed_mps))
        distance_m -= speed_mps * STEP_S
        left_s -= STEP_S
        assert distance_m > -1e-6


@given(distance_m=st.floats(1.5, 4.0), late_s=st.floats(0.5, 4.0))
def test_the_robot_comes_to_the_area_at_full_speed_when_it_becomes_free(distance_m: float, late_s: float) -> None:
    """Where eq. 3.7 of the report would have it arrive as slowly as it approached."""
    speed_mps, left_s = 0.5, distance_m / 0.5 + late_s
    while left_s > 0:
        wanted = speed_to_be_there(distance_m, left_s, speed_mps, ROBOT)
        speed_mps += min(0.5 * STEP_S, max(-2.0 * STEP_S, wanted - speed_mps))
        distance_m -= speed_mps * STEP_S
        left_s -= STEP_S
    assert speed_mps > 0.35
    assert distance_m < stopping_m(0.5, ROBOT) + 0.12


def test_behind_a_leader_the_speed_is_that_of_a_stop_behind_its_stop() -> None:
    assert speed_behind(0.2, 0.0, 0.2, ROBOT) == 0.0
    assert speed_behind(0.3, 0.5, 0.2, ROBOT) > speed_behind(0.3, 0.0, 0.2, ROBOT)
    assert speed_behind(5.0, 0.0, 0.2, ROBOT) == 0.5


def test_the_reports_cruise_control_moves_by_a_hundredth_of_the_distance() -> None:
    assert cruise_limit(0.3, 0.7, 0.5, 0.5) == pytest.approx(0.302)
    assert cruise_limit(0.001, 0.0, 0.5, 0.5) == 0.0


@given(distance_m=st.floats(0.0, 5.0), speed_mps=st.floats(0.0, 0.5))
def test_travel_takes_no_less_than_at_full_speed_and_no_more_than_from_a_stand(
    distance_m: float, speed_mps: float
) -> None:
    assert distance_m / 0.5 - 1e-9 <= travel_s(distance_m, speed_mps, ROBOT) <= travel_s(distance_m, 0.0, ROBOT) + 1e-9


def _uses(enter_s: float, exit_s: float) -> dict[str, AreaUse]:
    return {"z/a": AreaUse("z/a", enter_s, exit_s)}


def test_arrival_within_a_second_is_decided_by_the_id() -> None:
    assert by_arrival(("r1", _uses(5.9, 9.0)), ("r2", _uses(5.0, 8.0)))
    assert not by_arrival(("r1", _uses(6.1, 9.0)), ("r2", _uses(5.0, 8.0)))


@given(mine=st.tuples(st.floats(0, 9), st.floats(0.5, 9)), other=st.tuples(st.floats(0, 9), st.floats(0.5, 9)))
def test_two_robots_agree_who_goes_first(mine: tuple[float, float], other: tuple[float, float]) -> None:
    one, two = ("r1", _uses(mine[0], sum(mine))), ("r2", _uses(other[0], sum(other)))
    assert by_delay(one, two) != by_delay(two, one)
    assert by_arrival(one, two) != by_arrival(two, one)
