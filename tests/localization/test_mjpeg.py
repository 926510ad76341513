"""Network cameras: the multipart format however it is cut, a camera's own stamps, and a server that misbehaves."""

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from localization.sources import BrokenFrameError, CaptureError, LiveSource, Patience, open_source
from localization.sources.jpeg import decode_jpeg
from localization.sources.mjpeg import MjpegCapture
from localization.sources.multipart import MultipartParser, Part, boundary_of
from localization.sources.remote_clock import RemoteClock
from protocol.clock import SystemClock
from protocol.lab import CameraSpec, Intrinsics
from tests.localization.mjpeg_camera import MjpegCamera, jpeg

WITHIN_S = 15.0
NOWHERE = Path("/nonexistent")
PIXELS = np.add.outer(np.arange(48), 2 * np.arange(64)).astype(np.uint8)
PICTURE = jpeg(PIXELS)
QUICK = Patience(stall_s=0.3, abandon_s=5.0, first_retry_s=0.02, last_retry_s=0.1)
BODIES = [b"\xff\xd8first\xff\xd9", b"\xff\xd8" + bytes(range(256)) + b"\xff\xd9", b"\xff\xd8--fra\r\n\r\n\xff\xd9"]


def spec(source: str, *, color: bool = False) -> CameraSpec:
    lens = Intrinsics(fx=60.0, fy=60.0, cx=32.0, cy=24.0)
    return CameraSpec(
        id="cam", area="a", source=source, width=64, height=48, rate_hz=50.0, color=color, intrinsics=lens
    )


def stream(bodies: list[bytes], *, lengths: bool) -> bytes:
    heads = [b"Content-Length: %d\r\n" % len(body) if lengths else b"" for body in bodies]
    parts = zip(heads, bodies, strict=True)
    return b"".join(b"--frame\r\nContent-Type: image/jpeg\r\n%s\r\n%s\r\n" % part for part in parts)


def fed(data: bytes, cuts: list[int], boundary: str = "frame") -> list[Part]:
    parser, parts = MultipartParser(boundary), list[Part]()
    edges = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    for begin, end in pairwise(edges):
        parts += parser.feed(data[begin:end])
    return parts


@given(st.lists(st.integers(0, 10_000), max_size=20), st.booleans())
def test_parts_are_the_same_however_the_bytes_come(cuts: list[int], lengths: bool) -> None:
    parts = fed(stream(BODIES, lengths=lengths), cuts)
    assert [part.body for part in parts] == BODIES
    assert all(part.whole for part in parts)
    assert parts[0].headers["content-type"] == "image/jpeg"


@given(st.binary(max_size=400), st.lists(st.integers(0, 10_000), max_size=5))
def test_garbage_costs_no_more_than_the_next_part(garbage: bytes, cuts: list[int]) -> None:
    data = garbage + b"\r\n" + stream(BODIES * 3, lengths=True)
    whole = [part.body for part in fed(data, cuts) if part.whole]
    assert whole[-8:] == (BODIES * 3)[-8:]


def test_a_part_is_there_with_its_last_byte() -> None:
    for lengths in (True, False):
        parser = MultipartParser("frame")
        data = stream(BODIES[:1], lengths=lengths).removesuffix(b"\r\n")
        assert list(parser.feed(data[:-1])) == []
        assert parser.in_part
        (part,) = parser.feed(data[-1:])
        assert part.body == BODIES[0]


def test_a_part_that_the_next_one_cuts_off_is_not_whole() -> None:
    cut = b"--frame\r\nContent-Length: 500\r\n\r\n\xff\xd8half\r\n"
    parts = fed(cut + stream(BODIES, lengths=True), [])
    assert [part.whole for part in parts] == [False, True, True, True]
    assert parts[0].body == b"\xff\xd8half"


def test_lengths_that_are_always_wrong_are_no_longer_believed() -> None:
    lying = b"".join(b"--frame\r\nContent-Length: 5\r\n\r\n%s\r\n" % BODIES[1] for _ in range(20))
    whole = [part.body for part in fed(lying, []) if part.whole]
    assert whole[-10:] == [BODIES[1]] * 10


@pytest.mark.parametrize(
    ("header", "boundary"),
    [
        ("multipart/x-mixed-replace; boundary=frame", "frame"),
        ('multipart/x-mixed-replace;boundary="--my bound"', "my bound"),
        ("Multipart/X-Mixed-Replace; charset=x; BOUNDARY=--b", "b"),
        ("multipart/x-mixed-replace", None),
        ("image/jpeg; boundary=frame", None),
        ("", None),
    ],
)
def test_boundaries_as_cameras_announce_them(header: str, boundary: str | None) -> None:
    assert boundary_of(header) == boundary


def test_pictures_are_decoded_grey_or_in_colour_and_bad_ones_refused() -> None:
    assert decode_jpeg(PICTURE, color=False).shape == (48, 64)
    assert decode_jpeg(PICTURE, color=True).shape == (48, 64, 3)
    assert float(np.abs(decode_jpeg(PICTURE, color=False).astype(int) - PIXELS).max()) < 8
    for bad in (b"", b"\xff\xd8", PICTURE[: len(PICTURE) // 2], b"x" + PICTURE, PICTURE[:-2]):
        with pytest.raises(BrokenFrameError):
            decode_jpeg(bad, color=False)


def test_a_clock_that_agrees_is_believed_and_one_that_does_not_is_mapped() -> None:
    agreeing, second = RemoteClock(), 10**9
    assert agreeing.local_ns(100 * second, 100 * second + 30_000_000) == 100 * second
    rng = np.random.default_rng(1)
    for off_ns in (-3600 * second, -7 * second, 90 * second):
        clock, period_ns = RemoteClock(), 20_000_000
        errors = list[int]()
        for number in range(500):
            captured_ns = 10_000 * second + number * period_ns
            arrived_ns = captured_ns + 4_000_000 + int(rng.exponential(5e6))
            errors.append(clock.local_ns(captured_ns + off_ns, arrived_ns) - captured_ns)
        assert min(errors[50:]) >= 4_000_000, "the least lateness stays unknown"
        assert max(errors[50:]) < 4_800_000, "the rest of it is gone"


@contextmanager
def camera(
    *, user: str | None = None, schemes: tuple[Literal["Basic", "Digest"], ...] = ("Basic",)
) -> Generator[MjpegCamera]:
    made = MjpegCamera(PICTURE, user=user, schemes=schemes)
    try:
        yield made
    finally:
        made.close()


@contextmanager
def watched(made: MjpegCamera) -> Generator[LiveSource]:
    source = open_source(spec(made.url), NOWHERE, SystemClock(), QUICK)
    try:
        yield source
    finally:
        source.close()


def eventually(condition: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + WITHIN_S
    while not condition():
        assert time.monotonic() < deadline, f"not within {WITHIN_S} s: {what}"
        time.sleep(0.005)


@pytest.mark.parametrize("mood", ["garbage", "truncated", "between", "breaking off"])
def test_what_is_no_picture_is_counted_and_the_next_one_is_fine(mood: str) -> None:
    with camera() as made, watched(made) as source:
        eventually(lambda: source.newest(0.1), "a frame")
        made.mood = mood  # pyright: ignore[reportAttributeAccessIssue]  # one of them
        counted = (lambda: made.connections > 2) if mood == "breaking off" else (lambda: source.state.broken > 3)
        eventually(counted, "trouble")
        made.mood = "well"
        eventually(lambda: source.newest(0.1) and source.state.error is None, "recovery")


def test_a_camera_that_hangs_within_a_picture_is_reported_and_opened_again() -> None:
    with camera() as made, watched(made) as source:
        eventually(lambda: source.newest(0.1), "a frame")
        before_ns = time.time_ns()
        made.mood = "hanging"
        eventually(lambda: (source.state.error or "").startswith("no frame for"), "the stall")
        since_ns = source.state.error_since_ns
        assert since_ns is not None
        assert abs(since_ns - before_ns) < 2e9, "not when it was noticed, 3 s later"
        eventually(lambda: source.state.error == f"{made.url} has sent nothing for 3 s", "the silence")
        assert source.state.error_since_ns == since_ns, "still the same trouble"
        made.mood = "well"
        eventually(lambda: source.newest(0.1) and source.state.error is None, "recovery")
        assert source.state.error_since_ns is None


def test_pictures_without_a_length_come_at_once() -> None:
    with camera() as made:
        made.mood = "no lengths"
        made.rate_hz = 0.4
        capture = MjpegCapture(made.url, spec(made.url), SystemClock())
        try:
            frame = next(frame for _ in range(60) if (frame := capture.read()) is not None)
            assert time.time_ns() - frame.stamp_ns < 2e9, "not held back for the next one, 2.5 s later"
            assert frame.pixels.shape == (48, 64)
            assert frame.decode_ms > 0.0
        finally:
            capture.close()


@pytest.mark.parametrize("off_s", [0.0, 5000.0])
def test_the_cameras_own_stamps_are_kept(off_s: float) -> None:
    with camera() as made:
        made.stamp = lambda: f"{time.time() + off_s:.6f}"
        capture = MjpegCapture(made.url, spec(made.url), SystemClock())
        try:
            frames = [frame for _ in range(10) if (frame := capture.read()) is not None]
            assert abs(time.time_ns() - frames[-1].stamp_ns) < 1e9
        finally:
            capture.close()


@pytest.mark.parametrize(
    "stamp",
    [lambda: str(int(time.time())), lambda: "1.5", lambda: "1e300", lambda: "inf", lambda: "nan", lambda: "now"],
)
def test_stamps_that_tell_no_time_are_replaced_by_the_arrival(
    stamp: Callable[[], str], caplog: pytest.LogCaptureFixture
) -> None:
    with camera() as made:
        made.stamp = stamp
        capture = MjpegCapture(made.url, spec(made.url), SystemClock())
        try:
            frames = [frame for _ in range(30) if (frame := capture.read()) is not None]
        finally:
            capture.close()
    stamps = [frame.stamp_ns for frame in frames]
    assert all(before <= after for before, after in pairwise(stamps))
    assert len(set(stamps)) > len(stamps) / 2, "but for pictures that come in one piece, each has a time of its own"
    assert 0 <= time.time_ns() - stamps[-1] < 5e9
    assert caplog.text.count("are stamped on arrival") <= 1


@pytest.mark.parametrize("schemes", [("Basic",), ("Digest",), ("Basic", "Digest")])
def test_credentials_are_given_when_asked_for_and_never_shown(schemes: tuple[Literal["Basic", "Digest"], ...]) -> None:
    with camera(user="me:se%20cret", schemes=schemes) as made:
        capture = MjpegCapture(made.url, spec(made.url), SystemClock())
        try:
            assert capture.read() is not None
        finally:
            capture.close()
        assert made.told[0] is None, "nobody asked yet"
        said = [text.split()[0] for text in made.told if text is not None]
        assert said == ["Digest" if "Digest" in schemes else "Basic"]
        made.mood = "absent"
        with pytest.raises(CaptureError, match="it answers 503") as caught:
            MjpegCapture(made.url, spec(made.url), SystemClock())
        assert "se%20cret" not in str(caught.value)


def test_a_wrong_password_is_one_clear_refusal() -> None:
    with camera(user="me:right", schemes=("Basic", "Digest")) as made:
        url = made.url.replace("right", "wrong")
        with pytest.raises(CaptureError, match="cannot be opened: it answers 401 Unauthorized"):
            MjpegCapture(url, spec(url), SystemClock())
        assert not any(text is not None and text.startswith("Basic") for text in made.told)


def test_a_page_instead_of_pictures_is_named() -> None:
    with camera() as made:
        made.mood = "html"
        source = open_source(spec(made.url), NOWHERE, SystemClock(), QUICK)
        expected = f"{made.url} answers with text/html, not with an MJPEG stream"
        eventually(lambda: source.state.error == expected, expected)
        source.close()
