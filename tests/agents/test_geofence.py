"""The geofence: robots stay in the lab's areas by themselves, and may come back into them."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import union_all
from shapely.geometry import Point, Polygon

from agents.geofence import TOLERANCE_M, Geofence
from agents.motion import STOP, Twist
from geometry import SE2
from protocol.lab import Area, Limits
from protocol.messages import ReasonCode
from tests.agents.plant import Plant

LIMITS = Limits(speed_mps=0.8, yaw_rate_radps=1.0, acceleration_mps2=0.5, braking_mps2=2.0)
AREAS = (
    Area(id="a", outline=((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))),
    Area(id="b", outline=((4.0, 1.0), (6.0, 1.0), (6.0, 2.0), (4.0, 2.0))),
)
FENCE = Geofence(AREAS, LIMITS)


def test_inside_and_over_a_seam_everything_passes() -> None:
    for pose in (SE2(2.0, 1.5, 0.3), SE2(3.95, 1.5, 0.0)):
        assert FENCE.limit(Twist(0.5, 0.2), pose) == (Twist(0.5, 0.2), None)


def test_at_the_border_it_stops_with_a_reason_and_may_turn_around() -> None:
    pose = SE2(4.1, 0.5, 0.0)
    twist, reason = FENCE.limit(Twist(0.5, 0.0), pose)
    assert twist == STOP
    assert reason is not None and reason.code is ReasonCode.OUTSIDE_AREA and "(4.10, 0.50)" in reason.text
    assert FENCE.limit(Twist(0.0, 0.7), pose) == (Twist(0.0, 0.7), None)
    assert FENCE.limit(Twist(-0.3, 0.0), pose) == (Twist(-0.3, 0.0), None)


def test_one_that_is_outside_may_only_come_nearer() -> None:
    outside = SE2(2.0, -1.0, math.pi / 2)
    assert FENCE.limit(Twist(0.3, 0.0), outside)[1] is None
    away, reason = FENCE.limit(Twist(-0.3, 0.0), outside)
    assert away == STOP
    assert reason is not None and "in no area" in reason.text


@settings(deadline=None, max_examples=12)
@given(
    x=st.floats(0.3, 3.7),
    y=st.floats(0.3, 2.7),
    yaw=st.floats(-3.1, 3.1),
    linear=st.floats(-0.8, 0.8),
    angular=st.floats(-1.0, 1.0),
)
def test_whatever_is_commanded_it_stays_inside(x: float, y: float, yaw: float, linear: float, angular: float) -> None:
    plant, wanted = Plant(SE2(x, y, yaw), LIMITS), Twist(linear, angular)
    floor = union_all([Polygon(area.outline) for area in AREAS])
    for _ in range(150):
        plant.setpoint = FENCE.limit(wanted, plant.pose)[0]
        for _ in range(5):
            plant.step(0.01)
        assert floor.distance(Point(plant.pose.x, plant.pose.y)) < TOLERANCE_M + 0.03


def test_it_is_at_rest_where_it_was_stopped() -> None:
    plant = Plant(SE2(3.0, 0.5, 0.0), LIMITS)
    for _ in range(400):
        plant.setpoint = FENCE.limit(Twist(0.8, 0.0), plant.pose)[0]
        plant.step(0.01)
    assert plant.twist.linear_mps == pytest.approx(0.0, abs=0.05)
    assert 4.0 <= plant.pose.x <= 4.0 + TOLERANCE_M + 0.05
