"""Robots on routes stay in the areas: a way that leaves them is refused, or waited before."""

from collections.abc import Sequence

import pytest

from protocol.lab import Area, Lab
from protocol.messages import AssignmentState, Movement, ReasonCode, Route
from server.guidance.decision import Ground
from server.guidance.fleet import Guidance
from server.guidance.snapshot import Outcome, Snapshot
from tests.server.guidance_scenario import (
    LAB,
    ROBOT,
    START_NS,
    Course,
    Robot,
    Simulation,
    assignment,
    raster,
    status,
    tracked,
)

Outline = tuple[tuple[float, float], ...]
LEFT: Outline = ((0.0, 0.0), (3.0, 0.0), (3.0, 4.0), (0.0, 4.0))
RIGHT: Outline = ((3.5, 0.0), (8.0, 0.0), (8.0, 4.0), (3.5, 4.0))
CORNER: Outline = ((0.0, 0.0), (6.0, 0.0), (6.0, 2.0), (2.0, 2.0), (2.0, 4.0), (0.0, 4.0))


def lab(*outlines: Outline) -> Lab:
    return LAB.model_copy(
        update={"areas": tuple(Area(id=f"area{i}", outline=outline) for i, outline in enumerate(outlines))}
    )


def outcome(place: Lab, at: tuple[float, float, float], course: Course, route: Route | None = None) -> Outcome:
    guidance = Guidance(place)
    snapshot = Snapshot(
        now_ns=START_NS,
        now_s=0.0,
        poses={ROBOT: tracked(ROBOT, *at)},
        statuses={ROBOT: status(ROBOT)},
        obstacles=raster(),
        waypoints=course.waypoints(),
        routes={"r": route} if route is not None else course.routes(),
        assignments={ROBOT: assignment()},
    )
    return guidance.cycle(snapshot, 1)


@pytest.mark.parametrize(
    ("outlines", "at", "to", "place"),
    [
        pytest.param((LEFT, RIGHT), (2.5, 1.0, 0.0), (5.0, 1.0), "(3.02, 1.00)", id="gap"),
        pytest.param((CORNER,), (2.3, 1.7, 2.36), (1.0, 3.0), None, id="round the corner, within"),
        pytest.param((CORNER,), (2.8, 1.7, 2.36), (1.0, 3.5), "(2.50, 2.00)", id="across the corner"),
    ],
)
def test_a_way_that_leaves_the_ground_within_the_box_is_waited_before(
    outlines: tuple[Outline, ...], at: tuple[float, float, float], to: tuple[float, float], place: str | None
) -> None:
    said = outcome(lab(*outlines), at, Course([to])).commands[ROBOT]
    if place is None:
        assert said.movement is Movement.MOVE_TO
        return
    assert (said.movement, said.reason.code) == (Movement.WAITING, ReasonCode.OUTSIDE_AREA)
    x, y = (float(value) for value in said.reason.text.split("(")[1].rstrip(")").split(","))
    wanted = [float(value) for value in place.strip("()").split(",")]
    assert (x, y) == pytest.approx(wanted, abs=0.05)


def test_a_robot_comes_to_rest_before_the_gap_between_two_areas() -> None:
    simulation = Simulation(Course([(5.0, 1.0)], speed=0.8), (Robot(ROBOT, 1.0, 1.0),), lab=lab(LEFT, RIGHT))
    simulation.run(10.0)
    assert 2.0 < simulation.robots[ROBOT].pose.x < 3.0
    assert simulation.outcome is not None
    assert simulation.outcome.commands[ROBOT].reason.code is ReasonCode.OUTSIDE_AREA


@pytest.mark.parametrize(
    ("outlines", "points", "loop"),
    [
        pytest.param((LEFT, RIGHT), [(2.0, 1.0), (5.0, 1.0)], False, id="gap"),
        pytest.param((CORNER,), [(5.0, 1.0), (1.0, 3.8)], False, id="concave"),
        pytest.param((CORNER,), [(1.0, 3.8), (1.0, 1.0), (5.0, 1.0)], True, id="back to a loop's start"),
    ],
)
def test_a_leg_that_leaves_the_ground_fails_the_route_at_its_start(
    outlines: tuple[Outline, ...], points: Sequence[tuple[float, float]], loop: bool
) -> None:
    guidance_says = outcome(lab(*outlines), (1.0, 1.0, 0.0), Course(points, loop=loop))
    assert guidance_says.commands[ROBOT].movement is Movement.NO_ACTION
    (change,) = guidance_says.changes
    assert change.after.state is AssignmentState.FAILED
    assert "of route r leaves every area at (" in change.after.reason


def test_a_route_around_the_corner_and_one_over_a_seam_are_driven() -> None:
    around = Course([(5.0, 1.0), (1.0, 1.0), (1.0, 3.5)])
    assert outcome(lab(CORNER), (1.0, 1.0, 0.0), around).commands[ROBOT].movement is Movement.MOVE_TO
    seam = lab(LEFT, ((3.01, 0.0), (8.0, 0.0), (8.0, 4.0), (3.01, 4.0)))
    said = outcome(seam, (2.8, 1.0, 0.0), Course([(2.9, 1.0), (5.0, 1.0)])).commands[ROBOT]
    assert said.movement is Movement.MOVE_TO


def test_a_path_of_one_point_leaves_nothing() -> None:
    assert Ground(lab(LEFT).areas).leaving([(1.0, 1.0), (1.0, 1.0)]) is None
    assert Ground(lab(LEFT).areas).leaving([(1.0, 1.0), (5.0, 1.0)], within_m=1.5) is None
