"""`./lilliput detect`: photographs with known tags, and files that are no pictures."""

import json
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from launcher.cli import main

APRILTAG_TO_OPENCV = [1, 0, 3, 2]
"""Which corner of AprilTag's order stands at each place of OpenCV's."""
PHOTOS = Path(__file__).resolve().parents[3] / "shared/data/apriltag"


def detect(capsys: pytest.CaptureFixture[str], *images: Path | str) -> tuple[int, dict[str, Any], str]:
    status = main(["detect", *map(str, images), "--json"])
    captured = capsys.readouterr()
    return status, json.loads(captured.out), captured.err


def truth(photo: Path) -> list[tuple[int, np.ndarray[Any, np.dtype[np.float64]]]]:
    """Ids and corners (4, 2), moved from AprilTag's pixel convention to OpenCV's."""
    lines = photo.with_suffix(".txt").read_text().splitlines()
    rows = [re.findall(r"-?\d+\.?\d*", line) for line in lines if line.strip()]
    return [(int(row[0]), np.array(row[1:9], dtype=np.float64).reshape(4, 2) - 0.5) for row in rows]


@pytest.mark.skipif(not PHOTOS.is_dir(), reason=f"the photographs are not on this machine ({PHOTOS})")
def test_tags_in_photographs_are_found_where_they_are_and_nowhere_else(capsys: pytest.CaptureFixture[str]) -> None:
    photos = sorted(PHOTOS.glob("*.jpg"))
    status, result, _ = detect(capsys, *photos)
    assert status == 0
    errors: list[float] = []
    known = 0
    for photo in photos:
        tags = result["figures"]["images"][str(photo)]
        expected = truth(photo)
        known += len(expected)
        assert {tag["family"] for tag in tags} == {"tag36h11"}
        for tag in tags:
            corners = np.array(tag["corners"])
            distances = [
                np.linalg.norm(corners - given[APRILTAG_TO_OPENCV], axis=1)
                for number, given in expected
                if number == tag["id"]
            ]
            assert distances, f"{photo.name}: invented a tag {tag['id']}"
            best = min(distances, key=lambda d: float(d.max()))
            assert best.max() < 5.0, f"{photo.name}: tag {tag['id']} is elsewhere"
            errors.extend(best.tolist())
    assert known == 47
    assert len(errors) / 4 >= 46
    assert float(np.median(errors)) <= 0.5


def test_what_is_no_picture_is_named_and_the_status_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = tmp_path / "broken.png"
    broken.write_bytes(b"\x89PNG\r\n\x1a\n not really")
    missing = tmp_path / "missing.png"
    status, result, errors = detect(capsys, broken, missing)
    assert status == 1
    assert result["figures"]["unreadable"] == 2
    assert result["figures"]["images"] == {}
    assert str(broken) in errors and str(missing) in errors


def test_pictures_are_called_as_they_were_typed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    cv2.imwrite("a.png", np.full((60, 80), 200, np.uint8))
    typed = ["./a.png", "a.png", f"..//{tmp_path.name}/a.png"]
    status, result, _ = detect(capsys, *typed)
    assert status == 0
    assert list(result["figures"]["images"]) == typed
    assert main(["detect", "./a.png"]) == 0
    assert capsys.readouterr().out == "./a.png: 0 tags\n"
