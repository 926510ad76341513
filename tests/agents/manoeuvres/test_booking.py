"""No area is ever used by two robots, whatever the network does; and every guard of the protocol is needed for that."""

import copy
import inspect
import random
import types
from collections.abc import Callable

import hypothesis.strategies as st
import pytest
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from agents.manoeuvres import booking
from agents.manoeuvres.booking import Booking
from protocol.messages.zones import AreaUse, ZoneMessage
from tests.agents.manoeuvres.booking_world import KEPT, BookingWorld

CROSSING = (("a", "b"), ("b", "c"), ("c", "a"))
"""Three ways through three areas, each of which crosses both others."""
ACTIONS = ("claim", "withdraw", "acknowledge", "say", "deliver", "enter", "leave", "crash")
_WEIGHTS = (3, 0.3, 2, 5, 9, 5, 2, 0.4)


def walk(kind: type, seed: int, steps: int, wants: tuple[tuple[str, ...], ...] = CROSSING) -> BookingWorld:
    """Actions by chance."""
    chance = random.Random(seed)
    world = BookingWorld(kind, wants)
    robots = list(world.wants)
    for _ in range(steps):
        what = chance.choices(ACTIONS, _WEIGHTS)[0]
        world.act((what, chance.choice(robots), chance.choice(robots), chance.randrange(KEPT + 1)))
    return world


def test_no_area_is_used_twice_over_many_walks() -> None:
    lives = 0
    for seed in range(60):
        world = walk(Booking, seed, 400)
        lives += sum(vehicle.life for vehicle in world.vehicles.values())
    assert lives > 50  # minds did begin anew


# A guard's name, and where it stands in the module: how that reads, and how without the guard.
GUARDS = {
    "only the newest message counts": [("_age(message) <= _age(known.message)", "False")],
    "an acknowledgement names its claim": [
        (
            "number in record.message.acks.get(self.robot, ())",
            "bool(record.message.acks.get(self.robot))",
        )
    ],
    "all who matter must agree": [
        ("if not missing:\n            claim.established = True", "claim.established = True")
    ],
    "lower ranks first": [
        (
            "(theirs.rank, robot) < (claim.rank, self.robot)\n        ]\n        return {",
            "False\n        ]\n        return {",
        )
    ],
    "who is inside says so": [("if use.inside and use.area == area", "if False and use.area == area")],
}


@pytest.mark.parametrize("guard", GUARDS)
def test_every_guard_is_needed(guard: str) -> None:
    kind = _without(GUARDS[guard])
    with pytest.raises(AssertionError, match="is used by"):
        for seed in range(1000):
            walk(kind, seed, 400)


def test_everybody_gets_through_once_messages_arrive() -> None:
    for seed in range(100):
        assert not walk(Booking, seed, 100).settle()


def _without(guards: list[tuple[str, str]]) -> type:
    source = inspect.getsource(booking)
    for reads, instead in guards:
        assert source.count(reads) == 1, f"the module reads otherwise now: {reads!r}"
        source = source.replace(reads, instead)
    mutant = types.ModuleType("mutant")
    mutant.__dict__["__name__"] = booking.__name__
    exec(compile(source, "mutant", "exec"), mutant.__dict__)  # our own source
    return mutant.Booking


class BookingMachine(RuleBasedStateMachine):
    """The same by hypothesis, which looks for short ways to go wrong."""

    def __init__(self) -> None:
        super().__init__()
        self.world = BookingWorld(Booking, (("a", "b"), ("b", "a"), ("b",)))

    @rule(
        what=st.sampled_from(ACTIONS),
        robot=st.sampled_from(("r0", "r1", "r2")),
        other=st.sampled_from(("r0", "r1", "r2")),
        number=st.integers(0, KEPT),
    )
    def act(self, what: str, robot: str, other: str, number: int) -> None:
        self.world.act((what, robot, other, number))

    @invariant()
    def each_area_once(self) -> None:
        self.world.check()


TestBookingMachine = BookingMachine.TestCase
TestBookingMachine.settings = settings(max_examples=60, stateful_step_count=60, deadline=None)


def test_two_robots_and_an_area_in_every_order() -> None:
    """Everything that two robots can do about one area, to a depth of eight actions."""
    seen: set[str] = set()
    entered = 0
    frontier = [BookingWorld(Booking, (("a",), ("a",)))]
    for _ in range(8):
        following: list[BookingWorld] = []
        for world in frontier:
            for action in _choices(world):
                after = copy.deepcopy(world)
                after.act(action)
                key = _fingerprint(after)
                if key not in seen:
                    seen.add(key)
                    following.append(after)
                    entered += any(vehicle.inside for vehicle in after.vehicles.values())
        frontier = following
    assert len(seen) > 1500
    assert entered > 10


def _choices(world: BookingWorld) -> list[tuple[str, str, str, int]]:
    """What can be done, without what changes nothing: a robot claims once, says what it has to say and begins anew once."""
    found: list[tuple[str, str, str, int]] = []
    for robot, other in (("r0", "r1"), ("r1", "r0")):
        vehicle = world.vehicles[robot]
        if vehicle.claims == 0:
            found.append(("claim", robot, other, 0 if robot == "r1" else 1))
        if not vehicle.said or _content(vehicle.said[-1]) != _content(copy.deepcopy(vehicle.booking).message(_USES)):
            found.append(("say", robot, other, 0))
        found += [("deliver", robot, other, number) for number in range(len(vehicle.said))]
        found += [("enter", robot, other, 0), ("leave", robot, other, 0)]
        if vehicle.life == 0:
            found.append(("crash", robot, other, 1))
    return found


_USES = {"a": AreaUse("a", 0.0, 1.0)}


def _content(message: ZoneMessage) -> tuple[object, ...]:
    return message.boot, message.claims, tuple(sorted(message.acks.items()))


def _fingerprint(world: BookingWorld) -> str:
    return repr(
        [
            (sorted(vehicle.inside), vehicle.life, vehicle.claims, vehicle.said, sorted(vars(vehicle.booking).items()))
            for vehicle in world.vehicles.values()
        ]
    )


def message_after(*acts: Callable[[Booking], object]) -> ZoneMessage:
    made = Booking("r1", 5)
    for act in acts:
        act(made)
    return made.message(_USES)


def test_a_claim_is_established_when_all_that_matter_have_acknowledged_it() -> None:
    mine = Booking("r0", 1)
    claim = mine.claim(("a",), 10)
    assert mine.standing(claim, {"r1"}, 0.0).missing == {"r1"}
    mine.hear(message_after(lambda other: other.hear(mine.message(_USES), 0.0), Booking.acknowledge), 0.0)
    assert mine.standing(claim, {"r1"}, 0.0).open("a")
    assert claim.established


def test_one_that_has_not_been_heard_for_long_counts_as_silent_and_cannot_agree() -> None:
    mine = Booking("r0", 1, silent_s=0.5)
    claim = mine.claim(("a",), 10)
    mine.hear(message_after(lambda other: other.hear(mine.message(_USES), 0.0), Booking.acknowledge), 0.0)
    late = mine.standing(claim, {"r1"}, 0.6)
    assert late.silent == {"r1"}
    assert late.missing == {"r1"}


def test_a_claim_that_meets_an_established_one_is_made_anew_behind_it() -> None:
    first = Booking("r0", 1)
    firsts = first.claim(("a",), 100)
    assert first.standing(firsts, (), 0.0).open("a")  # nobody else is near
    second = Booking("r1", 1)
    seconds = second.claim(("a",), 50)
    number = seconds.number
    first.hear(second.message(_USES), 0.0)
    first.acknowledge()
    second.hear(first.message(_USES), 0.0)
    second.acknowledge()
    assert seconds.number > number
    assert seconds.rank >= 100  # of equal ranks the lower id goes first
    assert second.before(seconds)["a"] == ("r0",)


def test_a_booking_in_use_cannot_be_given_back() -> None:
    mine = Booking("r0", 1)
    claim = mine.claim(("a",), 10)
    claim.enter("a")
    with pytest.raises(ValueError, match="in use"):
        mine.withdraw(claim)
