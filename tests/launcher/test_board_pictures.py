"""Pictures of a calibration board: from a folder or a video."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import ExifTags, Image

from launcher.board_pictures import BoardPictures, of_camera
from launcher.errors import UsageError

SIZE = (64, 48)


def shade(number: int) -> np.ndarray:
    return np.full((SIZE[1], SIZE[0], 3), 20 * number, np.uint8)


def levels(path: Path, every: int = 1) -> list[int]:
    """The mean brightness of each picture, in steps of `shade`."""
    return [round(float(picture.mean()) / 20) for picture in BoardPictures(path, every)]


def test_a_folder_is_read_in_the_order_of_names_in_grey(tmp_path: Path) -> None:
    for number in (3, 1, 2):
        cv2.imwrite(str(tmp_path / f"{number}.png"), shade(number))
    (tmp_path / "2b.png").write_bytes(b"no picture")
    (tmp_path / "notes.txt").write_text("not one either")
    assert levels(tmp_path) == [1, 2, 3]
    assert next(iter(BoardPictures(tmp_path))).shape == (48, 64)
    assert levels(tmp_path, every=2) == [1], "the one that cannot be read has its turn"
    pictures = BoardPictures(tmp_path)
    for _ in range(2):
        assert len(list(pictures)) == 3
        assert (pictures.taken, pictures.total, pictures.unreadable) == (4, 4, 1)


@pytest.mark.parametrize("orientation", [1, 3, 6])
def test_pictures_lie_as_the_sensor_does(tmp_path: Path, orientation: int) -> None:
    pixels = np.zeros((48, 64), np.uint8)
    pixels[:10, :20] = 200
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = orientation
    Image.fromarray(pixels).save(tmp_path / "1.jpg", exif=exif, quality=95)
    (picture,) = BoardPictures(tmp_path)
    assert np.abs(picture.astype(int) - pixels).max() < 40


def test_a_video_is_read_in_the_order_of_time(tmp_path: Path) -> None:
    file = tmp_path / "board.avi"
    writer = cv2.VideoWriter(str(file), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, SIZE)
    for number in range(8):
        writer.write(shade(number))
    writer.release()
    assert levels(file) == list(range(8))
    assert levels(file, every=3) == [0, 3, 6]


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("nothing", "does not exist"),
        ("empty", "holds no pictures"),
        ("text", "neither a folder"),
        ("lab", "one of cam0, cam1"),
    ],
)
def test_what_holds_no_pictures_is_refused(tmp_path: Path, name: str, says: str) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "lab/cam0").mkdir(parents=True)
    (tmp_path / "lab/cam1.mp4").touch()
    (tmp_path / "text").write_text("hello")
    with pytest.raises(UsageError, match=says):
        list(BoardPictures(tmp_path / name))


def test_a_camera_of_a_recording_is_a_folder_or_a_video(tmp_path: Path) -> None:
    (tmp_path / "cam0").mkdir()
    (tmp_path / "lab.yaml").touch()
    for name in ("cam1.mp4", "cam1.stamps", "cam2.mp4", "cam2.avi"):
        (tmp_path / name).touch()
    assert of_camera(tmp_path, "cam0") == tmp_path / "cam0"
    assert of_camera(tmp_path, "cam1") == tmp_path / "cam1.mp4"
    with pytest.raises(UsageError, match=r"has cam2 more than once: cam2\.avi, cam2\.mp4"):
        of_camera(tmp_path, "cam2")
    with pytest.raises(UsageError, match="no camera 'lab'; it has cam0, cam1, cam2, cam2"):
        of_camera(tmp_path, "lab")
    with pytest.raises(UsageError, match="no folder with a video"):
        of_camera(tmp_path / "cam1.mp4", "cam1")
