"""The simulated safety scanner against a slow oracle, its faults, and the walls that it sees."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from shapely.geometry import LineString, Point, Polygon

from geometry import SE2
from lab.objects import PERSON_RADIUS_M
from lab.scanning import SimulatedScannerHead, line_segments, outline_segments
from lab.walls import Walls
from lab.world import World
from protocol.lab import ScannerSpec, SimulatedScanner
from protocol.messages import SimulatedObject
from tests.lab.rooms import PERFECT, gulliver

PRECISE = SimulatedScanner(noise_m=0.0, missed=0.0, false_echoes=0.0)
WIFIBOT = "wifibot-14"


def turn(
    spec: ScannerSpec, pose: SE2, segments: NDArray[np.float64], faults: SimulatedScanner = PRECISE, seed: int = 1
) -> NDArray[np.float64]:
    """Ranges (m) of one turn, 0 without an echo."""
    head = SimulatedScannerHead(spec, faults, np.random.default_rng(seed))
    return np.frombuffer(head.turn(pose, segments), ">u2") / 1e3


@settings(deadline=None, max_examples=50)
@given(
    x=st.floats(-1.0, 1.0),
    y=st.floats(-1.0, 1.0),
    yaw=st.floats(-3.0, 3.0),
    offset=st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-3.0, 3.0)),
    field=st.floats(0.5, 2 * math.pi),
)
def test_every_beam_ends_at_the_nearest_outline(
    x: float, y: float, yaw: float, offset: tuple[float, float, float], field: float
) -> None:
    spec = ScannerSpec(pose=offset, field_rad=field, beams=37, range_m=3.0)
    outlines = [
        [(2.0, -1.5), (2.5, -1.5), (2.5, 1.0), (2.0, 1.0)],
        [(-2.0, 0.0), (-2.5, 1.0), (-2.6, -0.7)],
        [(0.0, 2.0), (1.0, 2.2), (-0.5, 2.9)],
    ]
    pose = SE2(x, y, yaw)
    got = turn(spec, pose, np.vstack([outline_segments(np.array(outline)) for outline in outlines]))
    scanner = pose @ SE2(*offset)
    for beam, range_m in enumerate(got):
        bearing = scanner.yaw + spec.angle_min_rad + beam * spec.angle_increment_rad
        far = (scanner.x + 3.0 * math.cos(bearing), scanner.y + 3.0 * math.sin(bearing))
        ray = LineString([(scanner.x, scanner.y), far])
        hits = [
            Point(scanner.x, scanner.y).distance(ray.intersection(Polygon(o).exterior))
            for o in outlines
            if ray.intersects(Polygon(o).exterior)
        ]
        expected = min(hits, default=0.0)
        grazing = any(abs(ray.distance(Point(corner))) < 0.004 for outline in outlines for corner in outline)
        assert grazing or abs(expected - 3.0) < 0.002 or range_m == pytest.approx(expected, abs=0.0011)


def test_it_sees_people_pallets_robots_and_walls_in_its_field_only() -> None:
    scanner = ScannerSpec(field_rad=math.pi, beams=181, range_m=4.0)
    lab = gulliver(drive=PERFECT, scanner=PRECISE, walls=(((-0.5, -0.5), (8.5, -0.5)),))
    lab = lab.model_copy(update={"vehicles": tuple(v.model_copy(update={"scanner": scanner}) for v in lab.vehicles)})
    world = World(lab)
    world.place(WIFIBOT, SE2(1.0, 1.0, 0.0))
    world.place("wifibot-15", SE2(1.0, 2.5, 0.0))
    world.place("turtlebot-16", SE2(8.0, 4.0, 0.0))
    world.place("turtlebot-17", SE2(8.0, 3.0, 0.0))
    world.put(SimulatedObject(id="anna", kind="person", x=3.0, y=1.0))
    world.put(SimulatedObject(id="behind", kind="pallet", x=0.2, y=1.0))
    scan = world.scan(WIFIBOT)
    ranges = np.frombuffer(scan.ranges_mm, ">u2") / 1e3
    at = {degrees: ranges[90 + degrees] for degrees in (0, 90, -90, 45)}
    assert at[0] == pytest.approx(2.0 - PERSON_RADIUS_M, abs=0.01)
    assert at[90] == pytest.approx(1.5 - 0.16, abs=0.002), "the other robot's side"
    assert at[-90] == pytest.approx(1.5, abs=0.002), "the wall"
    assert at[45] == 0.0, "nothing there"
    assert ranges.min(where=ranges > 0, initial=9.0) > 1.0, "what is behind is not seen"
    assert (scan.vehicle, scan.stamp_ns) == (WIFIBOT, world.stamp_ns)
    assert scan.angle_min == pytest.approx(-math.pi / 2)


def test_faults_have_their_shares_and_the_same_seed_the_same_faults() -> None:
    spec = ScannerSpec(field_rad=2 * math.pi, beams=400, range_m=4.0)
    room = line_segments([[(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0), (-2.0, -2.0)]])
    faults = SimulatedScanner(noise_m=0.01, missed=0.1, false_echoes=0.05)
    exact = turn(spec, SE2.identity(), room)
    head = SimulatedScannerHead(spec, faults, np.random.default_rng(3))
    turns = np.array([np.frombuffer(head.turn(SE2.identity(), room), ">u2") / 1e3 for _ in range(50)])
    assert np.mean(turns == 0.0) == pytest.approx(0.1 * 0.95, abs=0.02)
    short = turns < exact - 0.1
    # A false echo lies anywhere within range, and hides what is behind it.
    nearer = float(np.mean((exact - 0.1) / 4.0))
    assert np.mean(short & (turns > 0.0)) == pytest.approx(0.05 * nearer, rel=0.1)
    errors = (turns - exact)[(turns > 0.0) & ~short]
    assert errors.std() == pytest.approx(0.01, abs=0.001)
    again = SimulatedScannerHead(spec, faults, np.random.default_rng(3))
    assert np.array_equal(np.frombuffer(again.turn(SE2.identity(), room), ">u2") / 1e3, turns[0])


def test_nobody_passes_a_wall_but_everybody_can_leave_it() -> None:
    world = World(gulliver(drive=PERFECT, walls=(((2.0, 0.0), (2.0, 2.0)),)))
    world.place(WIFIBOT, SE2(1.0, 1.0, 0.0))
    for _ in range(50):
        world.set_drive(WIFIBOT, 0.5, 0.0)
        world.run(0.1)
    truth = world.truth()
    assert truth.vehicles[WIFIBOT].x == pytest.approx(2.0 - 0.15, abs=0.01)
    assert truth.contacts == 1
    for _ in range(10):
        world.set_drive(WIFIBOT, -0.3, 0.0)
        world.run(0.1)
    assert world.truth().vehicles[WIFIBOT].x < 1.8


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_the_distance_from_the_walls_is_that_from_the_lines(x: float, y: float) -> None:
    lines = [[(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)], [(-2.0, -1.0), (-1.0, -2.0)]]
    expected = min(Point(x, y).distance(LineString(line)) for line in lines)
    assert Walls(lines).distance_m(x, y) == pytest.approx(expected, abs=1e-9)
    assert Walls([]).distance_m(x, y) == math.inf
