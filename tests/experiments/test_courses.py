"""Courses are closed, as long as their formulas say, and followed closely by a vehicle that turns as asked."""

import math

import pytest

from geometry import SE2
from launcher.experiments.courses import Course, CourseFollower, infinity, rectangle
from protocol.messages import TruePose


def test_a_rectangle_is_as_long_as_its_sides_and_corners() -> None:
    course = rectangle(0.0, 0.0, 4.0, 2.0, 0.5)
    assert course.length_m == pytest.approx(2 * 3.0 + 2 * 1.0 + math.tau * 0.5, rel=1e-3)


@pytest.mark.parametrize("course", [infinity((4.0, 2.1), 3.0, 1.0), rectangle(0.0, 0.0, 6.0, 3.0, 0.5)])
def test_a_follower_stays_on_the_course_for_a_whole_lap(course: Course) -> None:
    follower = CourseFollower(course, 0.0, 0.5)
    pose = SE2(*course.at(0.0))
    worst, covered, step_s = 0.0, 0.0, 0.02
    for _ in range(round(course.length_m / 0.5 / step_s)):
        linear, angular = follower.twist(TruePose(pose.x, pose.y, pose.yaw, 0.5, 0.0))
        pose = pose @ SE2.exp(linear * step_s, 0.0, angular * step_s)
        covered = course.nearest(pose.x, pose.y, covered)
        x, y, _ = course.at(covered)
        worst = max(worst, math.hypot(pose.x - x, pose.y - y))
    assert worst < 0.02
    assert covered == pytest.approx(course.length_m, abs=0.1)
