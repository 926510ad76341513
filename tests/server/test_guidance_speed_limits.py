"""Zones with a speed limit: no robot is commanded, or driven, faster inside; braking begins before."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import LineString, Point, Polygon

from protocol.messages import AssignmentState, ManualDrive, Movement, SpeedZone
from server.guidance.parameters import GuidanceParameters
from server.guidance.speed_limits import SpeedLimits
from tests.server.guidance_scenario import ROBOT, Course, Robot, Simulation

PARAMETERS = GuidanceParameters()
RADIUS = 0.22
DOORWAY = SpeedZone(id="doorway", outline=((3.0, 0.5), (4.0, 0.5), (4.0, 1.5), (3.0, 1.5)), speed_mps=0.2)
CORNER = SpeedZone(id="corner", outline=((4.5, 0.0), (6.5, 0.0), (6.5, 2.5), (4.5, 2.5)), speed_mps=0.3)


def test_a_robot_slows_down_before_the_zone_and_speeds_up_behind_it() -> None:
    simulation = Simulation(Course([(6.0, 1.0)], speed=0.8), (Robot(ROBOT, 1.0, 1.0),))
    simulation.speed_zones = {"doorway": DOORWAY}
    zone = Polygon(DOORWAY.outline).buffer(RADIUS)
    inside, outside = list[float](), list[float]()
    while simulation.assignments[ROBOT].state is AssignmentState.RUNNING and simulation.elapsed_s < 60:
        simulation.run(0.05)
        robot = simulation.robots[ROBOT]
        if zone.covers(Point(robot.pose.x, robot.pose.y)):
            inside.append(robot.twist.linear_mps)
            assert simulation.outcome is not None
            said = simulation.outcome.commands[ROBOT]
            assert said.movement is not Movement.MOVE_TO or said.speed_mps <= 0.2
        else:
            outside.append(robot.twist.linear_mps)
    assert simulation.assignments[ROBOT].state is AssignmentState.DONE
    assert len(inside) > 50
    assert max(inside) <= 0.2 + 1e-9
    assert max(outside) > 0.6


def test_the_zone_counts_where_any_part_of_the_robot_is_inside() -> None:
    limits = SpeedLimits([DOORWAY], PARAMETERS)
    for x, limited in ((2.77, False), (2.79, True), (4.21, True), (4.23, False)):
        assert (limits.at((x, 1.0), RADIUS) is not None) is limited
    beside = limits.along([(1.0, 1.73), (6.0, 1.73)], RADIUS, 0.8)
    assert beside is None
    assert limits.along([(2.0, 1.71), (6.0, 1.71)], RADIUS, 0.8) is not None


def test_of_several_zones_the_lowest_speed_counts() -> None:
    around = SpeedZone(id="around", outline=((0.0, 0.0), (8.0, 0.0), (8.0, 4.0), (0.0, 4.0)), speed_mps=0.5)
    limits = SpeedLimits([around, DOORWAY], PARAMETERS)
    assert [limits.at((x, 1.0), RADIUS) for x in (1.0, 3.5)] == [
        limits.along([(x, 1.0)], RADIUS, 0.8) for x in (1.0, 3.5)
    ]
    found = limits.at((3.5, 1.0), RADIUS)
    assert found is not None
    assert (found.zone, found.speed_mps) == ("doorway", 0.2)
    assert SpeedLimits([], PARAMETERS).along([(1.0, 1.0), (2.0, 1.0)], RADIUS, 0.8) is None


coordinate = st.floats(0.0, 8.0)
point = st.tuples(coordinate, st.floats(0.0, 4.0))


@given(path=st.lists(point, min_size=1, max_size=5), wish=st.floats(0.05, 1.5))
def test_whoever_brakes_gently_from_the_speed_allowed_here_is_slow_enough_at_every_zone(
    path: list[tuple[float, float]], wish: float
) -> None:
    zones = (DOORWAY, CORNER)
    found = SpeedLimits(zones, PARAMETERS).along(path, RADIUS, wish)
    speed = wish if found is None else found.speed_mps
    assert speed <= wish
    for zone in zones:
        area = Polygon(zone.outline).buffer(RADIUS)
        if area.covers(Point(path[0])):
            assert speed <= zone.speed_mps
            continue
        line = LineString(path) if len(path) > 1 and math.dist(path[0], path[-1]) + len(path) > 2 else None
        if line is None or line.length == 0:
            continue
        steps = [line.interpolate(s * 0.02) for s in range(int(min(line.length, 3.0) / 0.02))]
        ahead = next((index * 0.02 for index, place in enumerate(steps) if area.covers(place)), None)
        if ahead is not None:
            at_border = math.sqrt(max(0.0, speed**2 - 2 * PARAMETERS.zone_mps2 * ahead))
            assert at_border <= zone.speed_mps + 1e-6


@pytest.mark.parametrize("there", [True, False])
def test_a_hand_is_limited_too(there: bool) -> None:
    simulation = Simulation(Course([(6.0, 1.0)]), (Robot(ROBOT, 3.5 if there else 1.0, 1.0),))
    simulation.speed_zones = {"doorway": DOORWAY}
    simulation.run(0.3)
    hand = ManualDrive(
        robot=ROBOT,
        linear_mps=0.7,
        angular_radps=0.0,
        holder="a",
        by="anna",
        expires_ns=simulation.now_ns + 500_000_000,
    )
    simulation.manual = {ROBOT: hand}
    simulation.run(0.2)
    assert simulation.outcome is not None
    assert simulation.outcome.commands[ROBOT].linear_mps == pytest.approx(0.2 if there else 0.7)
