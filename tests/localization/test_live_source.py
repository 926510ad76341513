"""A source whose device misbehaves: hangs, sends garbage, breaks down, surprises."""

import queue
import threading
import time
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import pytest

from localization.sources import BrokenFrameError, CaptureError, LiveSource, Patience
from protocol.clock import SystemClock
from protocol.frames import Frame
from protocol.lab import CameraSpec, Intrinsics

SPEC = CameraSpec(
    id="cam",
    area="a",
    source=0,
    width=8,
    height=6,
    rate_hz=50.0,
    color=True,
    intrinsics=Intrinsics(fx=8, fy=8, cx=4, cy=3),
)
PATIENCE = Patience(stall_s=0.1, abandon_s=0.4, first_retry_s=0.01, last_retry_s=0.05)
WITHIN_S = 10.0


class FakeDevice:
    """Gives what is put into it: frames, errors to raise, or events to hang on."""

    def __init__(self) -> None:
        self.todo: queue.Queue[Frame | Exception | threading.Event] = queue.Queue()
        self.opened = self.closed = 0

    def open(self) -> "FakeDevice":
        self.opened += 1
        return self

    def read(self) -> Frame | None:
        try:
            item = self.todo.get(timeout=0.02)
        except queue.Empty:
            return None
        if isinstance(item, threading.Event):
            item.wait(WITHIN_S)
            return None
        if isinstance(item, Exception):
            raise item
        return item

    def close(self) -> None:
        self.closed += 1


def good(number: int) -> Frame:
    return Frame(number, number, np.zeros((6, 8, 3), np.uint8))


def eventually(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + WITHIN_S
    while not condition():
        assert time.monotonic() < deadline, f"not within {WITHIN_S} s: {what}"
        time.sleep(0.002)


@pytest.fixture
def device() -> FakeDevice:
    return FakeDevice()


@pytest.fixture
def source(device: FakeDevice) -> Iterator[LiveSource]:
    made = LiveSource(SPEC, device.open, SystemClock(), PATIENCE)
    yield made
    made.close()


def give(source: LiveSource, device: FakeDevice, number: int) -> None:
    device.todo.put(good(number))
    frame = source.newest(WITHIN_S)
    assert frame is not None
    assert frame.number == number


def test_a_device_that_hangs_holds_nobody_up_and_is_opened_again(source: LiveSource, device: FakeDevice) -> None:
    give(source, device, 1)
    hanging = threading.Event()
    device.todo.put(hanging)
    start = time.monotonic()
    assert source.newest(0.05) is None
    assert time.monotonic() - start < WITHIN_S / 2, "it hangs for twice as long"
    eventually(lambda: (source.state.error or "").startswith("no frame for"), "the stall is reported")
    assert not source.state.connected
    eventually(lambda: source.newest(0.01) is None and device.opened == 2, "it is opened again")
    give(source, device, 2)
    assert source.state.error is None
    hanging.set()
    eventually(lambda: device.closed == 1, "the reader that hung lets its device go")
    give(source, device, 3)


def test_a_device_that_hangs_again_and_again_does_not_eat_threads(source: LiveSource, device: FakeDevice) -> None:
    give(source, device, 1)
    hanging = threading.Event()
    for _ in range(20):
        device.todo.put(hanging)
    eventually(lambda: source.newest(0.01) is None and device.opened == 4, "several attempts")
    deadline = time.monotonic() + 1.0
    while time.monotonic() < deadline:
        assert source.newest(0.02) is None
    assert device.opened == 4
    assert "hangs" in (source.state.error or "")
    hanging.set()


@pytest.mark.parametrize(
    "shape", [(6, 8, 4), (6, 8, 1), (5, 8, 3), (48,), (6, 8, 3, 1)], ids=["bgra", "one", "short", "flat", "deep"]
)
def test_a_frame_of_another_shape_is_broken(source: LiveSource, device: FakeDevice, shape: tuple[int, ...]) -> None:
    device.todo.put(Frame(1, 1, np.zeros(shape, np.uint8)))
    eventually(lambda: source.state.broken == 1, "it is counted")
    assert (source.state.error or "").startswith("a frame is ")
    give(source, device, 2)
    assert source.state.error is None


def test_broken_frames_are_counted_and_the_device_stays_open(source: LiveSource, device: FakeDevice) -> None:
    for _ in range(3):
        device.todo.put(BrokenFrameError("cannot be decoded"))
    give(source, device, 1)
    assert (source.state.broken, source.state.received, device.opened) == (3, 1, 1)


@pytest.mark.parametrize("error", [CaptureError("unplugged"), RuntimeError("a driver's surprise")])
def test_what_fails_is_closed_and_opened_again(source: LiveSource, device: FakeDevice, error: Exception) -> None:
    give(source, device, 1)
    device.todo.put(error)
    eventually(lambda: str(error) in (source.state.error or ""), "the error is reported")
    assert not source.state.connected
    give(source, device, 2)
    assert (device.opened, device.closed) == (2, 1)


def test_pauses_between_attempts_grow() -> None:
    attempts: list[float] = []

    def refusing() -> FakeDevice:
        attempts.append(time.monotonic())
        raise CaptureError("nobody there")

    source = LiveSource(SPEC, refusing, SystemClock(), Patience(0.1, 9.0, first_retry_s=0.02, last_retry_s=0.16))
    eventually(lambda: len(attempts) >= 6, "attempts")
    source.close()
    gaps = [b - a for a, b in pairwise(attempts)]
    assert gaps[0] >= 0.02
    assert gaps[4] >= 0.16


def test_a_device_that_takes_long_to_refuse_does_not_hang() -> None:
    """Attempt and pause together are longer than the silence after which a reader is given up; neither is alone."""
    attempts: list[threading.Thread] = []

    def refusing() -> FakeDevice:
        attempts.append(threading.current_thread())
        threading.Event().wait(0.9)
        raise CaptureError("nobody there")

    source = LiveSource(SPEC, refusing, SystemClock(), Patience(0.1, 1.6, first_retry_s=0.9, last_retry_s=0.9))
    while len(attempts) < 3:
        assert source.newest(0.01) is None
        assert "hangs" not in (source.state.error or "")
    source.close()
    assert len(set(attempts)) == 1, "one reader made all of them"
