"""The robot's own protection: what counts as a thing, which floor a robot cannot help covering, and the stop for it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from shapely.geometry import Point, Polygon

from agents.motion import STOP, Twist
from agents.protection import EchoFilter, Outline, ProtectiveGuard, RangeScan, braking_sweep, in_the_way
from geometry import SE2
from protocol.lab import Limits, ProtectiveFieldSpec, load_lab
from protocol.messages import ReasonCode
from tests.agents.plant import Plant

LAB = load_lab("labs/gulliver.yaml")
WIFIBOT = LAB.vehicle("wifibot-14")
FOOTPRINTS = {v.kind: v.footprint for v in LAB.vehicles} | {
    "agv": ((-0.3, -0.35), (1.2, -0.35), (1.2, 0.35), (-0.3, 0.35))
}
FRONT_M = 0.15
FIELD = ProtectiveFieldSpec()

twists = st.builds(Twist, st.floats(-0.8, 0.8), st.floats(-1.0, 1.0))


def scan_of(points: NDArray[np.float64] | list[tuple[float, float]], first_beam: int = 0) -> RangeScan:
    """Echoes of beams beside one another."""
    array = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    return RangeScan(0, array, np.arange(first_beam, first_beam + len(array)))


def wall(x: float, half_width: float = 0.3) -> RangeScan:
    """Straight ahead, across."""
    return scan_of([(x, y) for y in np.linspace(-half_width, half_width, 41)])


def outline_at(footprint: tuple[tuple[float, float], ...], pose: SE2) -> Polygon:
    return Polygon(pose.apply(footprint)).convex_hull  # pyright: ignore[reportReturnType]  # of a polygon


class TestField:
    @settings(deadline=None, max_examples=15)
    @given(
        twist=twists,
        kind=st.sampled_from(sorted(FOOTPRINTS)),
        seed=st.integers(0, 2**32 - 1),
        hold_s=st.floats(0.0, 0.5),
    )
    def test_a_braking_robot_keeps_its_distance_from_all_that_is_not_in_its_way(
        self, twist: Twist, kind: str, seed: int, hold_s: float
    ) -> None:
        footprint, margin_m = FOOTPRINTS[kind], 0.08
        limits = WIFIBOT.limits
        points = np.random.default_rng(seed).uniform(-1.6, 2.4, (300, 2))
        outline = Outline(footprint)
        sweep = braking_sweep(twist, limits, outline.radius_m, hold_s)
        found = {tuple(point) for point in in_the_way(points, outline, sweep, margin_m)}
        here = outline_at(footprint, SE2.identity())
        free = [Point(p) for p in points if tuple(p) not in found and here.distance(Point(p)) >= margin_m]
        plant = Plant(SE2.identity(), limits, twist=twist, setpoint=twist)
        for step in range(400):
            plant.setpoint = twist if step * 0.005 < hold_s else STOP
            plant.step(0.005)
            shape = outline_at(footprint, plant.pose).buffer(margin_m - 0.02)
            assert not any(shape.contains(point) for point in free)
            if plant.twist == STOP and step * 0.005 > hold_s:
                break

    @settings(max_examples=40)
    @given(st.floats(0.2, 0.75), st.floats(0.0, 0.3))
    def test_the_field_ahead_is_as_long_as_the_way_to_stand(self, speed: float, hold_s: float) -> None:
        outline = Outline(WIFIBOT.footprint)
        sweep = braking_sweep(Twist(speed, 0.0), WIFIBOT.limits, outline.radius_m, hold_s)
        reach = FRONT_M + speed * hold_s + speed**2 / (2 * WIFIBOT.limits.braking_mps2) + 0.08
        just_in, just_out = np.array([[reach - 0.005, 0.0]]), np.array([[reach + 0.005, 0.0]])
        assert len(in_the_way(just_in, outline, sweep, 0.08)) == 1
        assert len(in_the_way(just_out, outline, sweep, 0.08)) == 0

    def test_a_turn_on_the_spot_sweeps_its_corners_around(self) -> None:
        long_robot = ((-0.1, -0.1), (0.5, -0.1), (0.5, 0.1), (-0.1, 0.1))
        outline = Outline(long_robot)
        sweep = braking_sweep(Twist(0.0, 1.0), Limits(), outline.radius_m, 0.4)
        beside = np.array([[0.4, 0.22], [0.4, -0.22], [0.75, 0.0], [-0.2, 0.0]])
        assert in_the_way(beside, outline, sweep, 0.05).tolist() == [[0.4, 0.22]], "on the side that it turns to"
        straight = braking_sweep(Twist(0.1, 0.0), Limits(), outline.radius_m, 0.4)
        assert len(in_the_way(beside, outline, straight, 0.05)) == 0

    def test_a_robot_may_leave_what_it_stands_too_near_to(self) -> None:
        outline, near = Outline(WIFIBOT.footprint), np.array([[FRONT_M + 0.03, 0.0]])
        for twist, blocked in ((Twist(-0.3, 0.0), False), (Twist(0.3, 0.0), True)):
            sweep = braking_sweep(twist, WIFIBOT.limits, outline.radius_m, 0.15)
            assert bool(len(in_the_way(near, outline, sweep, 0.08))) is blocked

    def test_the_robot_itself_is_nothing_in_its_way(self) -> None:
        outline = Outline(WIFIBOT.footprint)
        sweep = braking_sweep(Twist(0.3, 0.5), WIFIBOT.limits, outline.radius_m, 0.15)
        assert len(in_the_way(np.array([[0.1, 0.1], [0.0, 0.0]]), outline, sweep, 0.08)) == 0

    def test_who_stands_has_no_field(self) -> None:
        outline = Outline(WIFIBOT.footprint)
        sweep = braking_sweep(STOP, WIFIBOT.limits, outline.radius_m, 1.0)
        assert len(in_the_way(np.array([[0.16, 0.0]]), outline, sweep, 0.1)) == 0


class TestEchoes:
    def test_a_single_false_echo_is_nothing_three_beside_one_another_are_something(self) -> None:
        echoes = EchoFilter(3)
        assert len(echoes.solid(scan_of([(0.3, 0.0)]))) == 0
        assert len(echoes.solid(scan_of([(1.0, 0.0), (1.0, 0.02), (1.0, 0.04)]))) == 3

    def test_a_thin_thing_is_one_when_the_next_turn_shows_it_again(self) -> None:
        echoes = EchoFilter(3)
        assert len(echoes.solid(scan_of([(0.5, 0.0)]))) == 0
        assert len(echoes.solid(scan_of([(0.48, 0.01)]))) == 1
        assert len(echoes.solid(scan_of([(0.9, 0.0)]))) == 0, "elsewhere is something else"
        assert len(echoes.solid(scan_of([]))) == 0
        assert len(echoes.solid(scan_of([(0.9, 0.0)]))) == 0, "it was gone in between"

    def test_a_missed_echo_does_not_tear_a_thing_apart(self) -> None:
        points = np.array([(0.5, 0.0), (0.5, 0.02), (0.5, 0.06), (0.5, 0.08)])
        scan = RangeScan(0, points, np.array([10, 11, 13, 14]))
        assert len(EchoFilter(3).solid(scan)) == 4
        far_apart = RangeScan(0, points, np.array([10, 11, 14, 15]))
        assert len(EchoFilter(3).solid(far_apart)) == 0

    @settings(deadline=None)
    @given(st.integers(0, 2**32 - 1))
    def test_scattered_echoes_are_nothing_unless_they_happen_side_by_side(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        beams = np.sort(rng.choice(np.arange(0, 271, 4), size=10, replace=False))
        bearings, ranges = np.radians(beams - 135.0), rng.uniform(0.3, 4.0, 10)
        points = np.column_stack((ranges * np.cos(bearings), ranges * np.sin(bearings)))
        assert len(EchoFilter(3).solid(RangeScan(0, points, beams))) == 0

    def test_ranges_become_points_in_the_robots_frame(self) -> None:
        ranges = np.array([1.0, 0.0, np.nan, np.inf, 9.0, 2.0])
        scan = RangeScan.polar(
            5,
            ranges,
            angle_min=0.0,
            angle_increment=math.pi / 10,
            range_min_m=0.1,
            range_max_m=8.0,
            T_robot_scanner=SE2(0.2, 0.1, math.pi / 2),
        )
        assert scan.beams.tolist() == [0, 5]
        assert scan.points == pytest.approx(np.array([[0.2, 1.1], [-1.8, 0.1]]))

    def test_what_is_nearer_than_the_scanner_can_measure_is_as_near_as_it_can(self) -> None:
        ranges = np.array([-np.inf, 0.04, 0.0, -0.5, -0.0, np.nan, 0.1])
        scan = RangeScan.polar(
            5,
            ranges,
            angle_min=0.0,
            angle_increment=0.1,
            range_min_m=0.1,
            range_max_m=8.0,
            T_robot_scanner=SE2.identity(),
        )
        assert scan.beams.tolist() == [0, 1, 6]
        assert np.hypot(*scan.points.T) == pytest.approx([0.1, 0.1, 0.1])


def at_the_scanner(range_m: float, range_min_m: float) -> RangeScan:
    """Five beams straight ahead of a WifiBot's scanner."""
    return RangeScan.polar(
        0,
        np.full(5, range_m),
        angle_min=-0.02,
        angle_increment=0.01,
        range_min_m=range_min_m,
        range_max_m=4.0,
        T_robot_scanner=SE2(0.1, 0.0, 0.0),
    )


class TestGuard:
    AHEAD = Twist(0.3, 0.0)
    REACH_M = FRONT_M + FIELD.margin_m + 0.3 * FIELD.reaction_s + 0.3**2 / (2 * WIFIBOT.limits.braking_mps2)

    def guard(self) -> ProtectiveGuard:
        return ProtectiveGuard(WIFIBOT)

    def test_nothing_near_lets_everything_pass(self) -> None:
        guard = self.guard()
        assert guard.limit(self.AHEAD, self.AHEAD, 0.0) == (self.AHEAD, None)
        guard.scan(wall(3.0), self.AHEAD, 0.0)
        assert guard.limit(self.AHEAD, self.AHEAD, 0.01) == (self.AHEAD, None)

    def test_a_thing_in_the_protective_field_stops_at_once_and_until_it_was_clear_for_a_while(self) -> None:
        guard = self.guard()
        guard.limit(self.AHEAD, self.AHEAD, 0.0)
        assert guard.scan(wall(self.REACH_M - 0.02), self.AHEAD, 0.01), "with the scan, not with the next round"
        twist, reason = guard.limit(self.AHEAD, self.AHEAD, 0.02)
        assert twist == STOP
        assert reason is not None and reason.code is ReasonCode.PROTECTIVE_FIELD and "0.2" in reason.text
        guard.scan(wall(3.0), STOP, 0.5)
        assert guard.limit(self.AHEAD, STOP, 0.9)[0] == STOP, "not clear for long enough"
        assert guard.limit(self.AHEAD, STOP, 1.1) == (self.AHEAD, None)

    @pytest.mark.parametrize("range_m", [-math.inf, 0.06])
    def test_who_steps_right_up_to_the_scanner_stays_in_the_field(self, range_m: float) -> None:
        guard = self.guard()
        guard.scan(at_the_scanner(0.12, 0.1), STOP, 0.0)
        assert guard.limit(self.AHEAD, STOP, 0.0)[0] == STOP
        for step in range(1, 60):
            guard.scan(at_the_scanner(range_m, 0.1), STOP, step * 0.05)
            assert guard.limit(self.AHEAD, STOP, step * 0.05)[0] == STOP

    def test_what_is_that_near_inside_the_outline_is_the_robot_itself(self) -> None:
        guard = self.guard()
        guard.scan(at_the_scanner(-math.inf, 0.02), STOP, 0.0)
        assert guard.limit(self.AHEAD, STOP, 0.0) == (self.AHEAD, None)

    def test_scans_that_wait_for_the_control_loop_make_the_field_longer(self) -> None:
        """A ROS 2 base's do, for up to 50 ms."""
        between = wall(self.REACH_M + 0.3 * 0.05 / 2)
        for driver, stops in (("sim", False), ("ros2", True)):
            guard = ProtectiveGuard(WIFIBOT.model_copy(update={"driver": driver}))
            guard.limit(self.AHEAD, self.AHEAD, 0.0)
            assert guard.scan(between, self.AHEAD, 0.01) is stops

    def test_a_range_that_trembles_around_the_border_is_no_permission(self) -> None:
        guard = self.guard()
        guard.limit(self.AHEAD, self.AHEAD, 0.0)
        guard.scan(wall(self.REACH_M - 0.01), self.AHEAD, 0.0)
        for step in range(1, 200):
            guard.scan(wall(self.REACH_M + (0.01 if step % 2 else 0.03)), STOP, step * 0.03)
            assert guard.limit(self.AHEAD, STOP, step * 0.03)[0] == STOP

    def test_a_thing_in_the_warning_field_slows_it_down_on_the_same_curve(self) -> None:
        guard = self.guard()
        curve = Twist(0.3, 0.2)
        guard.scan(wall(self.REACH_M + 0.15), curve, 0.0)
        twist, reason = guard.limit(curve, curve, 0.01)
        assert reason is None
        assert twist.angular_radps / twist.linear_mps == pytest.approx(0.2 / 0.3)
        radius_m = math.hypot(0.15, 0.16)
        assert math.hypot(twist.linear_mps, twist.angular_radps * radius_m) == pytest.approx(FIELD.slow_mps)

    def test_a_false_echo_neither_slows_nor_stops(self) -> None:
        guard = self.guard()
        guard.limit(self.AHEAD, self.AHEAD, 0.0)
        assert not guard.scan(scan_of([(0.2, 0.0)]), self.AHEAD, 0.01)
        assert guard.limit(self.AHEAD, self.AHEAD, 0.02) == (self.AHEAD, None)

    def test_a_robot_that_was_stopped_may_back_away(self) -> None:
        guard = self.guard()
        guard.limit(self.AHEAD, self.AHEAD, 0.0)
        guard.scan(wall(self.REACH_M - 0.05), self.AHEAD, 0.0)
        back = Twist(-0.2, 0.0)
        assert guard.limit(back, STOP, 0.5)[0] == STOP
        assert guard.limit(back, STOP, FIELD.clear_s + 0.1) == (back, None)

    @settings(deadline=None, max_examples=12)
    @given(
        speed=st.floats(0.05, 0.8),
        turn=st.floats(-1.0, 1.0),
        bearing=st.floats(-math.pi, math.pi),
        away_m=st.floats(0.6, 1.5),
        phase=st.floats(0.0, 1.0),
    )
    def test_whatever_is_commanded_it_touches_nothing_that_its_scanner_sees(
        self, speed: float, turn: float, bearing: float, away_m: float, phase: float
    ) -> None:
        """Scans all around at 20 Hz, control at 20 Hz, set-points 30 ms late."""
        centre = (away_m * math.cos(bearing), away_m * math.sin(bearing))
        border = np.array(
            [(centre[0] + 0.1 * math.cos(a), centre[1] + 0.1 * math.sin(a)) for a in np.linspace(0, 6.28, 60)]
        )
        thing = Polygon(border)
        guard, wanted = self.guard(), Twist(speed, turn)
        plant = Plant(SE2.identity(), WIFIBOT.limits)
        pending: list[tuple[float, Twist]] = []
        for step in range(300):
            now_s = step * 0.01
            if (step + round(phase * 5)) % 5 == 0 and guard.scan(
                scan_of(plant.pose.inverse().apply(border)), plant.twist, now_s
            ):
                pending.append((now_s + 0.03, STOP))
            if step % 5 == 0:
                pending.append((now_s + 0.03, guard.limit(wanted, plant.twist, now_s)[0]))
            while pending and pending[0][0] <= now_s:
                plant.setpoint = pending.pop(0)[1]
            plant.step(0.01)
            if step % 5 == 0:
                assert outline_at(WIFIBOT.footprint, plant.pose).distance(thing) > 0.01
