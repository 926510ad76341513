"""The ring between a reader and its user: the newest wins, who puts never waits."""

import threading
import time

import numpy as np
import pytest

from localization.sources import FrameRing
from protocol.frames import Frame

PIXELS = np.zeros((2, 2), np.uint8)


def frame(number: int) -> Frame:
    return Frame(number, number, PIXELS)


def test_the_newest_is_taken_and_older_ones_are_skipped() -> None:
    ring = FrameRing(4)
    for number in range(10):
        ring.put(frame(number))
    taken = ring.newest(0.0)
    assert taken is not None
    assert (taken.number, ring.skipped) == (9, 9)
    assert ring.newest(0.0) is None


def test_who_wants_every_frame_gets_them_in_order_as_long_as_the_ring_holds_them() -> None:
    ring = FrameRing(4)
    for number in range(6):
        ring.put(frame(number))
    taken = [kept.number for _ in range(4) if (kept := ring.oldest(0.0)) is not None]
    assert (taken, ring.skipped) == ([2, 3, 4, 5], 2)
    assert ring.oldest(0.0) is None


def test_a_consumer_that_sleeps_never_holds_the_producer_up() -> None:
    ring = FrameRing(2)
    start = time.perf_counter()
    for number in range(10_000):
        ring.put(frame(number))
    assert time.perf_counter() - start < 2.0
    assert ring.skipped == 9_998


def test_waiting_ends_with_a_frame_or_with_the_ring() -> None:
    ring, taken, first = FrameRing(2), list[Frame | None](), threading.Event()

    def wait() -> None:
        taken.append(ring.newest(20.0))
        first.set()
        taken.append(ring.newest(20.0))

    waiting = threading.Thread(target=wait)
    waiting.start()
    ring.put(frame(1))
    assert first.wait(10.0)
    ring.close()
    waiting.join(10.0)
    assert [None if item is None else item.number for item in taken] == [1, None]


def test_a_ring_needs_a_slot() -> None:
    with pytest.raises(ValueError, match="needs a slot, not 0"):
        FrameRing(0)
