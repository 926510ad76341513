"""The AprilTag library's own photographs: nearly every tag, at the right place, and nothing that is not there."""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from localization.images import ImageTag, UnreadableImageError, detect_image
from tests.localization.synthetic import printed

PHOTOGRAPHS = Path(__file__).resolve().parents[3] / "shared/data/apriltag"
needs_photographs = pytest.mark.skipif(not PHOTOGRAPHS.is_dir(), reason=f"no photographs at {PHOTOGRAPHS}")


def given_tags(path: Path) -> list[tuple[int, NDArray[np.float64]]]:
    """Ids and corners (4, 2), from AprilTag's pixels and order to OpenCV's."""
    tags: list[tuple[int, NDArray[np.float64]]] = []
    for line in path.read_text().splitlines():
        if line.strip():
            numbers = re.findall(r"\(([-\d.]+) ([-\d.]+)\)", line)
            tags.append((int(line.split(",")[0]), np.array(numbers, dtype=np.float64)[[1, 0, 3, 2]] - 0.5))
    return tags


def corner_errors(found: ImageTag, corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances of the corners, first to first."""
    return np.linalg.norm(np.array(found.corners) - corners, axis=1)


@needs_photographs
def test_the_photographs_tags_are_found_and_nothing_else() -> None:
    errors: list[float] = []
    total = found_count = 0
    for text in sorted(PHOTOGRAPHS.glob("*_c.txt")):
        truth = given_tags(text)
        found = detect_image(text.with_suffix(".jpg"))
        total += len(truth)
        matched: set[int] = set()
        for tag_id, corners in truth:
            candidates = [
                (float(corner_errors(tag, corners).mean()), index)
                for index, tag in enumerate(found)
                if tag.id == tag_id and index not in matched
            ]
            if candidates and min(candidates)[0] < 3.0:
                index = min(candidates)[1]
                matched.add(index)
                errors.extend(corner_errors(found[index], corners))
        assert len(matched) == len(found), f"{text.stem}: a tag that is not there"
        found_count += len(matched)
    assert total == 47
    assert found_count >= 46
    assert float(np.median(errors)) <= 0.5


def test_a_file_that_is_no_picture_is_named(tmp_path: Path) -> None:
    for name, content in (("empty.png", b""), ("text.jpg", b"not a picture")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(UnreadableImageError, match=name):
            detect_image(tmp_path / name)
    for missing in (tmp_path / "missing.png", tmp_path):
        with pytest.raises(UnreadableImageError, match=re.escape(str(missing))):
            detect_image(missing)


def test_a_drawn_tag_has_the_corners_that_it_was_drawn_with(tmp_path: Path) -> None:
    import cv2

    picture = np.full((300, 400), 200, np.uint8)
    picture[20:260, 60:300] = printed(7)
    cv2.imwrite(str(tmp_path / "seven.png"), picture)
    (tag,) = detect_image(tmp_path / "seven.png")
    assert (tag.family, tag.id) == ("tag36h11", 7)
    # 24 px of white around 8 cells of 24 px; a corner lies between two pixels.
    square = np.array([[84, 44], [276, 44], [276, 236], [84, 236]]) - 0.5
    assert np.array(tag.corners) == pytest.approx(square, abs=0.2)
    assert tag.decision_margin > 50
