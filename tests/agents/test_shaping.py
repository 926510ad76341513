"""Set-points keep the limits of acceleration and jerk, and get where they are to get."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.control import Ramp, TwistShaper
from agents.motion import STOP, Twist
from tests.agents.plant import LIMITS

TARGETS = st.lists(st.tuples(st.floats(-1.0, 1.0), st.integers(1, 40)), min_size=1, max_size=8)
STEPS = st.sampled_from([0.02, 0.05, 0.1])
ROUNDING = 1e-9


@settings(deadline=None)
@given(TARGETS, STEPS)
def test_a_ramp_keeps_its_limits_whatever_is_asked(targets: list[tuple[float, int]], step_s: float) -> None:
    ramp = Ramp(gaining=0.5, losing=2.0, jerk=4.0)
    velocity = acceleration = 0.0
    for target, count in targets:
        for _ in range(count):
            found = ramp.step(target, step_s)
            found_acceleration = (found - velocity) / step_s
            assert abs(found_acceleration) <= 2.0 + ROUNDING
            if abs(found) > abs(velocity) and found * velocity >= 0.0:
                assert abs(found_acceleration) <= 0.5 + ROUNDING
            stops = found == 0.0 and abs(velocity) < 4.0 * step_s**2 * 2.0
            assert abs(found_acceleration - acceleration) <= 4.0 * step_s + ROUNDING or stops
            velocity, acceleration = found, ramp.acceleration


@settings(deadline=None)
@given(st.floats(0.05, 1.0), STEPS)
def test_a_ramp_meets_its_target_without_overshoot(target: float, step_s: float) -> None:
    ramp = Ramp(gaining=0.5, losing=2.0, jerk=4.0)
    course = [ramp.step(target, step_s) for _ in range(round(4.0 / step_s))]
    assert max(course) <= target + 4.0 * step_s**2 / 8.0 + ROUNDING
    assert course[-1] == pytest.approx(target, rel=2e-3)
    down = [ramp.step(0.0, step_s) for _ in range(round(3.0 / step_s))]
    assert min(down) >= 0.0
    assert down[-1] == pytest.approx(0.0, abs=1e-3)
    assert all(later <= now + 1e-9 for now, later in itertools.pairwise(down[5:]))


def test_a_shaper_goes_on_from_what_the_robot_does() -> None:
    shaper = TwistShaper(LIMITS)
    first = shaper.shaped(Twist(0.5, 0.0), Twist(0.4, 0.0), 10.0)
    assert 0.4 < first.linear_mps < 0.42
    shaper.restart()
    assert shaper.shaped(Twist(0.5, 0.0), STOP, 11.0).linear_mps < 0.02


def test_a_shaper_does_not_run_away_from_a_robot_that_is_held() -> None:
    shaper = TwistShaper(LIMITS)
    found = [shaper.shaped(Twist(0.8, 0.0), STOP, tick / 20).linear_mps for tick in range(100)]
    assert max(found) <= 0.3
