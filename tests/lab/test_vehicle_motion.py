"""Simulated bases keep their limits, lie no more than described, and stop when nobody speaks to them."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry import SE2, angle_difference
from lab.vehicle import WATCHDOG_S
from lab.world import World
from protocol.lab import SimulatedDrive
from tests.lab.rooms import PERFECT, gulliver

WIFIBOT = "wifibot-14"


def drive_for(world: World, seconds: float, linear_mps: float, angular_radps: float) -> None:
    """Holds a twist as an agent does, with a set-point every 0.1 s."""
    for _ in range(round(seconds / 0.1)):
        world.set_drive(WIFIBOT, linear_mps, angular_radps)
        world.run(0.1)


def pose_of(world: World) -> SE2:
    truth = world.truth().vehicles[WIFIBOT]
    return SE2(truth.x, truth.y, truth.yaw)


@settings(max_examples=15)
@given(st.lists(st.tuples(st.floats(-3, 3), st.floats(-4, 4)), min_size=1, max_size=12))
def test_speeds_and_their_changes_stay_within_the_limits(twists: list[tuple[float, float]]) -> None:
    world = World(gulliver(drive=PERFECT))
    world.place(WIFIBOT, SE2(4.0, 2.0, 0.0))
    limits = world.lab.vehicle(WIFIBOT).limits
    before = world.truth().vehicles[WIFIBOT]
    for linear, angular in twists:
        world.set_drive(WIFIBOT, linear, angular)
        for _ in range(20):
            world.step()
            now = world.truth()
            if now.contacts:
                return  # a stall at a contact is sudden
            vehicle = now.vehicles[WIFIBOT]
            assert abs(vehicle.linear_mps) <= limits.speed_mps + 1e-9
            assert abs(vehicle.angular_radps) <= limits.yaw_rate_radps + 1e-9
            faster = abs(vehicle.linear_mps) > abs(before.linear_mps)
            most = limits.acceleration_mps2 if faster else limits.braking_mps2
            assert abs(vehicle.linear_mps - before.linear_mps) <= most * world.step_s + 1e-9
            assert (
                abs(vehicle.angular_radps - before.angular_radps)
                <= limits.yaw_acceleration_radps2 * world.step_s + 1e-9
            )
            before = vehicle


def test_it_reaches_the_speed_that_it_is_told() -> None:
    world = World(gulliver(drive=PERFECT))
    drive_for(world, 2.0, 0.6, 0.0)
    assert world.truth().vehicles[WIFIBOT].linear_mps == pytest.approx(0.6)
    assert pose_of(world).x == pytest.approx(1.0 + 0.6 * 2.0 - 0.6**2 / (2 * 0.5), abs=0.01)


def test_a_held_turn_is_a_circle() -> None:
    world = World(gulliver(drive=PERFECT))
    world.place(WIFIBOT, SE2(4.0, 2.0, 0.0))
    drive_for(world, 2.0, 0.3, 0.6)
    start, turn_s = pose_of(world), 2 * math.pi / 0.6
    centre = start @ SE2(0.0, 0.5, 0.0)
    for _ in range(10):
        drive_for(world, turn_s / 10, 0.3, 0.6)
        assert pose_of(world).distance_to(centre) == pytest.approx(0.5, abs=1e-4)


def test_perfect_wheels_report_the_truth() -> None:
    world = World(gulliver(drive=PERFECT))
    start = pose_of(world)
    drive_for(world, 3.0, 0.4, 0.3)
    odometry, moved = world.odometry(WIFIBOT), start.between(pose_of(world))
    assert moved.x > 0.5
    assert (odometry.x, odometry.y, odometry.yaw) == pytest.approx((moved.x, moved.y, moved.yaw), abs=1e-9)
    assert (odometry.linear_mps, odometry.angular_radps) == pytest.approx((0.4, 0.3))


def test_wheel_scales_lengthen_and_bend_the_reported_way() -> None:
    drive = SimulatedDrive(left_scale=1.03, right_scale=1.01, noise=0.0, slip=0.0, delay_s=0.0)
    world = World(gulliver(drive=drive))
    start = pose_of(world)
    drive_for(world, 5.0, 0.5, 0.0)
    odometry, moved = world.odometry(WIFIBOT), start.between(pose_of(world))
    assert odometry.x / moved.x == pytest.approx(1.02, abs=0.005)
    assert moved.yaw == pytest.approx(0.0, abs=1e-12)
    assert odometry.yaw < -0.05


@pytest.mark.parametrize("seed", range(4))
def test_odometry_errs_no_more_than_described(seed: int) -> None:
    drive = gulliver().simulation.drive
    world = World(gulliver(), seed)
    start = pose_of(world)
    drive_for(world, 6.0, 0.6, 0.0)
    reported, moved = world.odometry(WIFIBOT), start.between(pose_of(world))
    most = max(drive.left_scale, drive.right_scale) / (1.0 - drive.slip)
    way, reported_way = math.hypot(moved.x, moved.y), math.hypot(reported.x, reported.y)
    assert 0.98 * min(drive.left_scale, drive.right_scale) < reported_way / way < 1.01 * most
    assert abs(angle_difference(reported.yaw, moved.yaw)) > 1e-3, "and it does err"


def test_slipping_wheels_turn_farther_than_they_carry() -> None:
    world = World(gulliver(drive=SimulatedDrive(noise=0.0, slip=0.2, delay_s=0.0)))
    start = pose_of(world)
    drive_for(world, 4.0, 0.5, 0.0)
    carried, turned = start.distance_to(pose_of(world)), world.odometry(WIFIBOT).x
    assert 0.8 * turned < carried < 0.97 * turned


def test_motors_answer_after_their_delay() -> None:
    world = World(gulliver(drive=SimulatedDrive(noise=0.0, slip=0.0, delay_s=0.05)))
    world.set_drive(WIFIBOT, 0.5, 0.0)
    world.run(0.04)
    assert world.truth().vehicles[WIFIBOT].linear_mps == 0.0
    world.run(0.02)
    assert world.truth().vehicles[WIFIBOT].linear_mps > 0.0


def test_a_base_that_hears_nothing_stops() -> None:
    world = World(gulliver(drive=PERFECT))
    drive_for(world, 2.0, 0.5, 0.2)
    world.run(WATCHDOG_S - 0.11)  # the last set-point is 0.1 s old already
    assert world.truth().vehicles[WIFIBOT].linear_mps == pytest.approx(0.5)
    world.run(0.02 + 0.5 / world.lab.vehicle(WIFIBOT).limits.braking_mps2)
    stopped = world.truth().vehicles[WIFIBOT]
    assert (stopped.linear_mps, stopped.angular_radps) == (0.0, 0.0)
    world.run(1.0)
    assert world.truth().vehicles[WIFIBOT] == stopped


def test_the_battery_drains_faster_when_driving() -> None:
    driven, idle = World(gulliver()), World(gulliver())
    drive_for(driven, 4.0, 0.5, 0.0)
    idle.run(4.0)
    assert 0.99 < driven.odometry(WIFIBOT).battery < idle.odometry(WIFIBOT).battery < 1.0


@pytest.mark.parametrize("twist", [(math.nan, 0.0), (0.0, math.inf)])
def test_a_twist_that_is_not_finite_is_refused(twist: tuple[float, float]) -> None:
    world = World(gulliver(drive=PERFECT))
    with pytest.raises(ValueError, match="finite"):
        world.set_drive(WIFIBOT, *twist)
    world.run(0.2)
    assert world.truth().vehicles[WIFIBOT].linear_mps == 0.0


def test_an_unknown_vehicle_is_named_with_the_known_ones() -> None:
    with pytest.raises(KeyError, match=r"nobody.*wifibot-14"):
        World(gulliver()).set_drive("nobody", 0.0, 0.0)


def test_same_seed_same_world_and_another_seed_another() -> None:
    def story(seed: int) -> tuple[object, object]:
        world = World(gulliver(), seed)
        drive_for(world, 3.0, 0.5, 0.3)
        return world.truth(), world.odometry(WIFIBOT)

    assert story(5) == story(5)
    assert story(5) != story(6)


def test_vehicles_without_a_start_stand_apart_inside_an_area() -> None:
    world = World(gulliver(starts={}))
    poses = [SE2(p.x, p.y, p.yaw) for p in world.truth().vehicles.values()]
    assert all(world.lab.area_at(pose.x, pose.y) for pose in poses)
    assert min(a.distance_to(b) for i, a in enumerate(poses) for b in poses[:i]) > 0.5
