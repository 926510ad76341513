"""What outlives a restart of the camera: the learned floor; and the picture of the floor that it leaves for others."""

import logging
from pathlib import Path

import cv2
import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from geometry import SE2
from localization.floor import FloorObserver
from localization.floor.store import background_path
from mapping.tiles import FloorTile
from protocol.messages import SimulatedObject
from tests.localization.floor_scene import LAB, Scene, pallet

PALLET_BOX = [(0.8, 2.9), (1.2, 2.9), (1.2, 3.1), (0.8, 3.1)]


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """A state folder in which cam0's floor was kept."""
    scene = Scene(FloorObserver(LAB, "cam0", tmp_path))
    scene.run(1.2)
    scene.observer.save()
    assert background_path(tmp_path, "cam0").is_file()
    return tmp_path


def test_a_pallet_in_view_at_a_restart_is_an_obstacle_at_once(kept: Path) -> None:
    scene = Scene(FloorObserver(LAB, "cam0", kept))
    scene.world.put(pallet(1.0, 3.0))
    first = next(scene.rasters(0.2))
    assert len(first.look(PALLET_BOX).occupied) > 20
    assert first.observed.mean() > 0.85
    scene.world.remove("pallet")
    assert not scene.run(0.5).occupied.any()


def test_a_changed_exposure_at_a_restart_does_not_matter(kept: Path) -> None:
    scene = Scene(FloorObserver(LAB, "cam0", kept))
    scene.gain = 0.8
    first = next(scene.rasters(0.2))
    assert first.observed.mean() > 0.85
    assert not first.occupied.any()


def test_a_restart_in_the_dark_keeps_what_was_learned(kept: Path) -> None:
    scene = Scene(FloorObserver(LAB, "cam0", kept))
    scene.world.put(pallet(1.0, 3.0))
    scene.gain = 0.02
    assert not scene.run(2.0).observed.any()
    scene.observer.save()
    scene.gain = 1.0
    assert scene.run(0.3).look(PALLET_BOX).blocked


def test_floor_that_saturates_is_kept_like_any_other(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    before = Scene(FloorObserver(LAB, "cam0", tmp_path))
    before.gain = 4.0  # much of the floor is white, and learned so
    before.run(1.2)
    before.gain = 3.0  # the same white at less light: beyond the range of a picture when brought to the background's
    before.run(4.0)
    before.observer.save()
    after = Scene(FloorObserver(LAB, "cam0", tmp_path))
    after.gain = 3.0
    after.world.put(pallet(1.0, 3.0))
    assert next(after.rasters(0.2)).observed.mean() > 0.5, "what was learned counts from the first frame on"
    assert "does not fit" not in caplog.text


def test_it_is_kept_by_itself_while_running(tmp_path: Path) -> None:
    scene = Scene(FloorObserver(LAB, "cam0", tmp_path))
    for _ in scene.rasters(11.0):
        pass
    assert background_path(tmp_path, "cam0").is_file()


def test_another_mounting_learns_anew(kept: Path, caplog: pytest.LogCaptureFixture) -> None:
    scene = Scene(FloorObserver(LAB, "cam0", kept))
    x, y, z = scene.extrinsics.translation
    scene.extrinsics = replace(scene.extrinsics, translation=(x + 0.02, y, z))
    with caplog.at_level(logging.WARNING):
        assert not next(scene.rasters(0.2)).observed.any()
    assert "does not fit" in caplog.text
    assert scene.run(1.2).observed.any()


def test_another_floor_learns_anew(kept: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A kept background that most of the view contradicts is not of this floor: blocking all of it helps nobody."""
    path = background_path(kept, "cam0")
    with np.load(path) as stored:
        arrays = {name: np.asarray(stored[name]) for name in stored.files}
    arrays["mean"] = np.random.default_rng(1).uniform(0, 255, arrays["mean"].shape).astype(np.float32)
    np.savez(path, allow_pickle=False, **arrays)
    scene = Scene(FloorObserver(LAB, "cam0", kept))
    with caplog.at_level(logging.WARNING):
        grid = scene.run(1.3)
    assert "learning it anew" in caplog.text
    assert grid.observed.any()
    assert not grid.occupied.any()


def _truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:1000])


def _garbage(path: Path) -> None:
    path.write_bytes(b"not a zip file")


def _empty(path: Path) -> None:
    path.write_bytes(b"")


def _without_mean(path: Path) -> None:
    np.savez(path, version=np.array(1))


def _with_nan(path: Path) -> None:
    with np.load(path) as stored:
        arrays = {name: np.asarray(stored[name]) for name in stored.files}
    arrays["mean"][0, 0] = np.nan
    np.savez(path, allow_pickle=False, **arrays)


def _of_objects(path: Path) -> None:
    np.savez(path, version=np.array(1), mean=np.array([{}], dtype=object), allow_pickle=True)


@pytest.mark.parametrize("damage", [_truncate, _garbage, _empty, _without_mean, _with_nan, _of_objects])
def test_a_damaged_file_is_left_aside(kept: Path, damage: object, caplog: pytest.LogCaptureFixture) -> None:
    assert callable(damage)
    damage(background_path(kept, "cam0"))
    scene = Scene(FloorObserver(LAB, "cam0", kept))
    with caplog.at_level(logging.WARNING):
        assert not next(scene.rasters(0.2)).observed.any()
    assert "learning the floor anew" in caplog.text
    assert scene.run(1.2).observed.any()


def test_a_disk_that_takes_nothing_costs_a_warning(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    blocked = tmp_path / "state"
    blocked.write_text("a file where the folder should be")
    scene = Scene(FloorObserver(LAB, "cam0", blocked))
    scene.run(1.2)
    with caplog.at_level(logging.WARNING):
        scene.observer.save()
    assert "cannot keep the background of cam0" in caplog.text
    assert scene.run(0.2).observed.any()


def test_nothing_is_kept_without_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scene = Scene(FloorObserver(LAB, "cam0"))
    scene.run(1.2)
    scene.observer.save()
    assert list(tmp_path.iterdir()) == []


def levels(tile: FloorTile, x: float, y: float, half_m: float = 0.03) -> NDArray[np.uint8]:
    """The tile's pixels around a point of the map."""
    picture = cv2.imdecode(np.frombuffer(tile.jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    low_x, low_y, high_x, high_y = tile.bounds
    per_x, per_y = picture.shape[1] / (high_x - low_x), picture.shape[0] / (high_y - low_y)
    columns = slice(int((x - half_m - low_x) * per_x), int((x + half_m - low_x) * per_x) + 1)
    rows = slice(int((high_y - y - half_m) * per_y), int((high_y - y + half_m) * per_y) + 1)
    return np.asarray(picture[rows, columns], dtype=np.uint8)


def test_the_picture_shows_the_floor_from_above() -> None:
    scene = Scene(FloorObserver(LAB, "cam0"))
    assert scene.observer.picture() is None
    scene.run(1.2)
    tile = scene.observer.picture()
    assert tile is not None
    assert scene.observer.picture() is None, "once every two seconds"
    # Floor tag 1 is at (0.000, 4.295): white around it, mat beside it; the lane line at y = 3.25 is white, below it is mat.
    assert levels(tile, 0.0, 4.295, 0.1).max() > 150
    assert levels(tile, 0.35, 4.295, 0.1).max() < 110
    assert np.median(levels(tile, 0.35, 4.295, 0.1)) < 80
    low_x, low_y, high_x, high_y = tile.bounds
    assert (low_x, low_y, high_y) == pytest.approx((-0.35, -0.3, 4.6), abs=0.06)
    assert 2.2 < high_x < 2.5


def test_pictures_come_every_two_seconds() -> None:
    scene = Scene(FloorObserver(LAB, "cam0"))
    tiles = 0
    for _ in scene.rasters(9.0):
        tiles += scene.observer.picture() is not None
    assert tiles == 5  # the first one at once


def test_robots_and_obstacles_are_not_in_the_picture() -> None:
    scene = Scene(FloorObserver(LAB, "cam0"))
    bare = Scene(FloorObserver(LAB, "cam0"))
    bare.run(1.2)
    floor = bare.observer.picture()
    assert floor is not None
    scene.world.place("wifibot-14", SE2(1.0, 2.6, 0.0))  # there from the start, gone later
    scene.run(1.5)
    scene.world.place("wifibot-14", SE2(0.5, 1.4, 0.0))
    scene.world.put(SimulatedObject(id="anna", kind="person", x=1.6, y=3.0))
    scene.run(3.0)
    tile = scene.observer.picture()
    assert tile is not None
    for x, y in ((1.0, 2.6), (0.5, 1.4), (1.6, 3.0)):
        difference = np.abs(levels(tile, x, y, 0.1).astype(float) - levels(floor, x, y, 0.1))
        assert difference.mean() < 12, f"something stands in the picture at {x}, {y}"
