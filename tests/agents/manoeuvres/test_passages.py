"""Which sub-areas a body sweeps, and from where to where."""

import hypothesis.strategies as st
import numpy as np
import pytest
import shapely
from hypothesis import given, settings

from agents.manoeuvres.passages import Use, Way, passages_of, uses_of
from launcher.manoeuvres.roads import ARMS, crossing_way, crossing_zone
from launcher.manoeuvres.scenario import WIFIBOT

MARGIN_M = 0.05
TURNS = ("right", "straight", "left")


def areas(arm: str, turn: str) -> list[str]:
    uses = uses_of(Way(crossing_way(arm, turn)), WIFIBOT, [crossing_zone()], MARGIN_M)
    return [use.area.removeprefix("crossing/") for use in uses]


def test_straight_on_takes_the_two_sub_areas_of_the_lane() -> None:
    assert areas("south", "straight") == ["se", "ne"]
    assert areas("west", "straight") == ["sw", "se"]


def test_a_right_turn_keeps_to_its_side_and_a_left_turn_does_not() -> None:
    assert areas("south", "right")[0] == "se"
    assert not {"sw", "nw"} & set(areas("south", "right"))
    assert {"se", "nw"} < set(areas("south", "left"))


def test_distances_are_where_the_grown_body_meets_the_area() -> None:
    uses = uses_of(Way([(0.25, -4.0), (0.25, 4.0)]), WIFIBOT, [crossing_zone()], MARGIN_M)
    # The zone begins 0.5 m before the middle; the front is 0.15 m before the rotation centre.
    assert uses[0].enter_m == pytest.approx(4.0 - 0.5 - 0.15 - MARGIN_M, abs=0.002)
    assert uses[0].exit_m == pytest.approx(4.0 + 0.15 + MARGIN_M, abs=0.002)


def test_a_way_that_comes_back_uses_an_area_twice() -> None:
    there_and_back = Way([(0.25, -2.0), (0.25, 2.0), (0.25, -2.0)])
    assert [use.area for use in uses_of(there_and_back, WIFIBOT, [crossing_zone()], MARGIN_M)].count("crossing/se") == 2


@settings(max_examples=40, deadline=None)
@given(arm=st.sampled_from(ARMS), turn=st.sampled_from(TURNS), share=st.floats(0.0, 1.0))
def test_the_body_is_in_no_area_outside_its_uses(arm: str, turn: str, share: float) -> None:
    way, zone = Way(crossing_way(arm, turn)), crossing_zone()
    uses = uses_of(way, WIFIBOT, [zone], MARGIN_M)
    at_m = share * way.length_m
    body = shapely.Polygon(way.at(at_m).apply(WIFIBOT)).buffer(MARGIN_M - 0.002, join_style="mitre")
    for name, outline in zone.subareas.items():
        if body.intersects(shapely.Polygon(outline)):
            assert any(use.area == f"crossing/{name}" and use.enter_m <= at_m <= use.exit_m for use in uses)


def test_uses_without_room_to_stand_between_them_are_booked_together() -> None:
    uses = [Use("z", "z/a", 1.0, 2.0), Use("z", "z/b", 1.5, 3.0), Use("y", "y/a", 3.3, 4.0), Use("y", "y/b", 5.0, 6.0)]
    passages = passages_of(uses, standing_m=0.5)
    assert [[use.area for use in passage.uses] for passage in passages] == [["z/a", "z/b", "y/a"], ["y/b"]]
    assert passages[0].zones == {"z", "y"}
    assert (passages[0].enter_m, passages[0].exit_m) == (1.0, 4.0)


def test_a_way_of_one_point_is_refused() -> None:
    with pytest.raises(ValueError, match="two different points"):
        Way([(1.0, 1.0), (1.0, 1.0)])


def test_a_way_goes_straight_on_beyond_its_ends() -> None:
    way = Way([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
    assert (way.at(-0.5).x, way.at(-0.5).y) == pytest.approx((-0.5, 0.0))
    assert (way.at(2.5).x, way.at(2.5).y) == pytest.approx((1.0, 1.5))
    assert np.allclose(way.poses(np.array([0.5, 1.5]))[:, :2], [[0.5, 0.0], [1.0, 0.5]])
