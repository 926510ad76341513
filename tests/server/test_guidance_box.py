"""The obstacle box: where it lies, how far it reaches, and what counts as being in it."""

import math

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Point, Polygon

from geometry import SE2
from mapping.grid import FloorGrid
from protocol.lab import ObstacleBox
from protocol.messages import Blockage, RobotSettings
from server.effective_box import effective_box
from server.guidance.blockage import RobotShapes, nearest_blockage, observed_share, robot_shapes
from server.guidance.box import Body, Box, BoxRequest, PlannedPath, footprint_at, obstacle_box, outline, reach_m
from server.guidance.floor_sums import FloorSums
from server.guidance.parameters import GuidanceParameters
from server.guidance.snapshot import Snapshot
from tests.server.guidance_scenario import LAB, OTHER, ROBOT, START_NS, raster, square, tracked

PARAMETERS = GuidanceParameters()
SPEC = LAB.vehicle(ROBOT)
SIZE = ObstacleBox(start_m=0.2, length_m=0.6, width_m=0.45, stop_at_waypoint=False)


def box_of(*points: tuple[float, float], yaw: float = 0.0, size: ObstacleBox = SIZE, speed: float = 0.1) -> Box:
    way = math.dist(points[0], points[1])
    return obstacle_box(SE2(*points[0], yaw), PlannedPath(points, way), size, SPEC, speed, 0.0, PARAMETERS)


def test_a_straight_box_starts_where_it_should_and_has_the_width_and_length_that_were_set() -> None:
    area = box_of(
        (1.0, 1.0), (5.0, 1.0), size=ObstacleBox(start_m=1.0, length_m=0.8, width_m=0.6, stop_at_waypoint=False)
    ).area
    assert area.bounds == pytest.approx((1.0, 0.7, 2.8, 1.3))
    assert area.covers(Point(2.05, 1.29))
    assert not area.covers(Point(1.9, 1.29))  # before its start it is as wide as the robot
    assert area.covers(Point(1.9, 1.15))


def test_the_box_follows_a_bend_of_the_path() -> None:
    area = box_of(
        (1.0, 1.0),
        (1.4, 1.0),
        (1.4, 3.0),
        size=ObstacleBox(start_m=0.2, length_m=1.0, width_m=0.4, stop_at_waypoint=False),
    ).area
    assert area.covers(Point(1.4, 1.75))
    assert area.covers(Point(1.25, 1.7))
    assert not area.covers(Point(1.9, 1.0))
    assert not area.covers(Point(1.4, 1.9))


def test_it_ends_at_the_waypoint_or_runs_past_it_as_set() -> None:
    stopping = ObstacleBox(start_m=0.2, length_m=2.0, width_m=0.4, stop_at_waypoint=True)
    assert box_of((1.0, 1.0), (1.5, 1.0), size=stopping).area.bounds[2] == pytest.approx(1.5)
    past = ObstacleBox(start_m=0.2, length_m=2.0, width_m=0.4, stop_at_waypoint=False)
    assert box_of((1.0, 1.0), (1.5, 1.0), size=past).area.bounds[2] == pytest.approx(3.2)


@given(speed=st.floats(0.05, 0.8), front=st.floats(0.1, 0.5), length=st.floats(0.05, 3.0))
def test_its_reach_leaves_the_clearance_after_reaction_and_braking(speed: float, front: float, length: float) -> None:
    size = ObstacleBox(start_m=0.2, length_m=length, width_m=0.45, stop_at_waypoint=False)
    spec = SPEC.model_copy(update={"footprint": ((-0.1, -0.1), (front, -0.1), (front, 0.1), (-0.1, 0.1))})
    reach = reach_m(size, spec, speed, PARAMETERS)
    stopping = speed * PARAMETERS.reaction_s + speed**2 / (2 * spec.limits.braking_mps2)
    assert reach >= 0.2 + length
    assert reach - front - stopping >= PARAMETERS.clearance_m - 1e-9


def test_a_moving_robot_also_watches_the_floor_straight_ahead_that_it_cannot_help_covering() -> None:
    path = PlannedPath([(1.0, 1.0), (1.0, 4.0)], 3.0)
    moving = obstacle_box(SE2(1.0, 1.0, 0.0), path, SIZE, SPEC, 0.6, 0.6, PARAMETERS).area
    standing = obstacle_box(SE2(1.0, 1.0, 0.0), path, SIZE, SPEC, 0.6, 0.0, PARAMETERS).area
    ahead = Point(1.0 + Body.of(SPEC).front_m + 0.6 * PARAMETERS.reaction_s, 1.0)
    assert moving.covers(ahead)
    assert not standing.covers(ahead)


def test_operators_settings_go_over_the_lab_description() -> None:
    size = effective_box(SPEC.obstacle_box, RobotSettings(box_length_m=2.0, stop_at_waypoint=True))
    assert size == ObstacleBox(
        start_m=SPEC.obstacle_box.start_m, length_m=2.0, width_m=SPEC.obstacle_box.width_m, stop_at_waypoint=True
    )
    assert effective_box(SPEC.obstacle_box, None).length_m == SPEC.obstacle_box.length_m


def test_the_box_is_never_narrower_than_the_robot() -> None:
    thin = ObstacleBox(start_m=0.2, length_m=0.6, width_m=0.02, stop_at_waypoint=False)
    box = box_of((1.0, 1.0), (5.0, 1.0), size=thin, speed=0.3)
    assert box.area.bounds[1::2] == pytest.approx((0.84, 1.16))
    assert blockage_of(box, [square(1.6, 1.25, side=0.3)]) is not None


coordinate = st.floats(-5, 5).map(lambda value: round(value, 3))
way = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=6)


@given(
    points=way, yaw=st.floats(-3.1, 3.1), present=st.floats(-0.8, 0.8), speed=st.floats(0.0, 0.8), stop=st.booleans()
)
def test_any_path_gives_a_box_within_reach_that_can_be_drawn(
    points: list[tuple[float, float]], yaw: float, present: float, speed: float, stop: bool
) -> None:
    size = ObstacleBox(start_m=0.2, length_m=0.6, width_m=0.45, stop_at_waypoint=stop)
    pose = SE2(*points[0], yaw)
    way_m = math.dist(points[0], points[1]) if len(points) > 1 else 0.0
    box = obstacle_box(pose, PlannedPath(points, way_m), size, SPEC, speed, present, PARAMETERS)
    farthest = max(reach_m(size, SPEC, speed, PARAMETERS), Body.of(SPEC).front_m + 0.8 * 0.5 + 0.16) + 0.45
    assert box.area.is_valid
    assert box.area.is_empty or Point(points[0]).buffer(farthest, quad_segs=32).covers(box.area)
    drawn = outline(box.area)
    assert box.area.is_empty or (len(drawn) >= 3 and Polygon(drawn).buffer(0).area > 0)


def blockage_of(box: Box, pallets: list[list[tuple[float, float]]]) -> Blockage | None:
    own = footprint_at(SE2(1.0, 1.0, 0.0), SPEC).buffer(PARAMETERS.own_margin_m)
    return nearest_blockage(
        ROBOT, box, own, Body.of(SPEC).front_m, FloorGrid.from_raster(raster(pallets)), RobotShapes({})
    )


def test_the_nearest_obstacle_is_named_with_its_place_and_distance_from_the_front() -> None:
    box = box_of(
        (1.0, 1.0), (5.0, 1.0), size=ObstacleBox(start_m=0.2, length_m=3.0, width_m=0.45, stop_at_waypoint=False)
    )
    found = blockage_of(box, [square(3.0, 1.0), square(2.2, 1.0)])
    assert found is not None
    assert found.robot is None
    assert found.distance_m == pytest.approx(2.0 - 1.0 - 0.15, abs=0.06)
    assert (found.x, found.y) == pytest.approx((2.0, 1.0), abs=0.06)


def test_what_lies_beside_the_box_or_is_the_robot_itself_does_not_block() -> None:
    box = box_of((1.0, 1.0), (5.0, 1.0))
    assert blockage_of(box, [square(1.5, 1.6)]) is None
    assert blockage_of(box, [square(1.0, 1.0, side=0.3)]) is None
    assert blockage_of(box, [square(1.4, 1.0)]) is not None


@given(x=st.floats(0.5, 3.5), y=st.floats(0.3, 1.7), side=st.floats(0.02, 0.5))
def test_whatever_touches_the_box_outside_of_the_robot_blocks(x: float, y: float, side: float) -> None:
    box = box_of((1.0, 1.0), (5.0, 1.0))
    own = footprint_at(SE2(1.0, 1.0, 0.0), SPEC).buffer(PARAMETERS.own_margin_m)
    pallet = Polygon(square(x, y, side))
    overlap = box.area.intersection(pallet).difference(own.buffer(0.05))
    if not overlap.is_empty and overlap.area > 0:
        assert blockage_of(box, [square(x, y, side)]) is not None
    if shapely.distance(box.area, pallet) > 0.08:
        assert blockage_of(box, [square(x, y, side)]) is None


def test_another_robot_in_the_box_is_named_and_counts_where_it_will_be() -> None:
    snapshot = Snapshot(now_ns=START_NS, now_s=0.0, poses={OTHER: tracked(OTHER, 2.0, 0.2, yaw=math.pi / 2, speed=0.8)})
    shapes = robot_shapes({OTHER: LAB.vehicle(OTHER)}, snapshot, PARAMETERS)
    box = box_of(
        (1.0, 1.0), (5.0, 1.0), size=ObstacleBox(start_m=0.2, length_m=1.0, width_m=0.45, stop_at_waypoint=False)
    )
    own = footprint_at(SE2(1.0, 1.0, 0.0), SPEC)
    grid = FloorGrid.from_raster(raster())
    found = nearest_blockage(ROBOT, box, own, 0.15, grid, shapes)
    assert found is None or found.robot == OTHER
    assert nearest_blockage(ROBOT, box, own, 0.15, grid, RobotShapes({ROBOT: shapes[OTHER].buffer(1.0)})) is None
    nearer = Snapshot(now_ns=START_NS, now_s=0.0, poses={OTHER: tracked(OTHER, 1.8, 0.4, yaw=math.pi / 2, speed=0.8)})
    found = nearest_blockage(ROBOT, box, own, 0.15, grid, robot_shapes({OTHER: SPEC}, nearer, PARAMETERS))
    assert found is not None
    assert found.robot == OTHER


def test_a_robot_long_unseen_blocks_nobody_and_one_just_lost_stands_where_it_was() -> None:
    def shapes(age_s: float) -> RobotShapes:
        pose = tracked(OTHER, 2.0, 1.0, stamp_ns=START_NS - round(age_s * 1e9), speed=0.8)
        return robot_shapes({OTHER: SPEC}, Snapshot(now_ns=START_NS, now_s=0.0, poses={OTHER: pose}), PARAMETERS)

    assert shapes(60.0) == {}
    assert shapes(3.0)[OTHER].centroid.x == pytest.approx(2.0, abs=0.02)
    assert shapes(0.2)[OTHER].centroid.x > 2.2


def test_the_share_that_cameras_see() -> None:
    grid = FloorGrid.from_raster(raster())
    assert observed_share(Polygon(square(4.0, 2.0)), grid) == pytest.approx(1.0, abs=0.02)
    assert observed_share(Polygon(square(grid.bounds[2], 2.0)), grid) == pytest.approx(0.5, abs=0.1)
    assert observed_share(Polygon(square(40.0, 2.0)), grid) == 0.0


def request(points: list[tuple[float, float]], yaw: float, present: float, speed: float, stop: bool) -> BoxRequest:
    size = ObstacleBox(start_m=0.2, length_m=0.6, width_m=0.45, stop_at_waypoint=stop)
    way_m = math.dist(points[0], points[1]) if len(points) > 1 else 0.0
    return BoxRequest(SE2(*points[0], yaw), PlannedPath(points, way_m), size, SPEC, speed, present, PARAMETERS)


@settings(max_examples=40, deadline=None)
@given(
    points=way, yaw=st.floats(-3.1, 3.1), present=st.floats(-0.8, 0.8), speed=st.floats(0.0, 0.8), stop=st.booleans()
)
def test_a_box_does_not_leave_the_rectangle_that_is_asked_first(
    points: list[tuple[float, float]], yaw: float, present: float, speed: float, stop: bool
) -> None:
    wanted = request(points, yaw, present, speed, stop)
    assert wanted.box().area.difference(shapely.box(*wanted.bounds()).buffer(1e-6)).is_empty


@pytest.mark.parametrize("stop", [False, True])
@pytest.mark.parametrize("yaw", [0.5, 0.53])
def test_a_straight_box_is_drawn_as_it_is_without_computing_it(yaw: float, stop: bool) -> None:
    end = (1.0 + 0.7 * math.cos(0.5), 1.0 + 0.7 * math.sin(0.5))
    wanted = request([(1.0, 1.0), end], yaw, 0.3, 0.3, stop)
    drawn, exact = Polygon(wanted.outline()), wanted.box().area
    assert drawn.symmetric_difference(exact).area < 0.005
    assert drawn.hausdorff_distance(exact) < 0.03


pieces = st.lists(st.tuples(st.floats(0.0, 7.5), st.floats(0.0, 3.8)), max_size=4)


@settings(max_examples=40, deadline=None)
@given(
    pallets=pieces,
    hidden=pieces,
    corner=st.tuples(st.floats(-0.5, 8.0), st.floats(-0.5, 4.3)),
    size=st.tuples(st.floats(0.05, 1.5), st.floats(0.05, 1.5)),
)
def test_what_the_sums_call_clear_is_seen_and_free(
    pallets: list[tuple[float, float]],
    hidden: list[tuple[float, float]],
    corner: tuple[float, float],
    size: tuple[float, float],
) -> None:
    occupied = FloorGrid.from_raster(raster([square(x, y, side=0.2) for x, y in pallets]))
    unseen = FloorGrid.from_raster(raster([square(x, y, side=0.2) for x, y in hidden])).occupied
    grid = occupied.with_cells(occupied.occupied, ~unseen)
    bounds = (corner[0], corner[1], corner[0] + size[0], corner[1] + size[1])
    if FloorSums(grid).all_clear(bounds):
        found = grid.look(shapely.get_coordinates(shapely.box(*bounds))[:-1])
        assert not found.blocked
        assert found.observed_share in (0.0, 1.0)  # 0: too thin for any cell's centre


def test_an_empty_floor_is_clear_but_at_its_border() -> None:
    sums = FloorSums(FloorGrid.from_raster(raster()))
    assert sums.all_clear((1.0, 1.0, 3.0, 3.0))
    assert not sums.all_clear((-1.0, 1.0, 3.0, 3.0))
    assert not sums.all_clear((7.0, 1.0, 9.0, 3.0))
