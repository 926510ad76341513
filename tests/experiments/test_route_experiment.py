"""The route experiment: its courses, its camera, its measure, and a short round of it."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from launcher.cli import main
from launcher.errors import UsageError
from launcher.experiments.route import CAMERA, chosen_vehicles, figures, trials_of
from launcher.experiments.route_camera import CeilingCamera
from launcher.experiments.route_courses import courses
from launcher.experiments.route_drive import Track, drive
from launcher.experiments.route_score import offsets, scored
from protocol.lab import load_lab
from protocol.messages import TrackedPose, TruePose

LAB = load_lab(Path("labs/kinds.yaml"))


def drives(vehicle: str, course: str, *controllers: str) -> list[Track]:
    return [drive(LAB, trial) for trial in trials_of([LAB.vehicle(vehicle)], controllers, [course], [1])]


def test_courses_begin_at_the_origin_heading_along_x_and_stay_in_the_hall() -> None:
    for course in courses():
        assert course.points[0] == (0.0, 0.0)
        assert course.points[1][1] == 0.0 and course.points[1][0] > 0.0
        assert all(LAB.area_at(x, y) is not None for x, y in course.points)
    assert {"straight", "corners", "s_curve", "circle", "zigzag", "heading"} == {course.name for course in courses()}


def test_the_camera_sees_the_tag_and_tells_of_the_rotation_centre() -> None:
    """Far ahead of the rotation centre, the tag's noisy heading moves it sideways; the covariance says so."""
    agv = LAB.vehicle("agv")
    true = TruePose(1.0, 2.0, 0.5, 0.0, 0.0)

    def seen_by(camera: CeilingCamera) -> list[TrackedPose]:
        return [pose for step in range(20_000) for pose in camera.look(true, step * 10_000_000, step / 100.0)]

    seen = seen_by(CeilingCamera(CAMERA, agv, 3))
    assert len(seen) == pytest.approx(200 * CAMERA.rate_hz, rel=0.01)
    errors = np.array([(pose.x - true.x, pose.y - true.y, pose.yaw - true.yaw) for pose in seen])
    xx, xy, xt, yy, yt, tt = seen[0].covariance
    assert np.allclose(np.cov(errors.T), [[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]], atol=0.1 * max(xx, yy))
    aside = np.array([-math.sin(true.yaw), math.cos(true.yaw)])
    assert np.std(errors[:, :2] @ aside) > 1.1 * CAMERA.sigma_m
    wild = seen_by(CeilingCamera(replace(CAMERA, outliers=0.05), agv, 3))
    assert 0.03 < np.mean([math.hypot(pose.x - true.x, pose.y - true.y) > 0.06 for pose in wild]) < 0.07


def test_offsets_are_those_of_the_part_of_the_line_that_is_driven() -> None:
    line = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, -1.0)])
    there = np.column_stack([np.linspace(0.0, 1.9, 500), np.full(500, 0.02)])
    assert offsets(there, line) == pytest.approx(np.full(191, 0.02), abs=1e-6)
    assert offsets(np.vstack([there, there[-1:]]), line)[-1] == pytest.approx(0.02)


def test_ours_keeps_to_the_line_where_the_reports_does_not() -> None:
    tracks = drives("wifibot", "corners", "gpss", "frenet")
    found = figures(tracks)
    assert found["wifibot_cross_track_gain"] >= 3.0
    assert found["wifibot_frenet_stop_error_mm"] <= 20.0
    assert found["wifibot_time_gain"] >= 1.0
    assert found["wifibot_frenet_not_arrived"] == found["wifibot_gpss_not_arrived"] == 0
    assert found["wifibot_met"] == 1
    json.dumps(found, allow_nan=False)
    limits = LAB.vehicle("wifibot").limits
    told = np.diff(tracks[1].setpoints[::5], axis=0) * 20.0
    assert np.abs(told[:, 1]).max() <= limits.yaw_acceleration_radps2 + 1e-6
    assert told[:, 0].max() <= limits.acceleration_mps2 + 1e-6


def test_the_agv_stands_with_its_heading_where_it_is_to() -> None:
    """Its rotation centre is the middle of the rear axle, its tag half a metre ahead of it."""
    (track,) = drives("agv", "heading", "frenet")
    score = scored(track)
    assert score.arrived
    assert score.stop_error_m <= 0.02
    assert score.heading_error_rad is not None and score.heading_error_rad < math.radians(3.0)


def test_the_same_seed_is_the_same_drive() -> None:
    first, second = (drives("turtlebot4", "straight", "frenet")[0] for _ in range(2))
    np.testing.assert_array_equal(first.poses, second.poses)


def test_vehicles_are_those_that_are_asked_for_or_one_of_each_kind() -> None:
    assert [vehicle.id for vehicle in chosen_vehicles(LAB, None)] == ["wifibot", "turtlebot4", "agv", "freke"]
    gulliver = load_lab(Path("labs/gulliver.yaml"))
    assert [vehicle.id for vehicle in chosen_vehicles(gulliver, None)] == ["wifibot-14", "turtlebot-16"]
    assert [vehicle.id for vehicle in chosen_vehicles(LAB, ["freke", "agv"])] == ["freke", "agv"]
    with pytest.raises(UsageError, match="no simulated vehicle forklift"):
        chosen_vehicles(LAB, ["forklift"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [(["--seeds", "0"], "--seeds"), (["--workers", "0"], "--workers"), (["--kinds", "forklift"], "forklift")],
)
def test_bad_use_is_one_line(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["experiment", "route", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_a_round_with_its_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--kinds", "freke", "--courses", "straight", "--controllers", "go_to_goal", "--seeds", "1"]
    assert main(["experiment", "route", "--json", *arguments, "--plot", str(tmp_path / "route.png")]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["name"] == "route"
    assert printed["figures"]["freke_go_to_goal_cross_track_p95_mm"] > 0.0
    assert (tmp_path / "route.png").stat().st_size > 10_000
