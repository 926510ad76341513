"""The frame ring: newest wins, a torn frame never surfaces, a replaced writer is noticed."""

import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from protocol.errors import DecodeError
from protocol.frames import FrameReader, FrameWriter


def image(level: int, height: int = 12, width: int = 16) -> NDArray[np.uint8]:
    return np.full((height, width), level, np.uint8)


@pytest.mark.parametrize("color", [False, True])
def test_a_frame_survives_the_ring(tmp_path: Path, color: bool) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (12, 16, 3) if color else (12, 16)).astype(np.uint8)
    writer = FrameWriter(tmp_path / "cam0", 16, 12, color=color)
    with FrameReader(tmp_path / "cam0") as reader:
        assert reader.shape == pixels.shape
        assert reader.newest() is None
        assert writer.write(pixels, 123) == 1
        frame = reader.newest()
        assert frame is not None
        assert (frame.number, frame.stamp_ns) == (1, 123)
        assert np.array_equal(frame.pixels, pixels)
        assert reader.newest() is None
    writer.close()


@given(st.lists(st.integers(0, 3), max_size=30))
def test_a_reader_gets_the_newest_frame_once(writes_before_each_read: list[int]) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        writer = FrameWriter(Path(folder) / "cam0", 16, 12)
        with FrameReader(Path(folder) / "cam0") as reader:
            number = 0
            for writes in writes_before_each_read:
                for _ in range(writes):
                    number += 1
                    assert writer.write(image(number % 256), 1000 + number) == number
                frame = reader.newest()
                if writes == 0:
                    assert frame is None
                else:
                    assert frame is not None
                    assert (frame.number, frame.stamp_ns) == (number, 1000 + number)
                    assert (frame.pixels == number % 256).all()
        writer.close()


def test_the_pixels_are_a_copy(tmp_path: Path) -> None:
    writer = FrameWriter(tmp_path / "cam0", 16, 12)
    with FrameReader(tmp_path / "cam0") as reader:
        writer.write(image(1), 1)
        frame = reader.newest()
        assert frame is not None
        for level in range(2, 12):
            writer.write(image(level), level)
        assert (frame.pixels == 1).all()
        frame.pixels[...] = 0
    writer.close()


def test_a_torn_frame_never_surfaces(tmp_path: Path) -> None:
    """A writer that does not wait for the reader; each image is of one level, which its stamp tells."""
    height, width, least = 480, 640, 1500
    writer = FrameWriter(tmp_path / "cam0", width, height)
    images = [image(level, height, width) for level in range(251)]
    enough, done = threading.Event(), threading.Event()
    written = 0

    def write() -> None:
        nonlocal written
        while written < least or not enough.is_set():
            written += 1
            writer.write(images[written % 251], written)
        done.set()

    thread = threading.Thread(target=write)
    seen: list[int] = []
    with FrameReader(tmp_path / "cam0") as reader:
        thread.start()
        try:
            while not (done.is_set() and seen[-1] == written):
                frame = reader.newest()
                if frame is not None:
                    assert frame.stamp_ns == frame.number
                    assert frame.pixels.min() == frame.pixels.max() == frame.number % 251, "a torn frame"
                    seen.append(frame.number)
                    if len(seen) > 20:
                        enough.set()
        finally:
            enough.set()
            thread.join()
    assert seen == sorted(set(seen))
    writer.close()


def test_a_slot_that_is_being_written_is_not_read(tmp_path: Path) -> None:
    """The writer died within a frame: its slot's number is odd, and what was newest before stays the newest."""
    path = tmp_path / "cam0"
    writer = FrameWriter(path, 16, 12)
    writer.write(image(7), 1)
    with FrameReader(path) as reader:
        data = bytearray(path.read_bytes())
        first_slot = 4096 + 4096  # number 1 lies in slot 1; a slot of 16 x 12 takes a page
        assert data[first_slot] == 2
        data[first_slot] = 1
        with path.open("r+b") as file:
            file.write(data)
        assert reader.newest() is None
    writer.close()


def test_a_new_writer_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "cam0"
    first = FrameWriter(path, 16, 12)
    with FrameReader(path) as reader:
        assert not reader.replaced()
        second = FrameWriter(path, 32, 24)
        assert reader.replaced()
        first.write(image(1), 1)  # into the old file: harmless
        with FrameReader(path) as newer:
            assert newer.shape == (24, 32)
            second.write(image(2, 24, 32), 2)
            frame = newer.newest()
            assert frame is not None
            assert (frame.pixels == 2).all()
    second.close()
    assert not path.exists()
    assert [entry.name for entry in path.parent.iterdir()] == []


def test_a_writer_that_went_is_noticed(tmp_path: Path) -> None:
    writer = FrameWriter(tmp_path / "cam0", 16, 12)
    with FrameReader(tmp_path / "cam0") as reader:
        writer.close()
        assert reader.replaced()


def test_an_older_writer_that_ends_late_leaves_the_newer_ones_ring(tmp_path: Path) -> None:
    first = FrameWriter(tmp_path / "cam0", 16, 12)
    second = FrameWriter(tmp_path / "cam0", 16, 12)
    first.close()
    with FrameReader(tmp_path / "cam0") as reader:
        second.write(image(3), 3)
        assert reader.newest() is not None
    second.close()


@pytest.mark.parametrize("pixels", [image(1, 12, 17), image(1)[:, :, None], image(1).astype(np.float32)])
def test_an_image_of_another_kind_is_refused(tmp_path: Path, pixels: NDArray[np.uint8]) -> None:
    writer = FrameWriter(tmp_path / "cam0", 16, 12)
    with pytest.raises(ValueError, match=r"uint8 \(12, 16\)"):
        writer.write(pixels, 1)
    assert writer.write(image(1), 1) == 1
    writer.close()


@pytest.mark.parametrize(
    "content", [b"", b"short", b"\0" * 5000, b"LPFRAME1" + b"\xff" * 8000, b"LPFRAME1" + b"\0" * 8000]
)
def test_a_file_that_is_no_ring_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "cam0").write_bytes(content)
    with pytest.raises(DecodeError, match="not a frame ring"):
        FrameReader(tmp_path / "cam0")


def test_a_ring_that_is_not_there_yet(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        FrameReader(tmp_path / "cam0")
