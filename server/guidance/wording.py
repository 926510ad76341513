"""What guidance says of each robot, as JSON. Where a robot is told the same as a cycle ago, as each one is that has nothing to
do, the message is made of the bytes of before with its new stamps: to build, check and encode it anew takes ten times as long,
and for a thousand robots more than there is between two cycles."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from pydantic import BaseModel

from protocol.codec import decode, encode
from protocol.messages import Command, GuidanceState
from server.guidance.view import View

M = TypeVar("M", bound=BaseModel)


class Worded(Mapping[str, M], Generic[M]):
    """Messages by robot that are encoded already; who looks at one gets it decoded."""

    def __init__(self, kind: type[M], encoded: Mapping[str, bytes]) -> None:
        self.encoded = encoded
        self._kind = kind

    def __getitem__(self, robot: str) -> M:
        return decode(self._kind, self.encoded[robot])

    def __iter__(self) -> Iterator[str]:
        return iter(self.encoded)

    def __len__(self) -> int:
        return len(self.encoded)


@dataclass(frozen=True, slots=True)
class Cycle:
    """What all commands of a cycle have in common."""

    epoch: int
    sequence: int
    now_ns: int
    deadline_ns: int


@dataclass(frozen=True, slots=True)
class _Said:
    """What was said of a view: the bytes of both messages but for their stamps."""

    view: View
    command: bytes
    state: bytes


class Wording:
    """Remembers what was said of each robot last. A view that is told again is to be the very same object."""

    def __init__(self) -> None:
        self._said: dict[str, _Said] = {}

    def say(self, views: Mapping[str, View], cycle: Cycle) -> tuple[Worded[Command], Worded[GuidanceState]]:
        """The command for every robot, and the state of each."""
        order = b'"epoch":%d,"sequence":%d,' % (cycle.epoch, cycle.sequence)
        stamp = b'"stamp_ns":%d,' % cycle.now_ns
        stamps = b'%b%b"deadline_ns":%d,' % (order, stamp, cycle.deadline_ns)
        commands, states = dict[str, bytes](), dict[str, bytes]()
        for robot, view in views.items():
            said = self._said.get(robot)
            if said is None or said.view is not view:
                command, state = encode(_command(robot, view, cycle)), encode(_state(robot, view, cycle))
                self._said[robot] = _Said(view, _from(command, b'"movement":'), _from(state, b'"reason":'))
            else:
                begin = b'{"robot":"%b",' % robot.encode()
                command, state = begin + stamps + said.command, begin + stamp + said.state
            commands[robot], states[robot] = command, state
        return Worded(Command, commands), Worded(GuidanceState, states)


def _from(encoded: bytes, field: bytes) -> bytes:
    """The rest of a message from a field on. The fields before it are numbers and an id: none of them can look like it."""
    return encoded[encoded.index(field) :]


def _command(robot: str, view: View, cycle: Cycle) -> Command:
    decision = view.decision
    return Command(
        robot=robot,
        epoch=cycle.epoch,
        sequence=cycle.sequence,
        stamp_ns=cycle.now_ns,
        deadline_ns=cycle.deadline_ns,
        movement=decision.movement,
        reason=decision.reason,
        target=decision.target,
        speed_mps=decision.speed_mps,
        final=decision.final,
        path=decision.path,
        action=decision.action,
        linear_mps=decision.linear_mps,
        angular_radps=decision.angular_radps,
    )


def _state(robot: str, view: View, cycle: Cycle) -> GuidanceState:
    return GuidanceState(
        robot=robot,
        stamp_ns=cycle.now_ns,
        reason=view.decision.reason,
        blocked=view.blocked,
        blockage=view.blockage,
        box=view.box,
        carrot=view.carrot,
        path=view.path,
        detour=view.detour,
        leg=view.leg,
    )
