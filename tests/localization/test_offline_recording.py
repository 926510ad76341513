"""Recordings as people bring them: both kinds, incomplete, untidy, broken; what is wrong is named."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from localization.offline import RecordingError, open_recording
from localization.offline.instants import RecordedFrame, instants
from protocol.lab import Lab, parse_lab

WIDTH, HEIGHT = 64, 48
EPOCH_NS = 1_700_000_000_000_000_000
LAB = """
name: tiny
areas: [{id: room, outline: [[0, 0], [4, 0], [4, 4], [0, 4]]}]
cameras:
  - &camera {id: a, area: room, source: 0, width: 64, height: 48, rate_hz: 60,
             intrinsics: {fx: 50, fy: 50, cx: 31.5, cy: 23.5}}
  - {<<: *camera, id: b, source: sim}
floor_tags: {size_m: 0.16, poses: {0: [0, 0, 0]}}
"""


@pytest.fixture
def lab() -> Lab:
    return parse_lab(LAB, recorded=True)


def picture(level: int, size: tuple[int, int] = (HEIGHT, WIDTH)) -> NDArray[np.uint8]:
    return np.full(size, level, np.uint8)


def write_pictures(folder: Path, levels: dict[int, int], suffix: str = ".png") -> None:
    """Plain pictures: capture time -> grey level."""
    folder.mkdir(parents=True, exist_ok=True)
    for stamp_ns, level in levels.items():
        assert cv2.imwrite(str(folder / f"{stamp_ns}{suffix}"), picture(level))


def write_video(file: Path, levels: list[int], rate_hz: float = 10.0) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    codec = cv2.VideoWriter.fourcc(*"MJPG")
    writer = cv2.VideoWriter(str(file), codec, rate_hz, (WIDTH, HEIGHT), False)
    for level in levels:
        writer.write(picture(level))
    writer.release()


def played(path: Path, lab: Lab, threads: int = 2) -> Iterator[list[RecordedFrame]]:
    with ThreadPoolExecutor(threads) as executor:
        yield from instants(open_recording(path, lab).cameras, executor)


def seen(path: Path, lab: Lab, camera: str) -> list[tuple[int, int]]:
    """Capture time and grey level of a camera's good frames, in the order in which they come."""
    frames = [item for instant in played(path, lab) for item in instant if item.camera == camera]
    return [(item.stamp_ns, round(float(item.frame.pixels.mean()))) for item in frames if item.frame is not None]


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".pgm"])
def test_pictures_come_in_the_order_of_their_times_whatever_their_names_look_like(
    tmp_path: Path, lab: Lab, suffix: str
) -> None:
    write_pictures(tmp_path / "a", {1000: 30, 5: 10, 200: 20}, suffix)
    assert seen(tmp_path, lab, "a") == [(5, 10), (200, 20), (1000, 30)]


def test_colour_is_made_grey(tmp_path: Path, lab: Lab) -> None:
    (tmp_path / "a").mkdir()
    cv2.imwrite(str(tmp_path / "a/7.png"), np.full((HEIGHT, WIDTH, 3), (0, 0, 200), np.uint8))
    ((stamp_ns, level),) = seen(tmp_path, lab, "a")
    assert stamp_ns == 7
    assert level == pytest.approx(0.299 * 200, abs=1)


@pytest.mark.parametrize("stamps_name", ["a.stamps", "a.avi.stamps"])
def test_a_video_has_the_capture_times_beside_it(tmp_path: Path, lab: Lab, stamps_name: str) -> None:
    write_video(tmp_path / "a.avi", [40, 80, 120])
    (tmp_path / stamps_name).write_text(f"{EPOCH_NS}\n{EPOCH_NS + 7}\n{EPOCH_NS + 50}\n")
    assert [stamp for stamp, _ in seen(tmp_path, lab, "a")] == [EPOCH_NS, EPOCH_NS + 7, EPOCH_NS + 50]
    assert [level for _, level in seen(tmp_path, lab, "a")] == pytest.approx([40, 80, 120], abs=2)
    assert not [warning for warning in open_recording(tmp_path, lab).warnings if "a.avi" in warning]


def test_a_video_without_stamps_is_as_fast_as_it_says_and_begins_with_the_others(tmp_path: Path, lab: Lab) -> None:
    write_video(tmp_path / "a.avi", [40, 80], rate_hz=4.0)
    write_pictures(tmp_path / "b", {EPOCH_NS: 1, EPOCH_NS + 10: 2})
    recording = open_recording(tmp_path, lab)
    assert "taken at 4 frames per second" in recording.warnings[0]
    assert "a: assumed to begin together" in recording.warnings[1]
    assert [stamp for stamp, _ in seen(tmp_path, lab, "a")] == [EPOCH_NS, EPOCH_NS + 250_000_000]


def test_frames_whose_stamps_go_backwards_are_left_out_and_the_others_keep_theirs(tmp_path: Path, lab: Lab) -> None:
    write_video(tmp_path / "a.avi", [40, 80, 120, 160])
    (tmp_path / "a.stamps").write_text("100 300 200 400")
    levels = seen(tmp_path, lab, "a")
    assert [stamp for stamp, _ in levels] == [100, 300, 400]
    assert [level for _, level in levels] == pytest.approx([40, 80, 160], abs=2)
    assert "1 frames ignored, their stamps go backwards" in " ".join(open_recording(tmp_path, lab).warnings)


@pytest.mark.parametrize(("stamps", "frames"), [("1 2", 2), ("1 2 3 4 5", 3)])
def test_more_stamps_than_frames_or_fewer_are_told(tmp_path: Path, lab: Lab, stamps: str, frames: int) -> None:
    write_video(tmp_path / "a.avi", [40, 80, 120])
    (tmp_path / "a.stamps").write_text(stamps)
    assert len(seen(tmp_path, lab, "a")) == frames
    told = f"3 frames and {len(stamps.split())} stamps"
    assert any(told in warning for warning in open_recording(tmp_path, lab).warnings)


def test_a_missing_camera_and_strangers_are_told_and_do_no_harm(tmp_path: Path, lab: Lab) -> None:
    write_pictures(tmp_path / "b", {1: 10})
    write_pictures(tmp_path / "attic", {1: 10})
    write_pictures(tmp_path / ".cache", {1: 10})
    (tmp_path / "b/readme.txt").write_text("pictures of the room")
    cv2.imwrite(str(tmp_path / "b/thumbnail.png"), picture(3))
    recording = open_recording(tmp_path, lab)
    assert [camera.spec.id for camera in recording.cameras] == ["b"]
    assert recording.warnings == (
        "a is not in the recording",
        f"{tmp_path / 'b'}: 1 pictures ignored whose names are no capture time in nanoseconds of their own",
        "not cameras of this lab, ignored: attic",
    )


def test_a_broken_picture_costs_itself_only(tmp_path: Path, lab: Lab) -> None:
    write_pictures(tmp_path / "a", {1: 10, 3: 30})
    (tmp_path / "a/2.png").write_bytes(b"\x89PNG no")
    (tmp_path / "a/4.png").write_bytes(b"")
    assert seen(tmp_path, lab, "a") == [(1, 10), (3, 30)]
    broken = [item for instant in played(tmp_path, lab) for item in instant if item.frame is None]
    assert [item.stamp_ns for item in broken] == [2, 4]
    assert str(tmp_path / "a/2.png") in broken[0].problem


def test_a_frame_of_another_size_is_named(tmp_path: Path, lab: Lab) -> None:
    write_pictures(tmp_path / "a", {1: 10})
    cv2.imwrite(str(tmp_path / "a/2.png"), picture(10, (30, 40)))
    with pytest.raises(RecordingError, match=r"2\.png is 40 x 30, the lab description of a says 64 x 48"):
        list(played(tmp_path, lab))


def test_what_cannot_be_a_recording_is_refused_in_one_sentence(tmp_path: Path, lab: Lab) -> None:
    with pytest.raises(RecordingError, match="does not exist"):
        open_recording(tmp_path / "nowhere", lab)
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot be read as a recording's folder"):
        open_recording(tmp_path / "file", lab)
    (tmp_path / "empty").mkdir()
    with pytest.raises(RecordingError, match=r"holds no frames of a camera of this lab.* a, b; found nothing"):
        open_recording(tmp_path / "empty", lab)
    (tmp_path / "unnamed/a").mkdir(parents=True)
    cv2.imwrite(str(tmp_path / "unnamed/a/frame1.png"), picture(3))
    with pytest.raises(RecordingError, match="a holds no pictures named by their capture time"):
        open_recording(tmp_path / "unnamed", lab)
    (tmp_path / "garbage").mkdir()
    (tmp_path / "garbage/a.avi").write_bytes(b"no video")
    with pytest.raises(RecordingError, match=r"a\.avi cannot be opened as a video"):
        open_recording(tmp_path / "garbage", lab)
    write_video(tmp_path / "words/a.avi", [1])
    (tmp_path / "words/a.stamps").write_text("soon")
    with pytest.raises(RecordingError, match="one capture time in ns per line, not 'soon'"):
        open_recording(tmp_path / "words", lab)
    write_pictures(tmp_path / "twice/a", {1: 1})
    write_video(tmp_path / "twice/a.avi", [1])
    with pytest.raises(RecordingError, match=r"has a more than once: a, a\.avi"):
        open_recording(tmp_path / "twice", lab)


@pytest.mark.parametrize("threads", [1, 3])
def test_cameras_are_merged_by_capture_time(tmp_path: Path, lab: Lab, threads: int) -> None:
    """Different beginnings, numbers and jitter; equal stamps stay together, and no camera is twice in an instant."""
    rng = np.random.default_rng(5)
    of_a = sorted({int(v) for v in rng.integers(0, 40, 25)})
    of_b = sorted({int(v) for v in rng.integers(20, 60, 25)})
    write_pictures(tmp_path / "a", {stamp: stamp for stamp in of_a})
    write_pictures(tmp_path / "b", {stamp: stamp for stamp in of_b})
    groups = [[(item.stamp_ns, item.camera) for item in instant] for instant in played(tmp_path, lab, threads)]
    flat = [item for group in groups for item in group]
    assert flat == sorted([*((stamp, "a") for stamp in of_a), *((stamp, "b") for stamp in of_b)])
    assert all(len({camera for _, camera in group}) == len(group) for group in groups)
    first_of_group = [group[0][0] for group in groups]
    last_of_group = [group[-1][0] for group in groups]
    assert all(last < first for last, first in zip(last_of_group, first_of_group[1:], strict=False))


def test_reading_ends_cleanly_when_nobody_wants_the_rest(tmp_path: Path, lab: Lab) -> None:
    write_pictures(tmp_path / "a", dict.fromkeys(range(20), 1))
    with ThreadPoolExecutor(2) as executor:
        frames = instants(open_recording(tmp_path, lab).cameras, executor)
        assert next(iter(frames))[0].stamp_ns == 0
        frames.close()
        assert list(frames) == []
