"""Guidance and robots with the report's controller in a closed loop: routes, corners, obstacles, robots in the way."""

import math

import pytest

from geometry import SE2
from protocol.messages import AssignmentState, EmergencyStop, Movement, ReasonCode, RobotSettings
from tests.server.guidance_scenario import OTHER, ROBOT, Course, Robot, Simulation, square

FRONT_M = 0.15


def start(course: Course, *robots: Robot) -> Simulation:
    return Simulation(course, robots or (Robot(ROBOT, 1.0, 1.0),))


@pytest.mark.parametrize("speed", [0.2, 0.5, 0.8])
@pytest.mark.parametrize(
    "points",
    [
        pytest.param([(3.0, 1.0)], id="straight"),
        pytest.param([(3.0, 1.0), (3.0, 3.0), (1.0, 3.0), (1.0, 1.0)], id="rectangle"),
        pytest.param([(3.0, 1.0), (1.2, 1.3), (3.0, 1.6)], id="hairpins"),
        pytest.param([(1.6, 1.0), (1.6, 1.4), (2.0, 1.4), (2.0, 1.0)], id="short legs"),
    ],
)
def test_every_waypoint_is_truly_reached_within_its_radius(points: list[tuple[float, float]], speed: float) -> None:
    simulation = start(Course(points, radius=0.15, speed=speed))
    assert simulation.run_until_over() is AssignmentState.DONE
    assert max(simulation.nearest[ROBOT]) <= 0.15
    pose = simulation.robots[ROBOT].pose
    simulation.run(1.0)
    assert math.dist((pose.x, pose.y), points[-1]) <= 0.15
    assert simulation.robots[ROBOT].pose.distance_to(pose) < 0.02
    assert simulation.movement() is Movement.NO_ACTION


@pytest.mark.parametrize("radius", [0.05, 0.08, 1.0])
def test_small_radii_are_met_too(radius: float) -> None:
    simulation = start(Course([(2.5, 1.0), (2.5, 2.5)], radius=radius))
    assert simulation.run_until_over() is AssignmentState.DONE
    assert max(simulation.nearest[ROBOT]) <= radius
    assert simulation.nearest[ROBOT][-1] <= 0.15


def test_a_waypoint_with_a_heading_is_left_with_that_heading() -> None:
    simulation = start(Course([(2.5, 1.0), (2.5, 2.5)], yaws={0: math.pi, 1: -0.5}))
    seen: list[float] = []
    while simulation.assignments[ROBOT].leg == 0 and simulation.elapsed_s < 60:
        simulation.run(0.1)
        seen.append(simulation.robots[ROBOT].pose.yaw)
    assert abs(abs(simulation.robots[ROBOT].pose.yaw) - math.pi) < 0.06
    assert simulation.run_until_over() is AssignmentState.DONE
    assert simulation.robots[ROBOT].pose.yaw == pytest.approx(-0.5, abs=0.06)
    assert max(simulation.nearest[ROBOT]) <= 0.15


def test_a_loop_goes_on_and_counts_its_laps() -> None:
    simulation = start(Course([(2.0, 1.0), (2.0, 2.0), (1.0, 2.0), (1.0, 1.0)], speed=0.5, loop=True))
    while simulation.assignments[ROBOT].laps < 2 and simulation.elapsed_s < 120:
        simulation.run(0.5)
    assert simulation.assignments[ROBOT].state is AssignmentState.RUNNING
    assert simulation.assignments[ROBOT].laps == 2
    assert max(simulation.nearest[ROBOT]) <= 0.15


def test_the_temporary_waypoint_moves_on_ahead_of_the_robot() -> None:
    simulation = start(Course([(5.0, 1.0)]))
    simulation.run(0.5)
    before = 0.0
    while simulation.robots[ROBOT].pose.x < 4.0:
        simulation.run(0.2)
        assert simulation.outcome is not None
        command = simulation.outcome.commands[ROBOT]
        assert command.movement is Movement.MOVE_TO
        assert command.target is not None
        assert command.target.x >= before
        assert 0.5 < command.target.x - simulation.robots[ROBOT].pose.x < 0.9
        assert not command.final
        before = command.target.x


@pytest.mark.parametrize("speed", [0.3, 0.8])
@pytest.mark.parametrize("gap", [0.75, 1.0, 2.0])
def test_a_pallet_put_in_the_way_is_kept_away_from_and_taken_away_lets_the_robot_drive_on(
    gap: float, speed: float
) -> None:
    simulation = start(Course([(6.0, 1.0)], speed=speed))
    simulation.settings[ROBOT] = RobotSettings(detours=False)
    simulation.run(3.0)
    edge = simulation.robots[ROBOT].pose.x + FRONT_M + gap
    simulation.pallets = [square(edge + 0.2, 1.0)]
    simulation.run(8.0)
    still = simulation.robots[ROBOT].pose
    assert edge - still.x - FRONT_M >= 0.3
    assert simulation.outcome is not None
    state = simulation.outcome.states[ROBOT]
    assert (simulation.movement(), state.reason.code) == (Movement.WAITING, ReasonCode.OBSTACLE)
    assert state.blocked
    assert state.blockage is not None
    assert f"{state.blockage.distance_m:.2f} m ahead" in state.reason.text
    simulation.run(2.0)
    assert simulation.robots[ROBOT].pose.distance_to(still) < 0.005
    assert sum("robot_waiting" in event for event in simulation.events) == 1
    simulation.pallets = []
    assert simulation.run_until_over() is AssignmentState.DONE


def test_a_pallet_behind_the_corner_is_seen_along_the_path() -> None:
    simulation = start(Course([(2.0, 1.0), (2.0, 3.0)]))
    simulation.settings[ROBOT] = RobotSettings(detours=False)
    simulation.pallets = [square(2.0, 1.8)]
    simulation.run(15.0)
    assert simulation.movement() is Movement.WAITING
    assert simulation.robots[ROBOT].pose.distance_to(SE2(2.0, 1.6, 0.0)) > 0.3 + FRONT_M


def test_a_box_that_stops_at_the_waypoint_lets_the_robot_drive_up_to_something_behind_it() -> None:
    course = Course([(3.0, 1.0)])
    blocked = start(course)
    docking = start(course)
    docking.settings[ROBOT] = RobotSettings(stop_at_waypoint=True)
    for simulation in (blocked, docking):
        simulation.pallets = [square(3.6, 1.0)]
        simulation.run_until_over(limit_s=30.0)
    assert blocked.assignments[ROBOT].state is AssignmentState.RUNNING
    assert docking.assignments[ROBOT].state is AssignmentState.DONE


def test_robots_nose_to_nose_wait_without_touching_and_the_deadlock_is_named_once() -> None:
    course = Course([(6.0, 1.0), (1.0, 1.0)])
    simulation = start(course, Robot(ROBOT, 1.0, 1.0), Robot(OTHER, 6.0, 1.03, math.pi))
    simulation.assignments[OTHER] = simulation.assignments[OTHER].model_copy(update={"leg": 1})
    simulation.settings = dict.fromkeys((ROBOT, OTHER), RobotSettings(detours=False))
    simulation.run(25.0)
    a, b = (robot.pose for robot in simulation.robots.values())
    assert a.distance_to(b) - 2 * FRONT_M >= 0.3
    assert simulation.outcome is not None
    assert {c.reason.code for n, c in simulation.outcome.commands.items() if n in (ROBOT, OTHER)} == {
        ReasonCode.ROBOT_AHEAD
    }
    blockage = simulation.outcome.states[ROBOT].blockage
    assert blockage is not None
    assert blockage.robot == OTHER
    deadlocks = [event for event in simulation.events if event.startswith("deadlock:")]
    assert len(deadlocks) == 1
    assert ROBOT in deadlocks[0]
    assert OTHER in deadlocks[0]


def test_a_robot_behind_a_slower_one_waits_for_it_and_both_arrive() -> None:
    course = Course([(6.0, 1.0)], radius=1.0, speed=0.4)
    simulation = start(course, Robot(ROBOT, 1.0, 1.0), Robot(OTHER, 2.0, 1.0))
    simulation.run_until_over(OTHER)
    closest = simulation.robots[ROBOT].pose.distance_to(simulation.robots[OTHER].pose)
    assert simulation.assignments[OTHER].state is AssignmentState.DONE
    assert closest > 2 * FRONT_M + 0.2


def test_another_guidance_takes_over_on_the_leg_that_was_being_driven() -> None:
    simulation = start(Course([(2.5, 1.0), (2.5, 2.5), (1.0, 2.5)]))
    while simulation.assignments[ROBOT].leg < 1:
        simulation.run(0.1)
    simulation.run(1.0)
    simulation.restart_guidance()
    assert simulation.run_until_over() is AssignmentState.DONE
    assert max(simulation.nearest[ROBOT]) <= 0.15


def test_the_emergency_stop_holds_the_robot_and_its_release_lets_the_route_finish() -> None:
    simulation = start(Course([(4.0, 1.0)]))
    simulation.run(3.0)
    simulation.emergency_stop = EmergencyStop(engaged=True, by="anna", reason="smoke")
    simulation.run(1.0)
    still = simulation.robots[ROBOT].pose
    simulation.run(3.0)
    assert simulation.robots[ROBOT].pose.distance_to(still) < 0.001
    simulation.emergency_stop = EmergencyStop(engaged=False)
    assert simulation.run_until_over() is AssignmentState.DONE
