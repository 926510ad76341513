"""The scenes' floors: what does not exist is refused by name."""

import pytest

from launcher.manoeuvres.roads import crossing_way, roundabout_way


def test_an_unknown_turn_is_refused() -> None:
    with pytest.raises(ValueError, match="not 'back'"):
        crossing_way("south", "back")


def test_an_unknown_arm_is_refused() -> None:
    with pytest.raises(ValueError, match="up"):
        crossing_way("up", "left")


@pytest.mark.parametrize("exits", [0, 5])
def test_a_roundabout_has_four_exits(exits: int) -> None:
    with pytest.raises(ValueError, match=f"not {exits}"):
        roundabout_way("south", exits)
