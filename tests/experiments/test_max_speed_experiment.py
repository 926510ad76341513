"""Driving straight through a camera's view: slow tags are followed from one edge to the other, too fast ones are not."""

import math
from pathlib import Path

import numpy as np
import pytest

from geometry import SE2
from launcher.cli import main
from launcher.experiments.cameras import with_cameras
from launcher.experiments.crossings import ACCELERATION_MPS2, Crossing, crossings
from launcher.experiments.max_speed import SpeedTest, drives, speed_lab
from launcher.experiments.visibility import TagVisibility
from protocol.lab import load_lab

GULLIVER = Path(__file__).resolve().parents[2] / "labs/gulliver.yaml"


def test_a_crossing_keeps_its_speed_and_line() -> None:
    drive = list(Crossing("car", 1.0, 2.0, math.pi / 2).drive(3.0, rate_hz=60.0))
    assert {at.linear_mps for at in drive} == {3.0}
    assert [at.x for at in drive] == pytest.approx([1.0] * len(drive))
    assert np.diff([at.y for at in drive]) == pytest.approx(0.05)
    assert drive[0].y < 2.0 - 3.5
    assert drive[-1].y > 2.0 + 3.5


def test_a_start_from_rest_reaches_its_speed_by_its_acceleration() -> None:
    drive = list(Crossing("car", 0.0, 0.0, 0.0, ACCELERATION_MPS2).drive(4.0, rate_hz=100.0))
    at_rest = [at for at in drive if at.linear_mps == 0.0]
    assert len(at_rest) > 5
    assert all((at.x, at.y) == (0.0, 0.0) for at in at_rest)
    accelerating = [at for at in drive if 0.0 < at.linear_mps < 4.0]
    assert len(accelerating) == pytest.approx(40, abs=1), "4 m/s at 10 m/s^2 take 0.4 s"
    for at in accelerating:
        assert at.linear_mps**2 == pytest.approx(2 * ACCELERATION_MPS2 * at.x)
    assert np.diff([at.x for at in drive if at.linear_mps == 4.0]) == pytest.approx(0.04)


def test_the_drives_of_a_seed_lead_through_the_view_in_all_directions() -> None:
    lab = speed_lab(load_lab(GULLIVER), "cam1", "fullhd", 100)
    lines = drives(lab, "cam1", 5)
    assert lines == drives(lab, "cam1", 5) != drives(lab, "cam1", 6)
    visibility = TagVisibility(lab, "cam1", 5)
    for line in lines:
        seen = [visibility.sees(at.id, SE2(at.x, at.y, at.yaw)) for at in line.drive(2.0, rate_hz=60.0)]
        assert sum(seen) > 30
    headings = np.array([line.heading for line in lines])
    assert {round(math.cos(h)) for h in headings} == {round(math.sin(h)) for h in headings} == {-1, 0, 1}
    assert {line.vehicle for line in lines} == {vehicle.id for vehicle in lab.vehicles}


def test_half_of_the_crossings_at_least_are_as_fast_as_said() -> None:
    lines = crossings(("a", "b"), (0.0, 0.0), (1.0, 2.0), np.random.default_rng(1))
    assert sum(line.acceleration_mps2 is None for line in lines) == 6
    assert sum(line.acceleration_mps2 is not None for line in lines) == 2


def test_4k_is_the_same_lens_with_four_times_the_pixels() -> None:
    lab = load_lab(GULLIVER)
    large, small = with_cameras(lab, "uhd", 60.0).cameras[0].model(), lab.cameras[0].model()
    assert (large.width, large.height) == (3840, 2160)
    ray = np.array([0.3, -0.2, 1.0])
    at_large, at_small = (model.matrix() @ ray for model in (large, small))
    # Seen from the picture's corner, half a pixel before the first pixel's centre, everything is twice as far.
    assert at_large[:2] + 0.5 == pytest.approx(2 * (at_small[:2] + 0.5))


def test_a_tag_is_followed_at_a_speed_that_blurs_it_little_and_lost_when_little_is_left_of_it() -> None:
    lab = speed_lab(load_lab(GULLIVER), "cam0", "fullhd", 50)
    camera = SpeedTest(lab, "cam0", seed=3)
    across = Crossing("fast-1", 1.0, 2.15, 0.05)
    slow = camera.run(across, 2.0)
    assert slow.followed
    assert slow.visible > 60
    from_rest = camera.run(Crossing("fast-0", 1.0, 0.8, math.pi / 2, ACCELERATION_MPS2), 2.0)
    assert from_rest.followed
    assert not camera.run(across, 8.0).followed, "14 px of blur leave nothing of 22 px"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--camera", "cam9"], "no simulated camera cam9"),
        (["--seeds", "0"], "--seeds must be 1 to 100, not 0"),
    ],
)
def test_bad_use_is_one_line(more: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["experiment", "max-speed", "--lab", str(GULLIVER), *more]) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert captured.err.count("\n") == 1
