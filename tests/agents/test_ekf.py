"""The Kalman filter as a whole: order, outliers, recovery, what it learns, and honesty without cameras."""

import logging
import math
from dataclasses import replace

import numpy as np
import pytest

from agents.consistency_log import ConsistencyLog
from agents.control import GpssController
from agents.drivers import OdometryReading
from agents.estimation import EkfConfig, EkfEstimator, Estimate, Localization, NisWatch, NoiseConfig, Reference
from agents.estimation.ekf_gate import AGREEING
from agents.motion import STOP, Twist
from agents.pilot import Pilot
from geometry import SE2, angle_difference
from protocol.lab import load_lab
from tests.agents.fusion_drive import MS, START_NS, FusionDrive
from tests.agents.plant import tracked

LAB = load_lab("labs/gulliver.yaml")


def normalised(estimate: Estimate, truth: SE2) -> float:
    """The NEES over x, y and yaw."""
    assert estimate.pose is not None and estimate.covariance is not None
    pose = estimate.pose
    error = np.array([pose.x - truth.x, pose.y - truth.y, angle_difference(pose.yaw, truth.yaw)])
    covariance = np.zeros((3, 3))
    covariance[np.triu_indices(3)] = estimate.covariance
    covariance += np.triu(covariance, 1).T
    return float(error @ np.linalg.solve(covariance, error))


def standing(stamps_ms: range) -> EkfEstimator:
    estimator = EkfEstimator()
    for ms in stamps_ms:
        estimator.add_odometry(OdometryReading(START_NS + ms * MS, "a", SE2.identity(), STOP))
    return estimator


KNOWN = EkfConfig(noise=NoiseConfig(scale_sigma=(1e-6, 1e-6, 1e-6), delay_sigma_s=0.0, delay_walk_s=0.0))
"""Noises and delay are as assumed: nothing of them is learned."""


@pytest.mark.parametrize(("config", "metres"), [(KNOWN, 1e-9), (EkfConfig(), 1e-3)])
def test_poses_out_of_order_count_as_if_in_order(config: EkfConfig, metres: float) -> None:
    """To the last digit but for what is learned, which depends on the order a little."""

    def ended(order: list[int]) -> Estimate:
        estimator = EkfEstimator(config)
        for ms in range(0, 1001, 50):
            estimator.add_odometry(OdometryReading(START_NS + ms * MS, "a", SE2(ms * 5e-4, 0.0, 0.0), Twist(0.5, 0.0)))
        for ms in (0, *order):
            pose = SE2(ms * 5e-4 + 0.004 * math.sin(ms), 0.003 * math.cos(ms), 0.01 * math.sin(3 * ms))
            assert estimator.add_camera_pose(tracked("r", pose, START_NS + ms * MS))
        return estimator.estimate(START_NS + 1000 * MS)

    stamps = list(range(100, 1000, 100))
    forward = ended(stamps)
    for order in (stamps[::-1], [500, 100, 900, 300, 700, 200, 800, 400, 600]):
        other = ended(order)
        assert forward.pose is not None and other.pose is not None
        assert forward.pose.distance_to(other.pose) < metres
        assert forward.camera_stamp_ns == other.camera_stamp_ns == START_NS + 900 * MS


def test_a_pose_older_than_the_horizon_is_refused() -> None:
    estimator = standing(range(0, 5001, 50))
    assert estimator.add_camera_pose(tracked("r", SE2.identity(), START_NS + 4_950 * MS))
    assert not estimator.add_camera_pose(tracked("r", SE2.identity(), START_NS + 2_500 * MS))
    assert not estimator.add_camera_pose(tracked("r", SE2.identity(), START_NS + 9_000 * MS)), "odometry is not there"


def test_single_outliers_never_move_it() -> None:
    drive = FusionDrive(EkfEstimator())
    list(drive.run(8.0))
    worst = 0.0
    for number in range(30):
        drive.spoil = lambda pose, off=number: SE2(pose.x + 0.5 * math.cos(off), pose.y + 0.5 * math.sin(off), off)
        worst = max(worst, *drive.run(0.07))
        drive.spoil = lambda pose: pose
        worst = max(worst, *drive.run(0.35))
    report = drive.estimator.consistency()
    assert worst < 0.05
    assert report is not None and report.refused >= 25


def test_contradicting_outliers_alone_never_move_it() -> None:
    drive = FusionDrive(EkfEstimator())
    list(drive.run(8.0))
    turn = iter(range(1000))

    def anywhere(pose: SE2) -> SE2:
        angle = 2.4 * next(turn)
        return SE2(pose.x + 1.5 * math.cos(angle), pose.y + 1.5 * math.sin(angle), pose.yaw + angle)

    drive.spoil = anywhere
    before_ns = drive.estimator.estimate(drive.now_ns).camera_stamp_ns
    assert max(drive.run(3.0)) < 0.2
    after_ns = drive.estimator.estimate(drive.now_ns).camera_stamp_ns
    assert before_ns is not None and after_ns is not None
    assert after_ns - before_ns <= 200 * MS, "so the agent sees how old the pose is, and stops"


def test_a_lifted_robot_is_believed_after_so_many_poses() -> None:
    estimator = standing(range(0, 2001, 50))
    for ms in range(0, 1000, 100):
        assert estimator.add_camera_pose(tracked("r", SE2.identity(), START_NS + ms * MS))
    there = SE2(3.0, 1.0, 2.0)
    used = [estimator.add_camera_pose(tracked("r", there, START_NS + ms * MS)) for ms in range(1000, 1600, 100)]
    assert used == [False] * (AGREEING - 1) + [True, True]
    pose = estimator.estimate(START_NS + 2000 * MS).pose
    assert pose is not None and pose.distance_to(there) < 0.01


def test_a_start_at_an_outlier_is_overcome() -> None:
    drive = FusionDrive(EkfEstimator())
    drive.spoil = lambda _: SE2(-4.0, -4.0, 0.0)
    list(drive.run(0.071))
    drive.spoil = lambda pose: pose
    assert max(list(drive.run(5.0))[30:]) < 0.05


def test_wheels_are_learned() -> None:
    drive = FusionDrive(EkfEstimator(), distance_scale=1.03, turn_scale=0.95)
    list(drive.run(60.0))
    estimator = drive.estimator
    assert isinstance(estimator, EkfEstimator)
    assert estimator.constants["linear"] == pytest.approx(1 / 1.03, abs=0.006)
    assert estimator.constants["angular"] == pytest.approx(1 / 0.95, abs=0.02)
    assert abs(estimator.constants["curvature_radpm"]) < 0.01
    assert abs(estimator.constants["delay_s"]) < 0.008


def test_late_stamps_are_learned_and_made_up_for() -> None:
    """Unlearned, 80 ms at 0.5 m/s are 40 mm."""
    drive = FusionDrive(EkfEstimator(), stamps_late_ms=80)
    errors = list(drive.run(60.0))[-400:]
    assert isinstance(drive.estimator, EkfEstimator)
    assert drive.estimator.constants["delay_s"] == pytest.approx(0.08, abs=0.012)
    assert math.sqrt(sum(error**2 for error in errors) / len(errors)) < 0.015


def test_the_cameras_clock_may_be_the_right_one() -> None:
    """The same stamps, read as odometry that is 80 ms early: the estimate is where the robot was then."""
    drive = FusionDrive(EkfEstimator(EkfConfig(reference=Reference.CAMERA)), stamps_late_ms=80)
    behind = list(drive.run(60.0))[-400:]
    assert sum(behind) / len(behind) == pytest.approx(0.5 * 0.08, abs=0.01)


@pytest.mark.parametrize("seed_ms", [0, 700, 1900])
def test_eight_seconds_without_cameras(seed_ms: int) -> None:
    """It goes on, and says how well: four metres on wheels that lie by 2 %."""
    drive = FusionDrive(EkfEstimator(), distance_scale=1.02, turn_scale=0.98)
    list(drive.run(40.0 + seed_ms / 1e3))
    before = drive.estimator.estimate(drive.now_ns)
    drive.camera_works = False
    errors = list(drive.run(8.0))
    after = drive.estimator.estimate(drive.now_ns)
    assert max(errors) < 0.25
    assert after.localization is Localization.ALIGNED
    assert before.covariance is not None and after.covariance is not None
    assert after.covariance[0] + after.covariance[3] > 4.0 * (before.covariance[0] + before.covariance[3])
    assert normalised(after, drive.plant.pose) < 16.3
    drive.camera_works = True
    assert max(list(drive.run(3.0))[20:]) < 0.05


def test_honest_in_a_long_drive() -> None:
    """The mean NEES of samples two seconds apart; 3 is right. Wheels that lie always the same are better than what is assumed."""
    drive = FusionDrive(EkfEstimator(), distance_scale=1.02)
    list(drive.run(10.0))
    found: list[float] = []
    for _ in range(40):
        list(drive.run(2.0))
        found.append(normalised(drive.estimator.estimate(drive.now_ns), drive.plant.pose))
    report = drive.estimator.consistency()
    assert sum(found) / len(found) < 4.5
    assert report is not None and report.is_consistent, str(report)


def test_good_wheels_are_found_within_half_a_minute() -> None:
    """However little their noise is against the camera's; until then covariances are too large. It starts at 1."""
    drive = FusionDrive(EkfEstimator())
    list(drive.run(30.0))
    assert isinstance(drive.estimator, EkfEstimator)
    way, turn, camera = drive.estimator.noise.scales
    assert way < 0.2 and turn < 0.01
    assert camera == pytest.approx(1.0, abs=0.15)


def test_a_camera_worse_than_it_claims_is_believed_less() -> None:
    drive = FusionDrive(EkfEstimator(), noise_m=0.01)
    drive.spoil = lambda pose: SE2(
        pose.x + 0.015 * math.sin(1e6 * pose.x), pose.y + 0.015 * math.sin(1e6 * pose.y), pose.yaw
    )
    list(drive.run(40.0))
    assert isinstance(drive.estimator, EkfEstimator)
    assert drive.estimator.noise.scales[2] > 1.2


def test_lost_after_half_a_minute_or_when_nothing_is_known_any_more() -> None:
    estimator = standing(range(0, 1001, 50))
    assert estimator.add_camera_pose(tracked("r", SE2.identity(), START_NS + 1000 * MS))
    assert estimator.estimate(START_NS + 10_000 * MS).localization is Localization.ALIGNED
    assert estimator.estimate(START_NS + 32_000 * MS).localization is Localization.LOST
    driving = EkfEstimator()
    driving.add_odometry(OdometryReading(START_NS, "a", SE2.identity(), Twist(0.8, 0.0)))
    assert driving.add_camera_pose(tracked("r", SE2.identity(), START_NS))
    assert driving.estimate(START_NS + 4_000 * MS).localization is Localization.LOST


def test_what_was_learned_survives_a_restart_of_the_base() -> None:
    drive = FusionDrive(EkfEstimator(), distance_scale=1.03)
    list(drive.run(30.0))
    estimator = drive.estimator
    assert isinstance(estimator, EkfEstimator)
    before = estimator.constants
    estimator.add_odometry(OdometryReading(drive.now_ns + 50 * MS, "b", SE2.identity(), STOP))
    assert estimator.estimate(drive.now_ns + 50 * MS).localization is Localization.LOST
    assert estimator.constants == before


def test_a_base_that_restarts_in_silence_is_noticed() -> None:
    estimator = EkfEstimator()
    estimator.add_odometry(OdometryReading(START_NS, "a", SE2(20.0, 0.0, 0.0), STOP))
    assert estimator.add_camera_pose(tracked("r", SE2(1.0, 1.0, 0.0), START_NS))
    estimator.add_odometry(OdometryReading(START_NS + 50 * MS, "a", SE2.identity(), STOP))
    lost = estimator.estimate(START_NS + 50 * MS)
    assert (lost.localization, lost.pose) == (Localization.LOST, SE2(1.0, 1.0, 0.0))


def test_covariance_grows_while_odometry_is_silent() -> None:
    estimator = standing(range(0, 201, 50))
    assert estimator.add_camera_pose(tracked("r", SE2.identity(), START_NS + 200 * MS))
    now, later = (estimator.estimate(START_NS + ms * MS).covariance for ms in (200, 600))
    assert now is not None and later is not None
    assert later[0] > now[0] + 1e-4 and later[5] > now[5] + 1e-3


def test_constants_that_are_taken_for_known_stay() -> None:
    drive = FusionDrive(
        EkfEstimator(EkfConfig(noise=replace(NoiseConfig(), delay_sigma_s=0.0))), distance_scale=1.02, stamps_late_ms=60
    )
    list(drive.run(10.0))
    assert isinstance(drive.estimator, EkfEstimator)
    assert drive.estimator.constants["delay_s"] == 0.0


def test_the_agent_tells_of_consistency_seldom_and_of_its_lack_each_minute(caplog: pytest.LogCaptureFixture) -> None:
    estimator, watch = EkfEstimator(), NisWatch()
    vehicle = LAB.vehicle("wifibot-14")
    pilot = Pilot(LAB, vehicle, estimator, GpssController(vehicle.limits))
    estimator.consistency = watch.report  # type: ignore[method-assign]
    log = ConsistencyLog(pilot, 0.0)
    with caplog.at_level(logging.INFO):
        log.look(61.0)
        assert not caplog.records, "nothing was seen yet"
        for _ in range(200):
            watch.add_used(3.0)
        for second in range(62, 700):
            log.look(float(second))
        assert [record.levelname for record in caplog.records] == ["INFO"]
        assert "mean NIS 3.00 over 200 poses" in caplog.text
        for _ in range(200):
            watch.add_used(9.0)
        for second in range(700, 1000):
            log.look(float(second))
    assert [record.levelname for record in caplog.records[1:]] == ["WARNING"] * 5
