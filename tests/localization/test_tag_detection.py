"""The detector's strategies: OpenCV's conventions, windows as good as the whole frame, nothing believed that is unknown."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from geometry import SE2
from localization.detection import FullSearch, TagDetector, TagGuess, TagObservation, WindowedSearch, decimation_for
from tests.localization.synthetic import MOUNTS, PlacedTag, floor_tags, printed, render, small_lab

LAB = small_lab()
MODEL = LAB.camera("left").model()
FAMILIES = ("tag36h11",)


def guess_at(tag: TagObservation, side_px: float | None = None, dx: float = 0.0, dy: float = 0.0) -> TagGuess:
    x, y = (float(value) for value in tag.centre)
    return TagGuess(tag.key, x + dx, y + dy, side_px or tag.side_px, 12.0)


@pytest.fixture(scope="module")
def scene() -> NDArray[np.uint8]:
    tags = [
        *floor_tags(LAB),
        PlacedTag(10, SE2(0.7, 0.6, 0.8), 0.3, 0.16),
        PlacedTag(11, SE2(1.1, 0.3, -2.0), 0.3, 0.16),
    ]
    return render(MODEL, MOUNTS["left"], tags)


@pytest.fixture(scope="module")
def detector() -> TagDetector:
    return TagDetector(FAMILIES)


def test_corners_are_where_and_in_the_order_that_opencv_says(scene: NDArray[np.uint8], detector: TagDetector) -> None:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    corners, ids, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(scene)
    expected = {int(tag_id): np.asarray(quad).reshape(4, 2) for quad, tag_id in zip(corners, ids.ravel(), strict=True)}
    found = {tag.tag_id: tag.corners for tag in FullSearch(detector, 30.0).find(scene)}
    assert set(expected) == set(found) == {0, 1, 2, 3, 10, 11}
    differences = np.array([found[tag_id] - expected[tag_id] for tag_id in expected])
    assert float(np.abs(differences).max()) < 1.5
    # A difference of conventions would show as a common shift.
    assert float(np.abs(differences.mean(axis=(0, 1))).max()) < 0.2


def test_a_window_gives_the_corners_of_the_whole_frame(scene: NDArray[np.uint8], detector: TagDetector) -> None:
    whole = {tag.key: tag for tag in FullSearch(detector, 10.0).find(scene)}
    target = whole["tag36h11", 10]
    tags = WindowedSearch(detector).find(scene, [guess_at(target, dx=9.0, dy=-7.0)])
    (tag,) = [tag for tag in tags if tag.key == target.key]
    assert tag.corners == pytest.approx(target.corners, abs=0.15)


def test_a_colour_frame_is_as_good_as_a_grey_one(scene: NDArray[np.uint8], detector: TagDetector) -> None:
    colour = np.stack([scene] * 3, axis=-1)
    grey_tags, colour_tags = (FullSearch(detector, 30.0).find(image) for image in (scene, colour))
    assert {tag.key for tag in grey_tags} == {tag.key for tag in colour_tags}
    tag = colour_tags[0]
    assert tag.key in {found.key for found in WindowedSearch(detector).find(colour, [guess_at(tag)])}


def test_unknown_ids_are_not_believed(scene: NDArray[np.uint8]) -> None:
    only = TagDetector(FAMILIES, known={("tag36h11", 10), ("tag36h11", 3)})
    assert {tag.tag_id for tag in FullSearch(only, 30.0).find(scene)} == {3, 10}


def test_two_prints_of_one_id_are_two_and_one_seen_twice_is_one(detector: TagDetector) -> None:
    image = np.full((400, 900), 90, np.uint8)
    image[80:320, 60:300] = printed(5)
    image[80:320, 560:800] = printed(5)
    guesses = [TagGuess(("tag36h11", 5), x, 199.5, 192.0, 30.0) for x in (175.0, 185.0, 680.0)]
    tags = WindowedSearch(detector).find(image, guesses)
    assert sorted(round(float(tag.centre[0])) for tag in tags) == [180, 680]


def test_windows_outside_the_frame_find_nothing(scene: NDArray[np.uint8], detector: TagDetector) -> None:
    search = WindowedSearch(detector)
    for x, y in ((-500.0, 100.0), (100.0, 5000.0), (-20.0, -20.0), (959.0, 539.0)):
        assert search.find(scene, [TagGuess(("tag36h11", 10), x, y, 45.0, 10.0)]) == []


def test_what_the_coarse_look_misses_the_finer_one_finds(detector: TagDetector) -> None:
    """A tag much smaller than expected: a third of its pixels are too few, two thirds are enough."""
    image = render(MODEL, MOUNTS["left"], [PlacedTag(10, SE2(0.7, 0.6, 0.5), 0.3, 0.07)])
    (truth,) = detector.detect(image, 1.0)
    assert 20 < truth.side_px < 25
    expected_px = 2.5 * truth.side_px
    assert detector.detect(image, decimation_for(expected_px, 18.0)) == []
    guess = guess_at(truth, side_px=expected_px)
    assert [found.tag_id for found in WindowedSearch(detector).find(image, [guess])] == [10]


@given(st.integers(1, 40), st.integers(1, 40), st.sampled_from([1.0, 1.5, 2.0, 3.0, 5.0, 8.0]), st.integers(0, 9))
def test_images_of_any_size_are_survived(height: int, width: int, decimation: float, seed: int) -> None:
    noise = np.random.default_rng(seed).integers(0, 256, (height, width)).astype(np.uint8)
    assert TagDetector(FAMILIES, known=()).detect(noise, decimation) == []


def test_clutter_is_not_a_tag(detector: TagDetector) -> None:
    rng = np.random.default_rng(3)
    search = FullSearch(detector, 20.0)
    for _ in range(10):
        image = np.full((540, 960), 120, np.uint8)
        for _ in range(250):
            corner = rng.integers(0, 950, 2)
            size = rng.integers(4, 60, 2)
            colour = int(rng.integers(0, 256))
            cv2.rectangle(image, corner.tolist(), (corner + size).tolist(), colour, -1)
        assert search.find(image) == []


def test_the_detector_leaves_the_callers_image_alone(scene: NDArray[np.uint8], detector: TagDetector) -> None:
    before = scene.copy()
    for decimation in (1.0, 2.0):
        detector.detect(scene, decimation)
    assert np.array_equal(scene, before)
