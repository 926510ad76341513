"""Turning on the spot: what a robot's corners would sweep must be clear."""

import math

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from geometry import SE2
from protocol.messages import Command, Movement, ReasonCode, TrackedPose
from server.guidance.box import footprint_at
from server.guidance.fleet import Guidance
from server.guidance.snapshot import Snapshot
from server.guidance.turning import swept_by_turning
from tests.server.guidance_scenario import (
    LAB,
    OTHER,
    ROBOT,
    START_NS,
    Course,
    assignment,
    raster,
    square,
    status,
    tracked,
)

AGV = LAB.vehicle(ROBOT).model_copy(update={"footprint": ((-0.5, -0.3), (0.5, -0.3), (0.5, 0.3), (-0.5, 0.3))})
AGVS = LAB.model_copy(update={"vehicles": (AGV, *LAB.vehicles[1:])})
TURN = Course([(2.0, 2.0)], yaws={0: math.pi / 2})
TO_THE_LEFT = Course([(2.0, 4.0)])
Pallets = list[list[tuple[float, float]]]


def command(
    course: Course, pallets: Pallets | None = None, others: dict[str, TrackedPose] | None = None, *, agv: bool = True
) -> Command:
    snapshot = Snapshot(
        now_ns=START_NS,
        now_s=0.0,
        poses={ROBOT: tracked(ROBOT, 2.0, 2.0), **(others or {})},
        statuses={ROBOT: status(ROBOT)},
        obstacles=raster(pallets or []),
        waypoints=course.waypoints(),
        routes=course.routes(),
        assignments={ROBOT: assignment()},
    )
    return Guidance(AGVS if agv else LAB).cycle(snapshot, 1).commands[ROBOT]


@pytest.mark.parametrize(("course", "movement"), [(TURN, Movement.ROTATE), (TO_THE_LEFT, Movement.MOVE_TO)])
def test_with_room_it_turns(course: Course, movement: Movement) -> None:
    assert command(course).movement is movement
    assert command(course, [square(2.9, 2.0, side=0.2)]).movement is movement


@pytest.mark.parametrize("course", [TURN, TO_THE_LEFT])
def test_a_pallet_that_a_corner_would_hit_is_waited_for(course: Course) -> None:
    said = command(course, [square(2.43, 2.43, side=0.1)])
    assert (said.movement, said.reason.code) == (Movement.WAITING, ReasonCode.OBSTACLE)
    assert "in the way of its turning" in said.reason.text


def test_another_robot_that_a_corner_would_hit_is_waited_for() -> None:
    said = command(TURN, others={OTHER: tracked(OTHER, 2.0, 2.6)})
    assert (said.movement, said.reason.code) == (Movement.WAITING, ReasonCode.ROBOT_AHEAD)
    assert OTHER in said.reason.text


def test_a_turn_on_a_floor_that_nobody_knows_is_waited_for() -> None:
    snapshot_without = Snapshot(
        now_ns=START_NS,
        now_s=0.0,
        poses={ROBOT: tracked(ROBOT, 2.0, 2.0)},
        statuses={ROBOT: status(ROBOT)},
        waypoints=TURN.waypoints(),
        routes=TURN.routes(),
        assignments={ROBOT: assignment()},
    )
    said = Guidance(AGVS).cycle(snapshot_without, 1).commands[ROBOT]
    assert (said.movement, said.reason.code) == (Movement.WAITING, ReasonCode.OBSTACLES_UNKNOWN)


def test_only_the_side_that_is_turned_through_counts_and_a_little_turn_not_at_all() -> None:
    beside = [square(2.43, 2.43, side=0.1)]
    assert command(Course([(2.0, 2.0)], yaws={0: -0.3}), beside).movement is Movement.ROTATE
    assert command(Course([(2.0, 2.0)], yaws={0: 0.08}), beside).movement is Movement.ROTATE


def test_small_robots_parked_side_by_side_still_turn() -> None:
    others = {OTHER: tracked(OTHER, 2.0, 2.6), "turtlebot-16": tracked("turtlebot-16", 1.4, 2.0)}
    assert command(TURN, others=others, agv=False).movement is Movement.ROTATE


@given(yaw=st.floats(-3.1, 3.1), turn=st.floats(-3.1, 3.1), share=st.floats(0.0, 1.0))
def test_every_heading_on_the_way_is_within_what_is_swept(yaw: float, turn: float, share: float) -> None:
    swept = swept_by_turning(SE2(2.0, 2.0, yaw), turn, AGV).area
    assert swept.buffer(1e-6).covers(footprint_at(SE2(2.0, 2.0, yaw + share * turn), AGV))
    farthest = max(math.dist((2.0, 2.0), corner) for corner in shapely.get_coordinates(swept))
    assert farthest < math.hypot(0.5, 0.3) + 0.01
