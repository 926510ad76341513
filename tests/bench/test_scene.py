"""The film of the benchmark: closes without a jump, moves as fast as it says, and knows what is visible."""

import itertools
import math
from pathlib import Path

import pytest

from launcher.paths import DEFAULT_LAB
from protocol.lab import load_lab
from tests.bench.baselines.detector import PublishedDetector
from tests.bench.scene import LOOP_FRAMES, RATE_HZ, SPEED_MPS, bench_lab, decoded, read_recording, record, vehicles_at


@pytest.mark.parametrize(("resolution", "count"), [("fullhd", 1), ("fullhd", 20), ("uhd", 4)])
def test_everybody_comes_back_at_the_speed_said(resolution: str, count: int) -> None:
    lab = bench_lab(load_lab(DEFAULT_LAB), resolution, count)
    frames = LOOP_FRAMES[resolution]
    way = [vehicles_at(lab, frame / frames) for frame in range(frames + 1)]
    assert len(way[0]) == count
    for index in range(count):
        path = [present[index] for present in way]
        assert (path[-1].x, path[-1].y) == pytest.approx((path[0].x, path[0].y))
        for before, after in itertools.pairwise(path):
            moved_m = math.hypot(after.x - before.x, after.y - before.y)
            assert moved_m * RATE_HZ == pytest.approx(SPEED_MPS, rel=0.01)
            heading = math.atan2(after.y - before.y, after.x - before.x)
            middle = before.yaw + before.angular_radps / RATE_HZ / 2
            assert math.cos(heading - middle) == pytest.approx(1.0, abs=1e-6)


def test_twenty_vehicles_keep_apart() -> None:
    lab = bench_lab(load_lab(DEFAULT_LAB), "fullhd", 20)
    for phase in (0.0, 0.3, 0.7):
        present = vehicles_at(lab, phase)
        apart = [math.dist((a.x, a.y), (b.x, b.y)) for i, a in enumerate(present) for b in present[:i]]
        assert min(apart) > 0.55


def test_a_recording_tells_the_truth_of_its_pictures(tmp_path: Path) -> None:
    lab = bench_lab(load_lab(DEFAULT_LAB), "fullhd", 4)
    record([lab], "cam1", 3, 1, [tmp_path / "cam1"])
    recording = read_recording(tmp_path / "cam1")
    assert decoded(recording.frames[0].jpeg).shape == (1080, 1920)
    # cam1 looks at x = 3: at 2.4 one is in view, at 4.0 another.
    assert set(recording.frames[0].truth) == {21, 22}
    detector = PublishedDetector(lab.floor_tags.family, range(40), 1)
    assert set(detector.detect(decoded(recording.floor))) == {2, 3, 4, 5}, "calibration needs the bare floor"
    stamps = [recording.stamp_ns(number, 0) for number in range(7)]
    steps = {after - before for before, after in itertools.pairwise(stamps)}
    assert max(steps) - min(steps) <= 2, "the film goes on at one pace over its end"
