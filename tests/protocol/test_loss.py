"""How much of a numbered sequence arrives."""

import pytest

from protocol.loss import LossWatch


def test_the_share_is_of_what_was_numbered_in_the_last_seconds() -> None:
    watch = LossWatch(window_s=5.0)
    assert watch.share(0.0) is None
    for number in range(0, 100, 2):
        watch.add(number, number * 0.1)
    assert watch.share(9.9) == pytest.approx(0.5, abs=0.05)
    for number in range(100, 200):
        watch.add(number, number * 0.1)
    assert watch.share(20.0) == 0.0
    assert watch.share(60.0) is None, "nothing is known of a link that is silent"


def test_late_and_doubled_ones_change_nothing_and_a_smaller_number_begins_anew() -> None:
    watch = LossWatch()
    for number in (1, 2, 2, 4):
        watch.add(number, 0.1 * number)
    assert watch.share(0.5) == pytest.approx(0.25)
    watch.add(1, 0.6)
    assert watch.share(0.6) is None
    watch.add(2, 0.7)
    assert watch.share(0.7) == 0.0
