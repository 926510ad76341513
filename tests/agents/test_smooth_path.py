"""Drawn lines with their corners rounded."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from agents.control.smooth_path import SmoothPath, sections
from agents.control.speed_profile import SpeedProfile, braking_speed, curve_caps

POINTS = st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=2, max_size=10)


def distance_from(line: list[tuple[float, float]], place: NDArray[np.float64]) -> float:
    found = math.inf
    for start, end in itertools.pairwise(line):
        a, step = np.array(start), np.subtract(end, start)
        share = min(1.0, max(0.0, float((place - a) @ step) / max(1e-12, float(step @ step))))
        found = min(found, float(np.hypot(*(place - a - share * step))))
    return found


@settings(deadline=None, max_examples=30)
@given(POINTS, st.floats(0.005, 0.1))
def test_a_line_leaves_its_corners_by_no_more_than_it_may(points: list[tuple[float, float]], cut_m: float) -> None:
    if len({(round(x, 2), round(y, 2)) for x, y in points}) < 2:
        return
    for part in sections(points, 2.5):
        path = SmoothPath.through(part, cut_m)
        assert max(distance_from(part, place) for place in path.points) <= cut_m + 1e-6
        assert tuple(path.points[0]) == pytest.approx(part[0])
        assert tuple(path.points[-1]) == pytest.approx(part[-1])
        assert np.all(np.diff(path.ways) > 0.0)


def test_heading_and_curvature_belong_together() -> None:
    path = SmoothPath.through([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], 0.05)
    ways = np.linspace(0.0, path.length_m, 4000)
    headings = np.array([path.at(float(way)).heading_rad for way in ways])
    assert headings[0] == 0.0 and headings[-1] == pytest.approx(math.pi / 2)
    turned = np.sum([path.at(float(way)).curvature for way in ways]) * (ways[1] - ways[0])
    assert turned == pytest.approx(math.pi / 2, abs=0.03)


def test_the_nearest_place_of_a_place_on_the_line_is_itself() -> None:
    path = SmoothPath.through([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 3.0)], 0.03)
    for way in np.linspace(0.05, path.length_m, 30):
        at = path.at(float(way))
        left = (at.x - 0.01 * math.sin(at.heading_rad), at.y + 0.01 * math.cos(at.heading_rad))
        assert path.nearest(*left, float(way) - 0.2, float(way) + 0.2) == pytest.approx(way, abs=0.01)
    assert path.nearest(*(path.points[-1] + [0.1, 0.2])) > path.length_m, "past the end"


def test_a_line_that_comes_back_to_itself_is_followed_in_its_order() -> None:
    path = SmoothPath.through([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, -1.0)], 0.02)
    assert path.nearest(1.0, 0.0, 0.5, 1.5) == pytest.approx(1.0, abs=0.01)
    assert path.nearest(1.0, 0.0, 4.5, 5.4) == pytest.approx(path.length_m - 1.0, abs=0.01)


def test_points_that_coincide_are_no_line() -> None:
    with pytest.raises(ValueError, match="two points"):
        SmoothPath.through([(1.0, 1.0), (1.0, 1.0)], 0.02)


def test_sections_end_at_corners_too_sharp_to_drive() -> None:
    points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.2)]
    assert sections(points, 3.0) == [points]
    assert sections(points, 2.0) == [points[:3], points[2:]]
    assert sections(points, 1.0) == [points[:2], points[1:3], points[2:]]


def test_speeds_leave_room_to_brake_for_what_comes() -> None:
    path = SmoothPath.through([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], 0.02)
    profile = SpeedProfile(path, curve_caps(path, 1.0, 0.3, 0.5, 0.03), 0.5)
    ways = np.linspace(0.0, path.length_m, 500)
    squared = np.array([profile.speed_mps(float(way)) for way in ways]) ** 2
    assert np.all(np.diff(squared) >= -2 * 0.5 * (ways[1] - ways[0]) - 1e-9)
    assert min(squared) < 0.06**2
    assert profile.speed_mps(0.0) > 0.6


@given(st.floats(0.0, 5.0))
def test_braking_is_never_harder_than_planned(left_m: float) -> None:
    speed, later = braking_speed(left_m, 0.5, 3.0), braking_speed(max(0.0, left_m - 1e-4), 0.5, 3.0)
    assert later <= speed
    assert (speed**2 - later**2) / 2e-4 <= 0.5 + 1e-3


def test_speeds_are_low_where_the_curvature_jumps() -> None:
    """Into a bend the yaw rate changes at once; within the bend it changes little."""
    path = SmoothPath.through([(0.0, 0.0), (1.0, 0.0), (1.6, 0.3)], 0.02)
    caps = curve_caps(path, 10.0, 0.3, 100.0, 0.03)
    curvatures = np.abs(path.curvatures)
    starts = int(np.argmax(curvatures > 0.0))
    assert caps[starts] == pytest.approx(0.3 / curvatures[starts], rel=0.05)
    assert caps[0] > 100.0
