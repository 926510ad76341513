"""The mean of the floor tags' corners over a recording: what hides or moves a tag for a while does not count."""

import numpy as np
import pytest
from numpy.typing import NDArray

from localization.offline.floor_look import Sample, averaged_look

FOCAL_PX = 1145.0
SQUARE = np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 60.0], [0.0, 60.0]])
PLACES = {tag: SQUARE + np.array(at) for tag, at in ((3, (100.0, 200.0)), (4, (1500.0, 300.0)), (5, (800.0, 900.0)))}


def samples(count: int, *, moved_from: int | None = None, by_px: float = 5.0, noise_px: float = 0.05) -> list[Sample]:
    rng = np.random.default_rng(11)

    def corners(place: NDArray[np.float64], index: int) -> NDArray[np.float64]:
        shift = by_px if moved_from is not None and index >= moved_from else 0.0
        return place + shift + noise_px * rng.standard_normal((4, 2))

    return [Sample(1000 * i, {tag: corners(place, i) for tag, place in PLACES.items()}) for i in range(count)]


def test_noise_is_averaged_away_and_measured() -> None:
    look = averaged_look("cam", samples(30), FOCAL_PX)
    assert look.sighting is not None and look.moved_ns is None
    assert look.sighting.frames == 30 and look.sighting.stamp_ns == 29_000
    assert look.sighting.corner_noise_px == pytest.approx(0.05, rel=0.25)
    for tag, place in PLACES.items():
        assert np.abs(look.sighting.corners[tag] - place).max() < 0.04


def test_a_tag_that_is_hidden_or_read_elsewhere_for_a_while_keeps_its_place() -> None:
    seen = samples(20)
    for sample in seen[8:17]:
        del sample.corners[3]
    for sample in seen[2:6]:
        sample.corners[4] = sample.corners[4] + 40.0
    look = averaged_look("cam", seen, FOCAL_PX)
    assert look.sighting is not None and look.moved_ns is None
    assert sorted(look.sighting.corners) == [3, 4, 5]
    assert np.abs(look.sighting.corners[4] - PLACES[4]).max() < 0.06


def test_of_a_camera_that_was_moved_only_the_time_before_counts() -> None:
    look = averaged_look("cam", samples(20, moved_from=12), FOCAL_PX)
    assert look.moved_ns == 12_000
    assert look.sighting is not None and look.sighting.frames == 12
    assert np.abs(look.sighting.corners[5] - PLACES[5]).max() < 0.1


def test_a_jerk_that_passes_is_no_move() -> None:
    seen = samples(20)
    seen[9] = Sample(9000, {tag: corners + 30.0 for tag, corners in seen[9].corners.items()})
    look = averaged_look("cam", seen, FOCAL_PX)
    assert look.moved_ns is None
    assert look.sighting is not None
    assert np.abs(look.sighting.corners[5] - PLACES[5]).max() < 0.1


def test_a_reading_out_of_nowhere_is_not_believed_and_an_empty_floor_gives_nothing() -> None:
    seen = samples(20)
    seen[4].corners[9] = SQUARE
    look = averaged_look("cam", seen, FOCAL_PX)
    assert look.sighting is not None and 9 not in look.sighting.corners
    empty = averaged_look("cam", [Sample(0, {}), Sample(1, {})], FOCAL_PX)
    assert empty.sighting is None and empty.moved_ns is None
    assert averaged_look("cam", [], FOCAL_PX).sighting is None


def test_one_frame_is_enough_to_have_a_place() -> None:
    look = averaged_look("cam", samples(1), FOCAL_PX)
    assert look.sighting is not None
    assert look.sighting.frames == 1 and look.sighting.corner_noise_px == 0.0
