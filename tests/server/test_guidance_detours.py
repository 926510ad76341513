"""Ways out in a closed loop: around pallets and parked robots, back onto the route, out of each other's way; and waiting, with a
reason, where there is none."""

import math
from collections.abc import Sequence

import pytest
from shapely.geometry import Polygon

from geometry import angle_difference
from protocol.lab import Area, Lab
from protocol.messages import AssignmentState, Leg, Movement, ReasonCode, RobotSettings, Route
from server.guidance.box import footprint_at
from tests.server.guidance_scenario import LAB, OTHER, ROBOT, Course, Robot, Simulation, square

ACROSS = Course([(6.0, 2.0)])
Pallet = list[tuple[float, float]]


def start(course: Course = ACROSS, *robots: Robot, lab: Lab = LAB) -> Simulation:
    return Simulation(course, robots or (Robot(ROBOT, 1.0, 2.0),), lab=lab)


def corridor(*outlines: tuple[float, float, float, float]) -> Lab:
    """The lab with other areas: rectangles."""
    areas = (
        Area(id=f"area{index}", outline=((x0, y0), (x1, y0), (x1, y1), (x0, y1)))
        for index, (x0, y0, x1, y1) in enumerate(outlines)
    )
    return LAB.model_copy(update={"areas": tuple(areas)})


def body(simulation: Simulation, robot: str = ROBOT) -> Polygon:
    return footprint_at(simulation.robots[robot].pose, simulation.lab.vehicle(robot))


def drive(simulation: Simulation, limit_s: float = 90.0, robots: Sequence[str] = (ROBOT,)) -> float:
    """Until the robots' routes are over; the nearest that any of them came to a pallet or to another robot."""
    nearest = math.inf
    while simulation.elapsed_s < limit_s:
        if all(simulation.assignments[robot].state is not AssignmentState.RUNNING for robot in robots):
            break
        simulation.run(0.1)
        bodies = [body(simulation, robot) for robot in simulation.robots]
        for index, one in enumerate(bodies):
            for other in [*(Polygon(pallet) for pallet in simulation.pallets), *bodies[index + 1 :]]:
                nearest = min(nearest, one.distance(other))
    return nearest


def done(simulation: Simulation, *robots: str) -> bool:
    return all(simulation.assignments[robot].state is AssignmentState.DONE for robot in robots or (ROBOT,))


def code(simulation: Simulation, robot: str = ROBOT) -> ReasonCode | None:
    return None if simulation.outcome is None else simulation.outcome.commands[robot].reason.code


def reason(simulation: Simulation, robot: str = ROBOT) -> str:
    assert simulation.outcome is not None
    return simulation.outcome.commands[robot].reason.text


def test_a_pallet_on_the_way_is_waited_for_and_then_driven_around() -> None:
    simulation = start()
    simulation.pallets = [square(3.5, 2.0, side=0.6)]
    while simulation.elapsed_s < 20.0 and code(simulation) is not ReasonCode.OBSTACLE:
        simulation.run(0.05)
    waits_s = simulation.elapsed_s
    while simulation.elapsed_s < 30.0 and simulation.movement() is Movement.WAITING:
        simulation.run(0.05)
        assert body(simulation).distance(Polygon(simulation.pallets[0])) >= 0.3
    assert simulation.elapsed_s - waits_s == pytest.approx(3.2, abs=0.3)
    assert simulation.outcome is not None
    state = simulation.outcome.states[ROBOT]
    assert state.reason.code is ReasonCode.DETOUR
    assert "around what is at (3.2" in state.reason.text
    assert state.detour[0] == pytest.approx((simulation.robots[ROBOT].pose.x, simulation.robots[ROBOT].pose.y), abs=0.1)
    assert state.detour[-1][1] == pytest.approx(2.0, abs=0.01)
    assert state.path[-1] == (6.0, 2.0)
    assert drive(simulation) >= 0.2
    assert done(simulation)
    assert max(simulation.nearest[ROBOT]) <= 0.15
    assert any(event.startswith("robot_detour: wifibot-14 makes a detour around") for event in simulation.events)
    assert simulation.outcome.states[ROBOT].detour == ()


def test_it_comes_back_onto_the_line_behind_the_pallet() -> None:
    simulation = start(Course([(7.0, 2.0)]))
    simulation.pallets = [square(3.0, 2.0, side=0.6)]
    beside: list[float] = []
    while simulation.robots[ROBOT].pose.x < 6.8 and simulation.elapsed_s < 60:
        simulation.run(0.1)
        if simulation.robots[ROBOT].pose.x > 5.0:
            beside.append(abs(simulation.robots[ROBOT].pose.y - 2.0))
    assert beside
    assert max(beside) < 0.05


def test_a_pallet_behind_a_corner_is_driven_around_through_the_waypoint() -> None:
    simulation = start(Course([(3.0, 1.0), (3.0, 3.6), (1.0, 3.6)], loop=True), Robot(ROBOT, 1.0, 1.0))
    simulation.pallets = [square(3.0, 2.3)]
    nearest = math.inf
    while simulation.elapsed_s < 60 and (simulation.assignments[ROBOT].leg, simulation.assignments[ROBOT].laps) < (
        2,
        0,
    ):
        simulation.run(0.05)
        nearest = min(nearest, body(simulation).distance(Polygon(simulation.pallets[0])))
    assert simulation.assignments[ROBOT].leg == 2
    assert max(simulation.nearest[ROBOT][:2]) <= 0.15
    assert nearest >= 0.2


@pytest.mark.parametrize(
    ("pallets", "words"),
    [
        pytest.param([[(3.0, -0.3), (3.4, -0.3), (3.4, 4.6), (3.0, 4.6)]], "no way around", id="wall"),
        pytest.param([square(6.0, 2.0)], "no way around", id="on the goal"),
        pytest.param([square(6.6, 2.0)], "no way around", id="right behind the goal"),
    ],
)
def test_without_a_way_it_waits_and_says_so(pallets: list[Pallet], words: str) -> None:
    simulation = start()
    simulation.pallets = pallets
    nearest = drive(simulation, 21.0)
    assert simulation.movement() is Movement.WAITING
    assert words in reason(simulation)
    assert "m ahead" in reason(simulation)
    assert nearest >= 0.3
    still = simulation.robots[ROBOT].pose
    simulation.run(2.0)
    assert simulation.robots[ROBOT].pose.distance_to(still) < 0.01
    simulation.pallets = []
    drive(simulation)
    assert done(simulation)


LONG = LAB.model_copy(
    update={
        "vehicles": tuple(
            vehicle.model_copy(update={"footprint": ((-0.15, -0.25), (0.65, -0.25), (0.65, 0.25), (-0.15, 0.25))})
            for vehicle in LAB.vehicles
        )
    }
)
"""Robots that reach 0.65 m ahead of their rear axle, about which they turn: 0.70 m with their corners, and 0.25 m beside it."""


NARROW_GAP_M = 2 * (0.25 + 0.3) + 0.1
"""Wide enough for the way of such a robot, but not for turning before it or in it."""


def test_a_long_robot_takes_the_way_on_which_it_has_room_to_turn() -> None:
    simulation = start(Course([(5.0, 1.0)]), Robot(ROBOT, 1.6, 1.0), lab=LONG)
    simulation.pallets = [
        [(3.0, -0.3), (3.2, -0.3), (3.2, 1.5), (3.0, 1.5)],
        [(3.0, 1.5 + NARROW_GAP_M), (3.2, 1.5 + NARROW_GAP_M), (3.2, 2.9), (3.0, 2.9)],
    ]
    farthest = 0.0
    nearest = math.inf
    while simulation.elapsed_s < 60.0 and not done(simulation):
        simulation.run(0.2)
        farthest = max(farthest, simulation.robots[ROBOT].pose.y)
        nearest = min(nearest, *(body(simulation).distance(Polygon(pallet)) for pallet in simulation.pallets))
    assert done(simulation)
    assert nearest >= 0.2
    assert farthest > 3.3, "through the wider gap, beyond the second pallet"


def test_a_long_robot_stays_where_it_could_not_turn_and_says_so() -> None:
    simulation = start(Course([(5.0, 2.0)]), Robot(ROBOT, 1.6, 2.0), lab=LONG)
    simulation.pallets = [
        [(3.0, -0.3), (3.4, -0.3), (3.4, 2.4), (3.0, 2.4)],
        [(3.0, 2.4 + NARROW_GAP_M), (3.4, 2.4 + NARROW_GAP_M), (3.4, 4.6), (3.0, 4.6)],
    ]
    assert drive(simulation, 7.0) >= 0.25
    assert simulation.movement() is Movement.WAITING
    assert "no way around with 0.30 m beside it on which it has room to turn" in reason(simulation)


def test_nobody_drives_around_who_is_not_to() -> None:
    simulation = start()
    simulation.settings = {ROBOT: RobotSettings(detours=False)}
    simulation.pallets = [square(3.5, 2.0)]
    simulation.run(10.0)
    assert simulation.movement() is Movement.WAITING
    simulation.settings = {ROBOT: RobotSettings(detour_after_s=0.5, detour_clearance_m=0.15)}
    assert drive(simulation) >= 0.1
    assert done(simulation)


def test_a_way_with_the_clearance_between_two_pallets_is_taken() -> None:
    simulation = start()
    gap = 2 * (0.16 + 0.3) + 0.06
    simulation.pallets = [
        [(3.0, -0.3), (3.4, -0.3), (3.4, 2.3), (3.0, 2.3)],
        [(3.0, 2.3 + gap), (3.4, 2.3 + gap), (3.4, 4.6), (3.0, 4.6)],
    ]
    assert drive(simulation) >= 0.2
    assert done(simulation)


def test_a_pallet_put_on_the_detour_too_is_driven_around() -> None:
    simulation = start()
    simulation.pallets = [square(3.5, 2.0, side=0.6)]
    while simulation.elapsed_s < 30.0 and code(simulation) is not ReasonCode.DETOUR:
        simulation.run(0.1)
    simulation.run(1.0)
    assert simulation.outcome is not None
    x, y = simulation.outcome.states[ROBOT].detour[len(simulation.outcome.states[ROBOT].detour) // 2]
    simulation.pallets = [*simulation.pallets, square(x + 0.3, y, side=0.5)]
    assert drive(simulation) >= 0.15
    assert done(simulation)


def test_after_turning_at_a_bend_the_line_begins_with_the_piece_that_the_robot_faces() -> None:
    simulation = start()
    simulation.pallets = [square(3.5, 2.0, side=0.6)]
    turned = 0
    before = Movement.WAITING
    while simulation.elapsed_s < 60.0 and not done(simulation):
        simulation.run(0.05)
        assert simulation.outcome is not None
        command = simulation.outcome.commands[ROBOT]
        if (before, command.movement, code(simulation)) == (Movement.ROTATE, Movement.MOVE_TO, ReasonCode.DETOUR):
            (x0, y0), (x1, y1) = command.path[:2]
            faces = angle_difference(math.atan2(y1 - y0, x1 - x0), simulation.robots[ROBOT].pose.yaw)
            assert abs(faces) < 0.2, "a controller that follows the line would turn back"
            turned += 1
        before = command.movement
    assert turned >= 2


def test_a_detour_to_a_waypoint_beside_a_pallet_does_not_end_on_its_rim() -> None:
    simulation = start(Course([(4.0, 2.0), (4.6, 3.6)]))
    simulation.pallets = [square(3.4, 1.9, side=0.5)]
    ends: list[float] = []
    while simulation.elapsed_s < 40.0 and not done(simulation):
        simulation.run(0.1)
        assert simulation.outcome is not None
        if code(simulation) is ReasonCode.DETOUR and simulation.assignments[ROBOT].leg == 0:
            path = simulation.outcome.states[ROBOT].path
            ends.append(min(math.dist(point, (4.0, 2.0)) for point in path))
    assert ends
    assert max(ends) <= 0.12, "a robot that rounds the bend at the end would miss the waypoint"
    assert done(simulation)
    assert max(simulation.nearest[ROBOT]) <= 0.2


def test_another_guidance_takes_over_in_the_middle_of_a_detour() -> None:
    simulation = start()
    simulation.pallets = [square(3.5, 2.0, side=0.6)]
    while simulation.robots[ROBOT].pose.x < 3.4 and simulation.elapsed_s < 40:
        simulation.run(0.1)
    simulation.restart_guidance()
    assert drive(simulation) >= 0.15
    assert done(simulation)


def test_a_parked_robot_is_driven_around_and_one_that_drives_is_not() -> None:
    parked = start(ACROSS, Robot(ROBOT, 1.0, 2.0), Robot(OTHER, 3.5, 2.0))
    parked.assignments[OTHER] = parked.assignments[OTHER].model_copy(update={"state": AssignmentState.DONE})
    assert drive(parked) >= 0.2
    assert done(parked)
    ahead = start(Course([(7.0, 2.0)], radius=1.0), Robot(ROBOT, 1.0, 2.0), Robot(OTHER, 2.0, 2.0))
    ahead.assignments[OTHER] = ahead.assignments[OTHER].model_copy(update={"speed_scale": 0.3})
    ahead.run(8.0)
    assert not any("robot_detour" in event for event in ahead.events)


@pytest.mark.parametrize("priorities", [(0, 0), (0, 3)])
def test_of_robots_nose_to_nose_one_yields_by_the_rule_and_both_arrive(priorities: tuple[int, int]) -> None:
    course = Course([(6.0, 2.0), (1.0, 2.0)])
    simulation = start(course, Robot(ROBOT, 2.4, 2.0), Robot(OTHER, 4.6, 2.02, math.pi))
    simulation.assignments[OTHER] = simulation.assignments[OTHER].model_copy(update={"leg": 1})
    simulation.assignments[ROBOT] = simulation.assignments[ROBOT].model_copy(update={"state": AssignmentState.RUNNING})
    simulation.settings = {
        name: RobotSettings(priority=priority) for name, priority in zip((ROBOT, OTHER), priorities, strict=True)
    }
    nearest = drive(simulation, 120.0, (OTHER,))
    told = [event for event in simulation.events if event.startswith("deadlock")]
    yielder, other = (ROBOT, OTHER) if priorities == (0, 3) else (OTHER, ROBOT)
    assert [event.split(":")[0] for event in told] == ["deadlock", "deadlock_yield"]
    assert f"{yielder} yields to {other}" in told[1]
    assert nearest >= 0.15
    assert done(simulation, OTHER)
    assert min(simulation.nearest[ROBOT]) <= 0.15


NARROW = corridor((0.0, 1.6, 8.0, 2.4), (3.0, 1.6, 4.0, 3.4))
"""A corridor for one robot with a niche."""


def test_in_a_corridor_one_makes_way_in_a_niche_and_comes_back() -> None:
    course = Course([(7.5, 2.0), (0.5, 2.0)])
    simulation = start(course, Robot(ROBOT, 3.6, 2.0), Robot(OTHER, 6.6, 2.0, math.pi), lab=NARROW)
    simulation.assignments[OTHER] = simulation.assignments[OTHER].model_copy(update={"leg": 1})
    nearest = drive(simulation, 150.0, (OTHER,))
    told = [event for event in simulation.events if event.startswith("deadlock")]
    assert "deadlock" in told[0]
    assert any("makes way at (" in event for event in told), told
    assert done(simulation, OTHER)
    while simulation.assignments[ROBOT].leg == 0 and simulation.elapsed_s < 200:
        simulation.run(0.1)
    assert simulation.assignments[ROBOT].leg == 1 or done(simulation, ROBOT)
    assert nearest >= 0.1


def test_in_a_corridor_without_room_nobody_moves_and_a_person_is_called_once() -> None:
    course = Course([(7.5, 2.0), (0.5, 2.0)])
    tube = corridor((0.0, 1.6, 8.0, 2.4))
    simulation = start(course, Robot(ROBOT, 3.0, 2.0), Robot(OTHER, 5.0, 2.0, math.pi), lab=tube)
    simulation.assignments[OTHER] = simulation.assignments[OTHER].model_copy(update={"leg": 1})
    simulation.run(18.0)
    told = [event.split(":")[0] for event in simulation.events if event.startswith("deadlock")]
    assert told == ["deadlock", "deadlock_unresolved"]
    places = [robot.pose for robot in simulation.robots.values()]
    simulation.run(2.0)
    assert all(
        robot.pose.distance_to(place) < 0.01 for robot, place in zip(simulation.robots.values(), places, strict=True)
    )


def test_a_ring_of_four_is_resolved() -> None:
    names = [vehicle.id for vehicle in LAB.vehicles]
    inner = [(3.5, 1.6), (4.4, 1.6), (4.4, 2.5), (3.5, 2.5)]
    outer = [(3.5, 0.2), (6.5, 1.6), (4.4, 4.0), (1.0, 2.5)]
    robots: list[Robot] = []
    for name, (x, y), heading in zip(names, inner, (0.0, math.pi / 2, math.pi, -math.pi / 2), strict=True):
        robots.append(Robot(name, x, y, heading))
    simulation = start(Course([*inner, *outer], radius=0.1), *robots)
    for index, name in enumerate(names):
        there = (index + 1) % 4
        legs = (Leg(waypoint=f"w{there}", speed_mps=0.3), Leg(waypoint=f"w{4 + there}", speed_mps=0.3))
        simulation.routes[name] = Route(id=name, legs=legs)
        simulation.assignments[name] = simulation.assignments[name].model_copy(update={"route": name})
    nearest = drive(simulation, 90.0, names)
    told = [event.split(":")[0] for event in simulation.events if event.startswith("deadlock")]
    assert told[:2] == ["deadlock", "deadlock_yield"]
    assert done(simulation, *names)
    assert nearest >= 0.1


def test_unknown_floor_and_robots_count_by_choice() -> None:
    simulation = start(ACROSS, Robot(ROBOT, 1.0, 2.0), Robot(OTHER, 2.2, 2.0))
    simulation.assignments[OTHER] = simulation.assignments[OTHER].model_copy(update={"state": AssignmentState.DONE})
    simulation.settings = {ROBOT: RobotSettings(detours=False)}
    simulation.run(5.0)
    assert simulation.movement() is Movement.WAITING
    simulation.settings = {ROBOT: RobotSettings(detours=False, box_robots=False)}
    simulation.run(0.5)
    assert simulation.movement() is Movement.MOVE_TO
