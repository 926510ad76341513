"""Stops of a route and the queue behind it, in a closed loop: stays, actions, charging, turns, legs that a person skips."""

import math
from typing import Any

import pytest

from geometry import SE2
from protocol.messages import Assignment, AssignmentState, Movement, QueuedRoute, ReasonCode, StopAction
from tests.server.guidance_scenario import LAB, ROBOT, START_NS, Course, Robot, Simulation

CORNERS = [(2.0, 1.0), (2.0, 2.0), (1.0, 2.0)]


def start(legs: dict[int, dict[str, Any]] | None = None, **course: Any) -> Simulation:
    return Simulation(Course(CORNERS, legs=legs or {}, **course), (Robot(ROBOT, 1.0, 1.0),))


def now(simulation: Simulation) -> Assignment:
    return simulation.assignments[ROBOT]


def until_at_stop(simulation: Simulation) -> SE2:
    while now(simulation).at_stop_ns is None and simulation.elapsed_s < 60:
        simulation.run(0.1)
    simulation.run(0.1)
    return simulation.robots[ROBOT].pose


def code(simulation: Simulation) -> ReasonCode:
    assert simulation.outcome is not None
    return simulation.outcome.commands[ROBOT].reason.code


def queued(route: str = "r", number: int = 1) -> QueuedRoute:
    return QueuedRoute(id=f"q{number}", route=route, queued_ns=START_NS, queued_by="anna")


def test_a_robot_stays_as_long_as_it_is_told_and_drives_on() -> None:
    simulation = start({0: {"dwell_s": 4.0, "action": "pick_up"}})
    there = until_at_stop(simulation)
    began_s = simulation.elapsed_s
    assert math.dist((there.x, there.y), CORNERS[0]) <= 0.15
    assert simulation.outcome is not None
    said = simulation.outcome.commands[ROBOT]
    assert (said.movement, said.action, said.reason.code) == (
        Movement.WAITING,
        StopAction.PICK_UP,
        ReasonCode.AT_STOP,
    )
    assert said.reason.text == "picks up at w0, 4 s left"
    while now(simulation).leg == 0:
        simulation.run(0.1)
        assert simulation.robots[ROBOT].pose.distance_to(there) < 0.02
    assert simulation.elapsed_s - began_s == pytest.approx(4.0, abs=0.3)
    assert now(simulation).at_stop_ns is None
    assert simulation.run_until_over() is AssignmentState.DONE
    assert max(simulation.nearest[ROBOT]) <= 0.15
    assert "stop_reached: wifibot-14 picks up at w0, 4 s left" in simulation.events


def test_another_guidance_goes_on_with_the_stay() -> None:
    simulation = start({0: {"dwell_s": 4.0}})
    until_at_stop(simulation)
    began_s = simulation.elapsed_s
    simulation.run(2.0)
    simulation.restart_guidance()
    while now(simulation).leg == 0:
        simulation.run(0.1)
    assert simulation.elapsed_s - began_s == pytest.approx(4.0, abs=0.3)
    assert simulation.run_until_over() is AssignmentState.DONE


def test_a_stop_to_be_confirmed_lasts_until_somebody_does() -> None:
    simulation = start({1: {"action": "drop_off", "confirm": True}})
    until_at_stop(simulation)
    simulation.run(4.0)
    assert (now(simulation).leg, code(simulation)) == (1, ReasonCode.AT_STOP)
    simulation.assignments[ROBOT] = now(simulation).model_copy(update={"proceed": True})
    simulation.run(0.3)
    assert (now(simulation).leg, now(simulation).proceed) == (2, False)
    assert simulation.run_until_over() is AssignmentState.DONE


@pytest.mark.parametrize("battery", [0.3, None])
def test_charging_lasts_until_the_battery_is_charged(battery: float | None) -> None:
    simulation = start({2: {"action": "charge", "charge_to": 0.8, "dwell_s": 1.0}})
    simulation.battery = battery
    until_at_stop(simulation)
    simulation.run(2.0)
    if battery is None:  # nothing to read: the dwell time decides
        assert now(simulation).state is AssignmentState.DONE
        return
    assert code(simulation) is ReasonCode.AT_STOP
    assert simulation.outcome is not None
    assert simulation.outcome.commands[ROBOT].reason.text == "charges at w2: 30% of 80%"
    simulation.battery = 0.81
    simulation.run(0.3)
    assert now(simulation).state is AssignmentState.DONE


def test_a_leg_may_be_a_turn_towards_something() -> None:
    course = Course([(2.0, 1.0), (2.0, 3.0), (2.0, 1.0), (3.0, 1.0)], legs={1: {"movement": "Rotate"}})
    simulation = Simulation(course, (Robot(ROBOT, 1.0, 1.0),))
    while now(simulation).leg < 2 and simulation.elapsed_s < 60:
        simulation.run(0.1)
    pose = simulation.robots[ROBOT].pose
    assert math.dist((pose.x, pose.y), (2.0, 1.0)) <= 0.15
    assert pose.yaw == pytest.approx(math.pi / 2, abs=0.1)
    assert simulation.run_until_over() is AssignmentState.DONE


def test_a_legs_own_heading_goes_before_the_waypoints() -> None:
    simulation = start({2: {"yaw": -0.5}}, yaws={2: 2.0})
    assert simulation.run_until_over() is AssignmentState.DONE
    assert simulation.robots[ROBOT].pose.yaw == pytest.approx(-0.5, abs=0.06)


def test_a_robot_that_turns_about_its_rear_ends_with_its_rotation_centre_on_the_waypoint() -> None:
    rear = ((-0.1, -0.16), (0.4, -0.16), (0.4, 0.16), (-0.1, 0.16))
    vehicles = tuple(v.model_copy(update={"footprint": rear}) if v.id == ROBOT else v for v in LAB.vehicles)
    lab = LAB.model_copy(update={"vehicles": vehicles})
    simulation = Simulation(Course([(2.0, 1.0)], yaws={0: math.pi}), (Robot(ROBOT, 1.0, 1.0),), lab=lab)
    assert simulation.run_until_over() is AssignmentState.DONE
    pose = simulation.robots[ROBOT].pose
    assert math.dist((pose.x, pose.y), (2.0, 1.0)) <= 0.15
    assert abs(pose.yaw) == pytest.approx(math.pi, abs=0.06)


def test_a_skipped_leg_is_left_from_where_the_robot_is() -> None:
    simulation = start()
    simulation.run(2.0)
    at = simulation.robots[ROBOT].pose
    changed = now(simulation).model_copy(update={"leg": 2, "changed_ns": now(simulation).changed_ns + 1})
    simulation.assignments[ROBOT] = changed
    simulation.run(0.2)
    assert simulation.outcome is not None
    target = simulation.outcome.commands[ROBOT].target
    assert target is not None
    way = math.dist((at.x, at.y), CORNERS[2])
    past = math.dist((at.x, at.y), (target.x, target.y)) + math.dist((target.x, target.y), CORNERS[2])
    assert past == pytest.approx(way, abs=0.1)
    assert simulation.run_until_over() is AssignmentState.DONE
    assert simulation.nearest[ROBOT][1] > 0.5


def test_what_is_queued_follows_a_route_that_is_done() -> None:
    simulation = start()
    simulation.assignments[ROBOT] = now(simulation).model_copy(update={"queue": (queued(), queued(number=2))})
    first = now(simulation).id
    while now(simulation).id == first and simulation.elapsed_s < 60:
        simulation.run(0.1)
    begun = now(simulation)
    assert (begun.id, begun.state, begun.leg, begun.started_by) == ("q1", AssignmentState.RUNNING, 0, "anna")
    assert [entry.id for entry in begun.queue] == ["q2"]
    while now(simulation).queue and simulation.elapsed_s < 120:
        simulation.run(0.1)
    assert simulation.run_until_over() is AssignmentState.DONE
    assert (now(simulation).id, now(simulation).queue) == ("q2", ())


def test_a_loop_ends_its_lap_when_something_waits() -> None:
    simulation = start(loop=True)
    simulation.run(3.0)
    simulation.assignments[ROBOT] = now(simulation).model_copy(update={"queue": (queued(),)})
    while now(simulation).id != "q1" and simulation.elapsed_s < 60:
        simulation.run(0.1)
    assert now(simulation).state is AssignmentState.RUNNING
    assert max(simulation.nearest[ROBOT]) <= 0.15


@pytest.mark.parametrize(
    ("state", "begins"),
    [
        (AssignmentState.DONE, True),
        (AssignmentState.STOPPED, True),
        (AssignmentState.FAILED, False),
        (AssignmentState.PAUSED, False),
    ],
)
def test_after_what_the_queue_begins(state: AssignmentState, begins: bool) -> None:
    simulation = start()
    simulation.assignments[ROBOT] = now(simulation).model_copy(update={"state": state, "queue": (queued(),)})
    simulation.run(0.3)
    assert (now(simulation).id == "q1") is begins
