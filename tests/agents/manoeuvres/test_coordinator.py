"""A robot alone before a zone: what it says, where it stops, and what it does when the cameras or its neighbours fall silent."""

import math

import pytest

from agents.manoeuvres.approach import Mobility
from agents.manoeuvres.coordinator import Advice, Coordinator
from agents.manoeuvres.passages import Way
from agents.manoeuvres.traffic import Sighting, ZoneMap
from geometry import SE2
from launcher.manoeuvres.roads import crossing_way, crossing_zone
from launcher.manoeuvres.scenario import WIFIBOT
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages.zones import ZoneMessage, ZoneMessageType

BEFORE_M = 2.5
"""On the way from the south, 0.8 m before the zone."""
WAITING = Sighting(SE2(1.0, 0.25, math.pi), 0.0, WIFIBOT)
"""Another vehicle on the east arm, near the zone and outside it."""


def coordinator() -> Coordinator:
    made = Coordinator("r1", 1, WIFIBOT, ZoneMap([crossing_zone()]), Mobility(0.3, 0.5, 3.0, 0.1))
    made.drive(Way(crossing_way("south", "straight")))
    return made


def step(one: Coordinator, at_m: float, seen: dict[str, Sighting], sight_age_s: float = 0.0) -> Advice:
    return one.step(1_000_000_000, 1.0, at_m, 0.3, seen, sight_age_s=sight_age_s)


def test_alone_it_books_and_drives_on() -> None:
    advice = step(coordinator(), BEFORE_M, {})
    assert advice.hold is None
    assert advice.speed_mps == 0.3
    assert advice.message.type is ZoneMessageType.ENTER
    assert [use.area for use in advice.message.claims[0].areas] == ["crossing/se", "crossing/ne"]


def test_it_stops_before_the_zone_while_one_near_it_has_said_nothing() -> None:
    one = coordinator()
    assert step(one, BEFORE_M, {"r2": WAITING}).recipients == {"r2"}
    advice = step(one, 3.27, {"r2": WAITING})
    assert advice.speed_mps < 0.1
    assert str(advice.hold) == "crossing/se: not all have agreed yet (r2)"


def test_it_stops_before_the_zone_while_the_cameras_are_not_heard() -> None:
    one = coordinator()
    advice = step(one, 3.27, {}, sight_age_s=0.6)
    assert advice.speed_mps < 0.1
    assert str(advice.hold) == "crossing/se: the cameras have not been heard"


def test_it_does_not_enter_an_area_in_which_somebody_is_seen() -> None:
    one = coordinator()
    step(one, BEFORE_M, {})
    advice = step(one, 3.27, {"stranger": Sighting(SE2(0.25, -0.25, 0.0), 0.0, WIFIBOT)})
    assert advice.speed_mps < 0.1
    assert advice.hold is not None
    assert advice.hold.robots == ("stranger",)


def test_a_mind_that_begins_anew_inside_says_so_with_its_first_word() -> None:
    advice = step(coordinator(), 3.9, {})
    assert {use.area: use.inside for use in advice.message.claims[0].areas} == {
        "crossing/se": True,
        "crossing/ne": True,
    }


def test_a_step_without_a_way_is_refused() -> None:
    made = Coordinator("r1", 1, WIFIBOT, ZoneMap([crossing_zone()]), Mobility(0.3, 0.5, 3.0, 0.1))
    with pytest.raises(ValueError, match="no way was given"):
        step(made, 0.0, {})


def test_a_message_comes_back_as_it_was_said() -> None:
    message = step(coordinator(), BEFORE_M, {}).message
    assert decode(ZoneMessage, encode(message)) == message


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ('"type":"HB"', '"type":"PARK"'),
        ('"robot":"r1"', '"robot":"R 1"'),
        ('"boot":1', '"boot":"1"'),
        ('"rank":', '"rang":'),
        ('"enter_s":', '"enter_s":1e12,"was":'),
    ],
)
def test_a_damaged_message_is_refused(given: str, named: str) -> None:
    text = encode(step(coordinator(), BEFORE_M, {}).message).decode().replace('"type":"ENTER"', '"type":"HB"')
    assert given in text
    with pytest.raises(DecodeError):
        decode(ZoneMessage, text.replace(given, named).encode())
