"""What guidance says, as bytes: what is repeated is what would be said anew, and only the same is repeated."""

from dataclasses import replace

from protocol.codec import encode
from protocol.messages import Command, GuidanceState, Movement, Reason, ReasonCode, Target
from server.guidance.decision import Decision, no_action
from server.guidance.view import View
from server.guidance.wording import Cycle, Wording

FIRST, SECOND = Cycle(3, 7, 1_000, 1_500), Cycle(4, 8, 2_000, 2_500)
REASON = Reason(code=ReasonCode.ROUTE, text='to "movement":x, "reason":y', since_ns=9)
DRIVES = View(
    Decision(Movement.MOVE_TO, REASON, target=Target(x=1.0, y=2.0), speed_mps=0.3, final=True, path=((0.0, 0.0), (1.0, 2.0))),
    box=((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)),
    carrot=(1.0, 2.0),
    leg=1,
)  # fmt: skip
IDLE = View(no_action(ReasonCode.IDLE))


def test_what_is_repeated_is_what_would_be_said_anew() -> None:
    views, repeating = {"a": DRIVES, "b-1": IDLE}, Wording()
    repeating.say(views, FIRST)
    repeated, anew = repeating.say(views, SECOND), Wording().say(views, SECOND)
    assert [each.encoded for each in repeated] == [each.encoded for each in anew]
    commands, states = repeated
    assert commands["a"] == Command(
        robot="a",
        epoch=4,
        sequence=8,
        stamp_ns=2_000,
        deadline_ns=2_500,
        movement=Movement.MOVE_TO,
        reason=REASON,
        target=Target(x=1.0, y=2.0),
        speed_mps=0.3,
        final=True,
        path=((0.0, 0.0), (1.0, 2.0)),
    )
    assert states["b-1"] == GuidanceState(robot="b-1", stamp_ns=2_000, reason=IDLE.decision.reason)
    assert {robot: encode(message) for robot, message in commands.items()} == commands.encoded


def test_what_changed_is_said_anew() -> None:
    wording = Wording()
    wording.say({"a": DRIVES}, FIRST)
    held = replace(DRIVES, decision=Decision(Movement.WAITING, REASON), blocked=True)
    commands, states = wording.say({"a": held}, SECOND)
    assert (commands["a"].movement, commands["a"].target, states["a"].blocked) == (Movement.WAITING, None, True)
    assert list(commands) == ["a"]
    assert len(states) == 1
